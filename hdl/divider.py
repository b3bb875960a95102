"""Divider (Sec. 4.4): quotients up to a limit, a bit per clock."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.divider import QUOTIENT_BITS


class Divider(wiring.Component):
    """floor(256 · numerator / denominator), but no more than the limit.

    This is the magnitude in ``golden.divider.divide``. Restoring division: the remainder is
    doubled, and the denominator is subtracted from it if it is not larger. After the clock of
    ``load`` it takes ``quotient_bits`` enabled clocks. A limit above one half is one half of a
    denominator that is shifted up by as many places.

    Parameters
    ----------
    bits
        Width of numerator and denominator.
    quotient_bits
        The result of ``golden.divider.quotient_bits`` for the limit, by default one half.

    Members
    -------
    load
        Take the numerator.
    enable
        Find the next bit; not together with load.
    numerator, denominator
        Unsigned. The denominator, not 0, must stay until the last bit is found.
    quotient
        In units of 1/256, 0 to the limit.
    reached
        The quotient was cut: it is the limit or more.
    """

    def __init__(self, bits: int, quotient_bits: int = QUOTIENT_BITS) -> None:
        self._places = quotient_bits - QUOTIENT_BITS
        self._bits = bits + self._places
        super().__init__(
            {
                "load": In(1),
                "enable": In(1),
                "numerator": In(bits),
                "denominator": In(bits),
                "quotient": Out(quotient_bits),
                "reached": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        remainder = Signal(self._bits, reset_less=True)
        doubled = remainder << 1
        denominator = Cat(C(0, self._places), self.denominator) if self._places else self.denominator
        left = Signal(self._bits + 2)
        fits = ~left[-1]
        # a first bit that is set is one half already: no further bit may follow
        first, bit = Signal(), Signal()
        m.d.comb += [
            left.eq(doubled - denominator),
            bit.eq(fits & ~self.reached),
        ]
        with m.If(self.load):
            m.d.sync += [remainder.eq(self.numerator), first.eq(1), self.reached.eq(0)]
        with m.Elif(self.enable):
            m.d.sync += [
                remainder.eq(Mux(fits, left, doubled)),
                self.quotient.eq(Cat(bit, self.quotient[:-1])),
                first.eq(0),
            ]
            with m.If(first):
                m.d.sync += self.reached.eq(fits)
        return m
