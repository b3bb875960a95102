"""Preprocessing (Sec. 3.1): gradients from columns of pixels, and their differences."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Module, ShapeLike, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import SMOOTHING_SIZE
from hdl.build import Build
from hdl.parts.arithmetic import add_with_carry, magnitude
from hdl.parts.lanes import Lanes, deliver, each_lane, lanes_of
from hdl.parts.stream import Columns, Pipeline
from hdl.sample import pixels_shape

PIXEL_ROWS = SMOOTHING_SIZE + 2
"""Rows of pixels that give SMOOTHING_SIZE rows of gradients."""


def sizes_layout(build: Build) -> data.StructLayout:
    """|gx|, |gy|, and the size of their difference, or of gx - gy where gradients have a sign.

    The difference of signed gradients has one bit more than a gradient. With several pixels per
    clock each of the three may have either sign: only its square matters.
    """
    bits = build.pixel_bits
    difference = bits + 1 if build.algorithm.gradient == "signed" else bits
    shape = unsigned if build.pixels_per_clock == 1 else lambda size: signed(size + 1)
    return data.StructLayout({"gx": shape(bits), "gy": shape(bits), "difference": shape(difference)})


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

    With several pixels per clock there is no clock 2: tables find the squares of signed numbers.

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
            difference = gx.map(self._difference, gy)
            if self._lanes == 1:
                gx, gy = (
                    gradient.map(magnitude).register(f"{name}_size_{row}")
                    for name, gradient in (("gx", gx), ("gy", gy))
                )
                difference = difference.register(f"difference_{row}").map(magnitude)
            for lane, sizes in enumerate(each_lane(self.o.payload.data[row], self._lanes)):
                m.d.comb += [
                    sizes.gx.eq(gx.values[lane]),
                    sizes.gy.eq(gy.values[lane]),
                    sizes.difference.eq(difference.values[lane]),
                ]
        deliver(m, pipe, self.i, self.o, difference, lost=self._lost, more=2)
        return m

    def _difference(self, gx: Value, gy: Value) -> Value:
        """gx - gy, or a number of the size of | |gx| - |gy| |."""
        # that is |gx - gy| where the signs are equal, |gx + gy| where not
        subtract = C(1, 1) if self._signed else ~(gx[-1] ^ gy[-1])
        second = (gy.as_unsigned() ^ subtract.replicate(len(gy))).as_signed()
        return add_with_carry(gx, second, subtract)[: len(gx) + self._signed].as_signed()

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
