"""Tables of the generated pages."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

_ALIGN = {"l": "---", "r": "---:"}


def table(headings: Sequence[str], rows: Iterable[Sequence[str]], align: str = "l") -> str:
    """A table; ``align`` has l or r for each column, and what it leaves out is r."""
    sides = [_ALIGN[side] for side in align.ljust(len(headings), "r")]
    lines = [headings, sides, *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def number(value: float | None, digits: int = 0) -> str:
    """With commas between thousands; a dash where there is none."""
    return "–" if value is None else f"{value:,.{digits}f}"


def spread(value: float | None, interval: Sequence[float | None] | None, digits: int = 2) -> str:
    """A figure with its interval: 0.74 [0.68, 0.78]."""
    if value is None:
        return "–"
    if not interval or None in interval:
        return number(value, digits)
    return f"{number(value, digits)} [{number(interval[0], digits)}, {number(interval[1], digits)}]"


def figure(estimate: dict[str, Any] | None, digits: int = 2) -> str:
    """What ``evaluation.methods.bootstrap.estimate`` gives."""
    return "–" if estimate is None else spread(estimate["value"], estimate["interval"], digits)


def percent(estimate: dict[str, Any] | None) -> str:
    """A relative gain with its interval: +8 % [+6, +10]."""
    if estimate is None or estimate["value"] is None:
        return "–"
    text = f"{100 * estimate['value']:+.0f} %"
    if estimate["interval"] is None:
        return text
    low, high = estimate["interval"]
    return f"{text} [{100 * low:+.0f}, {100 * high:+.0f}]"
