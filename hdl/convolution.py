"""Convolution unit (Eq. 1): the separable 5x5 smoothing kernel out of adders, one unit for each of A, B and C."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Shape, ShapeLike
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.convolution import SHIFT
from golden.parameters import SMOOTHING_SIZE
from hdl.stream import Beat, Columns, Pipeline, WindowCounter


class ConvolutionUnit(wiring.Component):
    """Smooths one channel: kernel [1 2 2 2 1]ᵀ[1 2 2 2 1] / 64, rounded once, half away from zero.

    Takes columns of five rows, delivers rows four positions shorter.

    Parameters
    ----------
    shape
        One value, signed or not; the result has the same shape, because the kernel sums to 1.

    Members
    -------
    i
        Stream of ``Columns(shape, 5)``.
    o
        Stream of ``Beat(shape)``.
    """

    latency = 7

    def __init__(self, shape: ShapeLike) -> None:
        self._shape = Shape.cast(shape)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(shape, SMOOTHING_SIZE))),
                "o": Out(stream.Signature(Beat(shape))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        row = self.i.payload.data
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, SMOOTHING_SIZE, step=step, eol=self.i.payload.eol)

        # down the column: r0 + 2(r1 + r2 + r3) + r4
        outer = pipe.register(row[0] + row[4], "outer")
        inner = pipe.register(row[1] + row[2], "inner")
        third = pipe.register(row[3], "third")
        outer = pipe.register(outer, "outer_2")
        inner = pipe.register(inner + third, "inner_2")
        column = pipe.register(outer + (inner << 1), "column")

        # along the row: [1 1] * [1 1] * [1 0 1]; these registers move from beat to beat, not from clock to clock
        taps, beat = column, pipe.delay(pipe.valid, 3, "beat", reset=True)
        for k, distance in enumerate((1, 1, 2)):
            earlier = pipe.delay_beats(taps, distance, f"earlier_{k}", beat)
            taps = pipe.register(taps + earlier, f"taps_{k}")
            beat = pipe.register(beat, f"beat_{k}_done", reset=True)

        half = (1 << (SHIFT - 1)) - 1
        if self._shape.signed:
            rounded = pipe.register((taps + half + ~taps[-1]) >> SHIFT, "rounded")
        else:
            rounded = pipe.register((taps + half + 1) >> SHIFT, "rounded")

        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            self.o.payload.data.eq(rounded),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m
