# amaranth: UnusedElaboratable=no
"""Squares by embedded multipliers, in the place of a table in block RAM."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out


class SquareMultiplier(wiring.Component):
    """Squares of two numbers per clock, each by a multiplier with registers before and behind it.

    These are the registers that an embedded multiplier has; those of Cyclone IV multiply numbers of
    9 bits, or two of them together numbers of 18.

    Parameters, members and latency are those of :class:`hdl.parts.square_table.SquareTable`.
    """

    latency = 2
    memory_bits = 0

    def __init__(self, bits: int, *, signed_numbers: bool = False) -> None:
        square_bits = 2 * bits - 2 if signed_numbers else 2 * bits
        number = signed(bits) if signed_numbers else unsigned(bits)
        super().__init__(
            {
                "enable": In(1),
                "x": In(data.ArrayLayout(number, 2)),
                "square": Out(data.ArrayLayout(square_bits, 2)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for k in range(2):
            factor = Signal.like(self.x[k], name=f"factor_{k}", reset_less=True)
            product = Signal.like(self.square[k], name=f"product_{k}", reset_less=True)
            with m.If(self.enable):
                m.d.sync += [factor.eq(self.x[k]), product.eq(factor * factor)]
            m.d.comb += self.square[k].eq(product)
        return m
