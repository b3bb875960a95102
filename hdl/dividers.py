# amaranth: UnusedElaboratable=no
"""Which block finds the quotients of an offset, by ``Algorithm.divider``."""

from __future__ import annotations

from golden.algorithm import Divider
from hdl.serial_divider import SerialDivider
from hdl.table_divider import TableDivider


def make_divider(
    kind: Divider, mantissa_bits: int, limit: int, bits_per_clock: int = 1
) -> SerialDivider | TableDivider:
    """The divider of this kind that is done when the next products of mantissas are.

    Parameters
    ----------
    kind
        ``Algorithm.divider``.
    mantissa_bits, limit
        As in :class:`SerialDivider` and :class:`TableDivider`, which have the same members.
    bits_per_clock
        Bits of a mantissa that are multiplied per clock, 1 or 2. The serial divider finds one bit
        per clock for both: a quotient within half a pixel has no more than 8.
    """
    if kind == "serial":
        return SerialDivider(mantissa_bits, limit)
    return TableDivider(mantissa_bits, limit, bits_per_clock)
