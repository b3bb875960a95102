"""The pixel at the centre of each response, which rides along with it to the gradient step."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal, unsigned
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.parts.delay_line import DelayLine

COLUMNS_BACK = 3
"""Columns from a response's centre to the newest column of pixels that it is made of."""


class CentrePixels(wiring.Component):
    """Delays pixels for as long as the blocks beside it, which move in step, make responses.

    Parameters
    ----------
    clocks
        Latency of those blocks.

    Members
    -------
    enable
        The blocks beside it move.
    step
        They take a column: only together with ``enable``.
    i
        The pixel of that column's middle row.
    o
        The pixel COLUMNS_BACK columns before, so many enabled clocks later: at the centre of the
        response that then leaves the last block.
    """

    def __init__(self, parameters: Parameters, clocks: int) -> None:
        pixel = unsigned(parameters.pixel_bits)
        self._clocks = clocks
        super().__init__({"enable": In(1), "step": In(1), "i": In(pixel), "o": Out(pixel)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.line = line = DelayLine(self.i.shape(), self._clocks)
        pixel = self.i
        for k in range(COLUMNS_BACK):
            before = Signal.like(pixel, name=f"before_{k + 1}", reset_less=True)
            with m.If(self.step):
                m.d.sync += before.eq(pixel)
            pixel = before
        m.d.comb += [line.enable.eq(self.enable), line.i.eq(pixel), self.o.eq(line.o)]
        return m
