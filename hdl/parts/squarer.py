# amaranth: UnusedElaboratable=no
"""Squares of two numbers per clock: from a table, or by multipliers."""

from __future__ import annotations

from hdl.parts.square_multiplier import SquareMultiplier
from hdl.parts.square_table import SquareTable

Squarer = SquareTable | SquareMultiplier
LATENCY = SquareTable.latency
"""Enabled clocks from a number to its square, of either kind."""


def make_squarer(
    bits: int, *, signed_numbers: bool = False, stores_odd: bool = False, multiplies: bool = False
) -> Squarer:
    """A table, or two multipliers: the same members, the same squares at the same time.

    Parameters
    ----------
    bits, signed_numbers, stores_odd
        See :class:`hdl.parts.square_table.SquareTable`; multipliers do not need the last.
    multiplies
        Multipliers, not a table.
    """
    if multiplies:
        return SquareMultiplier(bits, signed_numbers=signed_numbers)
    return SquareTable(bits, signed_numbers=signed_numbers, stores_odd=stores_odd)
