"""What the dividers have in common: two quotients by one denominator, at the refinement's pace."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import signed
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from golden.divider import quotient_bits

PHASE_BITS = 5


def axes(bits: int) -> data.StructLayout:
    """A signed number of so many bits for each axis."""
    return data.StructLayout({"x": signed(bits), "y": signed(bits)})


def divider_members(mantissa_bits: int, limit: int) -> dict[str, Any]:
    """Members of a divider for products of mantissas.

    load
        Take the operands.
    phase
        0 in the clock after ``load``, then counting up; it may stay where it is from ``clocks`` on.
    numerator
        Sums of two products, for x and for y.
    denominator
        Not 0, where ``usable``.
    usable
        From the clock after ``load`` on: otherwise both quotients are 0, and not reached.
    take
        Give the quotients of these operands: in the phase ``clocks`` or later, also with the next
        ``load``.
    quotient
        In units of 1/128, within ± the limit, from the clock after ``take`` on.
    reached
        A quotient is as large as the limit.
    """
    return {
        "load": In(1),
        "phase": In(PHASE_BITS),
        "numerator": In(axes(2 * mantissa_bits + 2)),
        "denominator": In(2 * mantissa_bits),
        "usable": In(1),
        "take": In(1),
        "quotient": Out(axes(quotient_bits(limit))),
        "reached": Out(1),
    }
