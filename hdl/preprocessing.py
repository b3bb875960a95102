"""Preprocessing (Sec. 3.1): gradients from columns of pixels, and their differences."""

from __future__ import annotations

from functools import partial
from typing import Any

from amaranth.hdl import C, Module, Shape, ShapeLike, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import SMOOTHING_SIZE
from hdl.build import Build
from hdl.gradient_squares import gradient_difference
from hdl.parts.arithmetic import add_with_carry, magnitude
from hdl.parts.lanes import Lanes, deliver, each_lane, lanes_of
from hdl.parts.optional import optional
from hdl.parts.stream import Columns, Pipeline
from hdl.sample import pixels_shape

PIXEL_ROWS = SMOOTHING_SIZE + 2
"""Rows of pixels that give SMOOTHING_SIZE rows of gradients."""


def sizes_layout(build: Build) -> data.StructLayout:
    """|gx|, |gy|, and the size of their difference, or of gx - gy where gradients have a sign.

    With several pixels per clock gx and gy only, which have a sign.
    """
    gradient, difference = gradient_shape(build), difference_shape(build)
    alone = build.pixels_per_clock == 1
    return data.StructLayout({"gx": gradient, "gy": gradient, **optional(alone, difference=difference)})


def gradient_shape(build: Build) -> Shape:
    """Of what is squared of a gradient: with several pixels per clock it may have either sign."""
    bits = build.pixel_bits
    return unsigned(bits) if build.pixels_per_clock == 1 else signed(bits + 1)


def difference_shape(build: Build) -> Shape:
    """The same of a difference; that of signed gradients has one bit more than a gradient."""
    gradient = gradient_shape(build)
    return Shape(gradient.width + (build.algorithm.gradient == "signed"), gradient.signed)


def sizes_shape(build: Build) -> ShapeLike:
    """The sizes of a beat: ``sizes_layout(build)``, or an array of it, the leftmost first."""
    return lanes_of(sizes_layout(build), build.pixels_per_clock)


class Preprocessing(wiring.Component):
    """Sizes of the gradients and of their differences, for the five rows of a column.

    Takes columns of seven rows of pixels, delivers rows two columns shorter. The gradients of a
    pixel are made anew for each of the five rows of the smoothing window that it passes: pixels
    wait in less memory.

        clock 1   gx, gy
        clock 2   |gx|, |gy|, and ±(|gx| - |gy|) (absolute) or gx - gy (signed)

    With several pixels per clock there is no clock 2, and gx and gy are delivered: tables find the
    squares of signed numbers.

    With ``derivative="sobel"`` gx and gy come two clocks later: three rows of each column are added
    up, and the column two before is subtracted; differences of two rows are added up along the row,
    twice two neighbours; then both are rounded.

    The size of the difference comes from an adder, not from a register: the next block should not
    compute with it.

    Parameters
    ----------
    parameters
        Parameters of the detector.

    Members
    -------
    i
        Stream of ``Columns(pixels_shape(parameters), 7)``.
    o
        Stream of ``Columns(sizes_shape(parameters), 5)``.
    """

    def __init__(self, parameters: Build) -> None:
        self._signed = parameters.algorithm.gradient == "signed"
        self._sobel = parameters.algorithm.derivative == "sobel"
        self._lost = 2 * parameters.algorithm.pixel_passes
        self._lanes = parameters.pixels_per_clock
        super().__init__(
            {
                "i": In(stream.Signature(Columns(pixels_shape(parameters), PIXEL_ROWS))),
                "o": Out(stream.Signature(Columns(sizes_shape(parameters), SMOOTHING_SIZE))),
            }
        )

    @property
    def latency(self) -> int:
        return (2 if self._lanes == 1 else 1) + (2 if self._sobel else 0)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        newest = self.i.payload.data
        rows = [Lanes(pipe, each_lane(newest[k], self._lanes), f"pixel_{k}") for k in range(PIXEL_ROWS)]
        for row in range(SMOOTHING_SIZE):
            make = self._smoothed if self._sobel else self._gradients
            above, here, below = rows[row : row + 3]
            gx, gy = make(above, here, below, row)
            numbers = {"gx": gx, "gy": gy}
            if self._lanes == 1:
                difference = gx.map(partial(gradient_difference, signed=self._signed), gy)
                numbers = {
                    name: gradient.map(magnitude).register(f"{name}_size_{row}")
                    for name, gradient in numbers.items()
                }
                numbers["difference"] = difference.register(f"difference_{row}").map(magnitude)
            for lane, sizes in enumerate(each_lane(self.o.payload.data[row], self._lanes)):
                m.d.comb += [sizes[name].eq(value.values[lane]) for name, value in numbers.items()]
        deliver(m, pipe, self.i, self.o, numbers["gx"], lost=self._lost, more=2)
        return m

    @staticmethod
    def _gradients(above: Lanes, here: Lanes, below: Lanes, row: int) -> tuple[Lanes, Lanes]:
        """gx and gy, signed. The window's centre is the column before the newest."""
        gx = (here.back(2) - here).register(f"gx_{row}")
        return gx, (above.back(1) - below.back(1)).register(f"gy_{row}")

    @staticmethod
    def _smoothed(above: Lanes, here: Lanes, below: Lanes, row: int) -> tuple[Lanes, Lanes]:
        """gx and gy, smoothed across; two clocks later than without."""
        # the window's centre is one column behind the newest
        down = (above + below).map(lambda ends, middle: ends + (middle << 1), here).register(f"down_{row}")
        gx = (down.back(2) - down).register(f"gx_sum_{row}")
        slope = (above - below).register(f"slope_{row}")
        slopes = slope.map(lambda here, left: here + left, slope.back(1), name=f"slopes_{row}")
        gy = (slopes + slopes.back(1)).register(f"gy_sum_{row}")
        return gx.map(_quarter).register(f"gx_{row}"), gy.map(_quarter).register(f"gy_{row}")


def _quarter(value: Value) -> Value:
    """A quarter, rounded to nearest, halves away from zero."""
    return add_with_carry(value, C(1, 2).as_signed(), ~value[-1])[2 : len(value)].as_signed()
