# amaranth: UnusedElaboratable=no
"""Serial divider: both quotients of an offset at once, a bit per clock."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring

from golden.divider import quotient_bits
from hdl.divider import Divider
from hdl.parts.arithmetic import magnitude
from hdl.parts.quotients import divider_members


class SerialDivider(wiring.Component):
    """Quotients as ``golden.divider.divide`` has them, exact and rounded.

    Where a numerator is the most negative number, which has no magnitude, its quotient is 0; no
    surface with a peak has such a one.

    Parameters
    ----------
    mantissa_bits
        Bits of the factors whose products it divides.
    limit
        Largest size of a quotient, in units of 1/128, a power of two.

    Members
    -------
    See :func:`hdl.parts.quotients.divider_members`.
    """

    def __init__(self, mantissa_bits: int, limit: int) -> None:
        self._bits = 2 * mantissa_bits + 1
        self.clocks = quotient_bits(limit)
        self._dividers = {axis: Divider(self._bits, self.clocks) for axis in "xy"}
        super().__init__(divider_members(mantissa_bits, limit))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        denominator = Signal(self._bits, reset_less=True)
        with m.If(self.load):
            m.d.sync += denominator.eq(self.denominator)
        reached = []
        for axis, divider in self._dividers.items():
            m.submodules[f"divider_{axis}"] = divider
            numerator = self.numerator[axis]
            negative = Signal(name=f"negative_{axis}", reset_less=True)
            with m.If(self.load):
                m.d.sync += negative.eq(numerator[-1])
            m.d.comb += [
                divider.load.eq(self.load),
                divider.enable.eq(self.phase < self.clocks),
                divider.numerator.eq(magnitude(numerator)),
                divider.denominator.eq(denominator),
            ]
            # half of it, rounded away from zero: for a negative one, minus the quotient rounded
            # down
            rounded = Cat(divider.quotient ^ negative.replicate(self.clocks), negative) + 1
            with m.If(self.take):
                m.d.sync += self.quotient[axis].eq(
                    rounded[1 : self.clocks + 1] & self.usable.replicate(self.clocks)
                )
            reached.append(divider.reached)
        with m.If(self.take):
            m.d.sync += self.reached.eq(self.usable & Cat(reached).any())
        return m
