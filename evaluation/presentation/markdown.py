"""Tables as Markdown, for the generated pages."""

from __future__ import annotations

from evaluation.presentation.table import Name, Strong, Table


def markdown(table: Table) -> str:
    """The table alone, without its title and notes."""
    sides = ["---" if index < table.names else "---:" for index in range(len(table.headings))]
    lines = [[_cell(each) for each in line] for line in (table.headings, *table.rows)]
    lines.insert(1, sides)
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def titled(table: Table) -> str:
    """The table below its title and above its notes."""
    parts = [f"**{table.title}**", markdown(table), table.notes]
    return "\n\n".join(part for part in parts if part)


def _cell(text: str) -> str:
    if isinstance(text, Name):
        return f"`{text}`"
    return f"**{text}**" if isinstance(text, Strong) else text
