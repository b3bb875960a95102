"""Numbers as text, each kind in one place."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def number(value: float | None, digits: int = 0) -> str:
    """A number with commas between thousands; a dash for None."""
    return "–" if value is None else f"{value:,.{digits}f}"


def spread(value: float | None, interval: Sequence[float | None] | None, digits: int = 2) -> str:
    """A figure with its interval: 0.74 [0.68, 0.78]."""
    if value is None:
        return "–"
    if not interval or None in interval:
        return number(value, digits)
    return f"{number(value, digits)} [{number(interval[0], digits)}, {number(interval[1], digits)}]"


def figure(estimate: dict[str, Any] | None, digits: int = 2) -> str:
    """A result of ``evaluation.methods.bootstrap.estimate``."""
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


def listed(values: Sequence[float]) -> str:
    """Numbers as in a sentence: 0, 3 and 6."""
    *first, last = (f"{value:g}" for value in values)
    return f"{', '.join(first)} and {last}" if first else last


def share(value: float) -> str:
    """A part of a whole: 12 %."""
    return f"{100 * value:.0f} %"
