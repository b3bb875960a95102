"""Checks of arguments: each refuses in one line with the name, the value and what is allowed."""

from __future__ import annotations

import sys
from numbers import Integral, Real
from typing import TypeGuard


def is_whole(value: object) -> TypeGuard[int]:
    """Is this a whole number? NumPy's integers are as good as Python's; truth values are not."""
    return isinstance(value, Integral) and not isinstance(value, bool)


def check_type(name: str, value: object, kind: type) -> None:
    """Raise ``TypeError`` unless the value is of this kind."""
    if not isinstance(value, kind):
        raise TypeError(f"{name} is a {type(value).__name__}; allowed: {kind.__name__}")


def check_integer(field: str, value: object, low: int, high: int) -> None:
    """Raise ``ValueError`` unless the value is a whole number from ``low`` to ``high``."""
    if not (is_whole(value) and low <= int(value) <= high):
        raise ValueError(f"{field} is {value!r}; allowed: whole numbers from {low} to {high}")


def check_choice(field: str, value: object, choices: tuple[str, ...]) -> None:
    """Raise ``ValueError`` unless the value is one of the choices."""
    # an array would compare itself with each of them
    if not isinstance(value, str) or value not in choices:
        raise ValueError(f"{field} is {value!r}; allowed: {', '.join(choices)}")


def check_switch(field: str, value: object) -> None:
    """Raise ``ValueError`` unless the value is a truth value."""
    if not isinstance(value, bool):
        raise ValueError(f"{field} is {value!r}; allowed: True or False")


def check_distance(name: str, value: object) -> None:
    """Raise ``ValueError`` unless the value is a distance in pixels."""
    if not _is_within(value, sys.float_info.max):
        raise ValueError(f"{name} is {value!r}; allowed: numbers of pixels from 0")


def _is_within(value: object, most: float) -> TypeGuard[float]:
    """Is this a number from 0 to ``most``, and not NaN?

    It is compared without a conversion, because a float does not hold every whole number.
    """
    return isinstance(value, Real) and not isinstance(value, bool) and bool(0 <= value <= most)  # type: ignore[operator]


def plain_integer(frozen: object, field: str, low: int, high: int) -> None:
    """:func:`check_integer` for a field of a frozen dataclass; it becomes Python's own integer."""
    value = getattr(frozen, field)
    check_integer(field, value, low, high)
    object.__setattr__(frozen, field, int(value))


def check_fraction(field: str, value: object, limit: int, bits: int) -> None:
    """Raise ``ValueError`` unless the value is 0, or below the limit and not rounded to 0.

    It is rounded to ``bits`` fractional bits.
    """
    if not _is_within(value, limit) or value == limit:
        raise ValueError(f"{field} is {value!r}; allowed: 0 <= {field} < {limit}")
    if float(value) > 0 and round(float(value) * (1 << bits)) == 0:
        step = f"1/{1 << bits}"
        raise ValueError(f"{field} is {value!r}, less than half of {step}; allowed: 0, or {step} and more")
