"""Surface fit (Sec. 3.4, Eq. 10): derivatives of a quadratic surface through 3x3 responses."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from amaranth.hdl import Cat, Module, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.algorithm import Fit
from golden.derivatives import Derivatives
from golden.parameters import Parameters
from hdl.derivatives import Format, Formats, layout
from hdl.parts.stream import Columns, Pipeline, WindowCounter
from hdl.sample import response_layout, responses


class SurfaceFit(wiring.Component):
    """Derivatives of the surface fitted around the middle of three columns.

    Everything is a sum along columns first, and then of neighbouring columns' sums.

    Raises
    ------
    ValueError
        Only the golden model has this fit.

    Members
    -------
    i
        Stream of ``Columns(response_layout(parameters), 3)``.
    o
        Stream of derivatives in their :meth:`formats`, one for every column but the first two of a
        row.
    """

    latency = 3
    reads = "centres"

    def __init__(self, parameters: Parameters) -> None:
        self._derivatives = _surface(parameters).derivatives
        super().__init__(
            {
                "i": In(stream.Signature(Columns(response_layout(parameters), 3))),
                "o": Out(stream.Signature(layout(self.formats(parameters), self.unit(parameters)))),
            }
        )

    @staticmethod
    def formats(parameters: Parameters) -> Formats:
        """Formats of the derivatives, in units of :meth:`unit`."""
        return _surface(parameters).formats

    @staticmethod
    def unit(parameters: Parameters) -> int:
        """A full response."""
        return parameters.response_max

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        window = WindowCounter(m, 3, step=pipe.valid & pipe.advance, eol=self.i.payload.eol)
        for name, value in self._derivatives(pipe, responses(self.i.payload))._asdict().items():
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

    def stored(value: Value, name: str) -> Value:
        return pipe.register(value, name, when=beat_2)

    # suffix _1, _2: of the column before, and of the one before that
    level_1, bend_1, slope_1 = stored(level, "level_1"), stored(bend, "bend_1"), stored(slope, "slope_1")
    slope_2 = stored(slope_1, "slope_2")
    rise = level - level_1
    rise_1 = stored(rise, "rise_1")
    bends_1, slopes_1 = stored(bend + bend_1, "bends_1"), stored(slope + slope_1, "slopes_1")
    twist = slope - slope_2
    return Derivatives(
        xx=stored(rise_1 - rise, "xx"),
        yy=stored(bends_1 + bend, "yy"),
        xy=stored((twist << 1) + twist, "xy"),
        x=stored(rise_1 + rise, "x"),
        y=stored(slopes_1 + slope, "y"),
    )


def _six_samples(pipe: Pipeline, column: list[Value]) -> Derivatives[Value]:
    """The surface through the paper's S0 S3 S5 S7 S2 S6: corners, and left, right, lower middle."""
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


class Surface(NamedTuple):
    """Formats of a surface's derivatives, in full responses, and the function that makes them."""

    formats: Formats
    derivatives: Callable[[Pipeline, list[Value]], Derivatives[Value]]


_NINE = Surface(
    Derivatives(Format(2, 6), Format(2, 6), Format(0, 6), Format(1, 3), Format(1, 3)), _nine_samples
)
SURFACES: dict[Fit, Surface] = {
    "nine": _NINE,
    "six": Surface(
        Derivatives(Format(1, 5), Format(1, 2), Format(0, 2), Format(0, 1), Format(0, 2)), _six_samples
    ),
    # its steps begin at the peak of this surface
    "gradient": _NINE,
}


def _surface(parameters: Parameters) -> Surface:
    fit = parameters.algorithm.fit
    if fit not in SURFACES:
        raise ValueError(f"fit is {fit!r}; allowed in hardware: {', '.join(SURFACES)}")
    return SURFACES[fit]
