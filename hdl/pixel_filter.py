"""Pixel filter: every pixel smoothed by [1 2 1]ᵀ[1 2 1] / 16 before the gradients."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Value, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.parts.stream import Beat, Columns, Pipeline, WindowCounter

FILTER_ROWS = 3
"""Rows of pixels that one smoothed row needs."""


class PixelFilter(wiring.Component):
    """One pass of ``golden.pixel_filter``: rows come out two positions shorter.

        clock 1   a + 2b + c down the column
        clock 2   the same along the row: each column meets the two before it in a chain of adders

    Members
    -------
    i
        Stream of ``Columns(unsigned(pixel_bits), 3)``.
    o
        Stream of ``Beat(unsigned(pixel_bits))``.
    """

    latency = 2

    def __init__(self, parameters: Parameters) -> None:
        pixel = unsigned(parameters.pixel_bits)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(pixel, FILTER_ROWS))),
                "o": Out(stream.Signature(Beat(pixel))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        window = WindowCounter(m, FILTER_ROWS, step=pipe.valid & pipe.advance, eol=self.i.payload.eol)
        beat = pipe.register(pipe.valid, "beat", reset=True)
        down = pipe.register(binomial(*self.i.payload.data), "down")
        one = pipe.register(down, "one", when=beat)
        three = pipe.register(one + (down << 1), "three", when=beat)
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            self.o.payload.data.eq(pipe.register((three + down)[4:], "smoothed")),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m


def binomial(above: Value, here: Value, below: Value) -> Value:
    """a + 2b + c + 2: columns of weights 1, 2 and 1 so add the half that rounds their mean."""
    # both ones enter where the adders have room for them
    ends = (Cat(C(1, 1), above) + Cat(C(1, 1), below))[1:]
    return (ends + Cat(C(1, 1), here))[: len(here) + 2]
