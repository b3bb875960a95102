"""Squares by look-up: a table in block RAM takes the place of a multiplier."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

LOGIC_BITS = 5
"""Low bits of a square that logic makes: x² mod 2**(k+1) depends on the low k bits of x, here at most 4."""


class SquareTable(wiring.Component):
    """Squares of two unsigned numbers per clock, by the two ports of one table.

    Latency 2: the memory's own register and one behind it, both part of the block RAM. Stored is x² without its
    lowest five bits: bit 0 is x's own, bit 1 is 0, the three next are functions of at most four bits of x.

    Parameters
    ----------
    bits
        Width of the numbers, from 3 (signed: 4).
    signed_numbers
        They are in two's complement; the most negative one must not occur.

    Members
    -------
    enable
        The registers move: ``advance`` of the pipeline around.
    x
        The two numbers.
    square
        Their squares, ``2·bits`` wide (signed: two less), two enabled clocks later.
    """

    latency = 2

    def __init__(self, bits: int, *, signed_numbers: bool = False) -> None:
        fewest = 4 if signed_numbers else 3
        if bits < fewest:
            # their squares have nothing above what logic makes
            raise ValueError(f"bits is {bits}; allowed: whole numbers from {fewest}")
        self._bits = bits
        self._signed = signed_numbers
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
        return (self._square_bits - LOGIC_BITS) << self._bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        size = 1 << self._bits
        # the place of the most negative number stays empty
        numbers = [*range(size // 2), 0, *range(1 - size // 2, 0)] if self._signed else range(size)
        m.submodules.table = table = Memory(
            shape=self._square_bits - LOGIC_BITS,
            depth=size,
            init=[x * x >> LOGIC_BITS for x in numbers],
            attrs={"ram_style": "block"},
        )
        for k in range(2):
            x, port = Value.cast(self.x[k]).as_unsigned(), table.read_port()
            m.d.comb += [port.addr.eq(x), port.en.eq(self.enable)]
            high = Signal(len(port.data), name=f"high_{k}", reset_less=True)
            low = Signal(LOGIC_BITS - 1, name=f"low_{k}", reset_less=True)
            low_before = Signal.like(low, name=f"low_before_{k}")
            with m.If(self.enable):
                m.d.sync += [high.eq(port.data), low_before.eq(_low(x)), low.eq(low_before)]
            m.d.comb += self.square[k].eq(Cat(low[0], C(0, 1), low[1:], high))
        return m


def _low(x: Value) -> Value:
    """Bits 0, 2, 3 and 4 of x²; (2a)² = 4a², and (2a + 1)² = 1 + 8·(0 + 1 + ... + a)."""
    x0, x1, x2 = x[0], x[1], x[2]
    x3 = x[3] if len(x) > 3 else C(0, 1)
    return Cat(x0, ~x0 & x1, x0 & (x1 ^ x2), Mux(x0, x2 ^ x3, ~x1 & x2))
