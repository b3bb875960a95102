"""Surface fit (Sec. 3.4, Eq. 10): derivatives of a quadratic surface through the 3x3 responses of
every pixel.
"""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Value, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.derivatives import Derivatives
from golden.parameters import Parameters
from hdl.derivatives import derivatives_layout
from hdl.parts.stream import Columns, Pipeline, WindowCounter


class SurfaceFit(wiring.Component):
    """Derivatives of the surface fitted around the middle of three columns.

    Everything is a sum along columns first, and then of neighbouring columns' sums.

    Members
    -------
    i
        Stream of ``Columns(unsigned(response_bits), 3)``.
    o
        Stream of ``derivatives_layout(parameters)``, one for every column but the first two of a
        row.
    """

    latency = 3

    def __init__(self, parameters: Parameters) -> None:
        self._fit = parameters.algorithm.fit
        super().__init__(
            {
                "i": In(stream.Signature(Columns(unsigned(parameters.response_bits), 3))),
                "o": Out(stream.Signature(derivatives_layout(parameters))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        window = WindowCounter(m, 3, step=pipe.valid & pipe.advance, eol=self.i.payload.eol)
        fit = _nine_samples if self._fit == "nine" else _six_samples
        for name, value in fit(pipe, [self.i.payload.data[row] for row in range(3)])._asdict().items():
            m.d.comb += self.o.payload[name].eq(value)
        m.d.comb += self.o.valid.eq(
            pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)
        )
        return m


def _nine_samples(pipe: Pipeline, column: list[Value]) -> Derivatives[Value]:
    """Least squares over the nine samples."""
    top, middle, bottom = column
    beat_1 = pipe.register(pipe.valid, "beat_1", reset=True)
    beat_2 = pipe.register(beat_1, "beat_2", reset=True)
    ends = pipe.register(top + bottom, "ends")
    middle = pipe.register(middle, "middle")
    slope = pipe.register(bottom - top, "slope")

    level = pipe.register(ends + middle, "level")
    bend = pipe.register((middle << 1) - ends, "bend")
    slope = pipe.register(slope, "slope_now")

    def kept(value: Value, name: str) -> Value:
        return pipe.register(value, name, when=beat_2)

    # suffix _1, _2: of the column before, and of the one before that
    level_1, bend_1, slope_1 = kept(level, "level_1"), kept(bend, "bend_1"), kept(slope, "slope_1")
    slope_2 = kept(slope_1, "slope_2")
    rise = level - level_1
    rise_1 = kept(rise, "rise_1")
    bends_1, slopes_1 = kept(bend + bend_1, "bends_1"), kept(slope + slope_1, "slopes_1")
    twist = slope - slope_2
    return Derivatives(
        xx=kept(rise_1 - rise, "xx"),
        yy=kept(bends_1 + bend, "yy"),
        xy=kept((twist << 1) + twist, "xy"),
        x=kept(rise_1 + rise, "x"),
        y=kept(slopes_1 + slope, "y"),
    )


def _six_samples(pipe: Pipeline, column: list[Value]) -> Derivatives[Value]:
    """The surface through the paper's S0 S3 S5 S7 S2 S6: corners, left and right middle, and the
    bottom's middle.
    """
    beat_1 = pipe.register(pipe.valid, "beat_1", reset=True)
    beat_2 = pipe.register(beat_1, "beat_2", reset=True)
    now = pipe.delay(Cat(*column), 2, "column")
    before = pipe.register(now, "column_1", when=beat_2)
    bits = len(column[0])

    def sample(source: Value, row: int) -> Value:
        return source[row * bits : (row + 1) * bits]

    first = pipe.register(before, "column_2", when=beat_2)
    s0, s3, s6 = (sample(first, row) for row in range(3))
    s7 = sample(before, 2)
    s2, s5 = sample(now, 0), sample(now, 1)
    middle = s5 - s3
    top, bottom = s2 - s0, s7 - s6

    def result(value: Value, name: str) -> Value:
        return pipe.register(value, name, when=beat_2)

    return Derivatives(
        xx=result(top + ((bottom - middle) << 1), "xx"),
        yy=result((s3 << 1) - (s0 + s6), "yy"),
        xy=result(middle - top, "xy"),
        x=result(middle, "x"),
        y=result(middle + (s6 - s2), "y"),
    )
