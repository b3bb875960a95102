"""Neutral tables for the terminal."""

from __future__ import annotations

from rich import table as rich

from evaluation.presentation.table import Strong, Table


def terminal(table: Table) -> rich.Table:
    """The table with its title above and its notes below; a star marks cells that stand out."""
    cells = [*table.headings, *(cell for row in table.rows for cell in row)]
    star = "* The profile's own, or the default." if any(isinstance(cell, Strong) for cell in cells) else ""
    shown = rich.Table(title=table.title, caption=" ".join(filter(None, (table.notes, star))) or None)
    for index, heading in enumerate(table.headings):
        named = index < table.names
        shown.add_column(_text(heading), justify="left" if named else "right", no_wrap=named)
    for row in table.rows:
        shown.add_row(*map(_text, row))
    return shown


def _text(cell: str) -> str:
    return f"{cell} *" if isinstance(cell, Strong) else str(cell)
