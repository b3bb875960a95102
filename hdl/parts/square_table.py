"""Squares by look-up: a table in block RAM takes the place of a multiplier."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

UNSTORED_BITS = 2
"""Low bits of a square that need not be stored: bit 0 is that of x, bit 1 is 0."""


class SquareTable(wiring.Component):
    """Squares of two unsigned numbers per clock, by the two ports of one table.

    Latency 2: the memory's own register and one behind it, both part of the block RAM.

    Parameters
    ----------
    bits
        Width of the numbers, from 2 (signed: 3).
    signed_numbers
        They are in two's complement; the most negative one must not occur.
    stores_odd
        Bit 0 of a square comes out of the memory, too, not from registers beside it: that saves
        four of them, and takes a bit more for each word.

    Members
    -------
    enable
        The registers move: ``advance`` of the pipeline around.
    x
        The two numbers.
    square
        Their squares, ``2·bits`` wide (signed: two less), two enabled clocks later.

    Raises
    ------
    ValueError
        ``bits`` is too small.
    """

    latency = 2

    def __init__(self, bits: int, *, signed_numbers: bool = False, stores_odd: bool = False) -> None:
        fewest = 3 if signed_numbers else 2
        if bits < fewest:
            # their squares have nothing above what is not stored
            raise ValueError(f"bits is {bits}; allowed: whole numbers from {fewest}")
        self._bits = bits
        self._signed = signed_numbers
        self._stores_odd = stores_odd
        self._square_bits = 2 * bits - 2 if signed_numbers else 2 * bits
        number = signed(bits) if signed_numbers else unsigned(bits)
        super().__init__(
            {
                "enable": In(1),
                "x": In(data.ArrayLayout(number, 2)),
                "square": Out(data.ArrayLayout(self._square_bits, 2)),
            }
        )

    @property
    def memory_bits(self) -> int:
        return self._word_bits << self._bits

    @property
    def _word_bits(self) -> int:
        return self._square_bits - UNSTORED_BITS + self._stores_odd

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        size = 1 << self._bits
        # the place of the most negative number stays empty
        numbers = [*range(size // 2), 0, *range(1 - size // 2, 0)] if self._signed else range(size)
        m.submodules.table = table = Memory(
            shape=self._word_bits,
            depth=size,
            init=[self._word(x) for x in numbers],
            attrs={"ram_style": "block"},
        )
        for k in range(2):
            x, port = Value.cast(self.x[k]).as_unsigned(), table.read_port()
            m.d.comb += [port.addr.eq(x), port.en.eq(self.enable)]
            high = Signal(len(port.data), name=f"high_{k}", reset_less=True)
            with m.If(self.enable):
                m.d.sync += high.eq(port.data)
            if self._stores_odd:
                m.d.comb += self.square[k].eq(Cat(high[0], C(0, 1), high[1:]))
                continue
            odd = Signal(name=f"odd_{k}", reset_less=True)
            odd_before = Signal.like(odd, name=f"odd_before_{k}")
            with m.If(self.enable):
                m.d.sync += [odd_before.eq(x[0]), odd.eq(odd_before)]
            m.d.comb += self.square[k].eq(Cat(odd, C(0, 1), high))
        return m

    def _word(self, x: int) -> int:
        """What is stored of a square."""
        high = x * x >> UNSTORED_BITS
        return high << 1 | x & 1 if self._stores_odd else high
