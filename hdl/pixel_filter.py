"""Pixel filter: every pixel smoothed by [1 2 1]ᵀ[1 2 1] / 16 before the gradients."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.parts.lanes import Lanes, deliver, each_lane
from hdl.parts.stream import Beat, Columns, Pipeline
from hdl.sample import pixels_shape

FILTER_ROWS = 3
"""Rows of pixels that one smoothed row needs."""


class PixelFilter(wiring.Component):
    """One pass of ``golden.pixel_filter``: rows come out two columns shorter.

        clock 1   a + 2b + c down the column; with 8 pixels per clock in two clocks
        clock 2   the same along the row

    With one pixel per clock each column meets the two before it in a chain of adders; with several
    the sums of two neighbours are shared.

    Parameters
    ----------
    parameters
        Parameters of the detector.
    lost
        Columns of a row that are lost already.
    tags_first
        A beat's tags come out a clock before its pixels, as ``CircularBuffer`` may take them.

    Members
    -------
    i
        Stream of ``Columns(pixels_shape(parameters), 3)``.
    o
        Stream of ``Beat(pixels_shape(parameters))``.
    """

    def __init__(self, parameters: Build, lost: int = 0, *, tags_first: bool = False) -> None:
        self._lanes, self._wide = parameters.pixels_per_clock, parameters.is_wide
        self._lost = lost
        self._tags_first = tags_first
        pixels = pixels_shape(parameters)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(pixels, FILTER_ROWS))),
                "o": Out(stream.Signature(Beat(pixels))),
            }
        )

    @property
    def latency(self) -> int:
        return 2 + self._wide - self._tags_first

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        rows = [Lanes(pipe, each_lane(row, self._lanes), "row") for row in self.i.payload.data]
        # wide columns come from far block RAM: a single sum begins there
        ends = rows[0].map(outer_sum, rows[2]).register("ends", int(self._wide))
        middle = rows[1].register("middle", int(self._wide))
        smoothed = _along(ends.map(with_middle, middle).register("down"))
        for pixel, value in zip(each_lane(self.o.payload.data, self._lanes), smoothed.values, strict=True):
            m.d.comb += pixel.eq(value)
        more = FILTER_ROWS - 1
        deliver(m, pipe, self.i, self.o, smoothed, lost=self._lost, more=more, tags_first=self._tags_first)
        return m


def _along(down: Lanes) -> Lanes:
    """[1 2 1] / 16 along the row."""
    if len(down) == 1:
        three = down.back(1).map(lambda one, here: one + (here << 1), down)
        return (three.back(1) + down)[4:].register("smoothed")
    pairs = down + down.back(1)
    return (pairs + pairs.back(1))[4:].register("smoothed")


def binomial(above: Value, here: Value, below: Value) -> Value:
    """a + 2b + c + 2: columns of weights 1, 2 and 1 so add the half that rounds their mean."""
    return with_middle(outer_sum(above, below), here)


def outer_sum(above: Value, below: Value) -> Value:
    """a + c + 1: the ones of ``binomial`` enter where the adders have room for them."""
    return (Cat(C(1, 1), above) + Cat(C(1, 1), below))[1:]


def with_middle(outer: Value, here: Value) -> Value:
    """``binomial`` out of the sum of its ends: a clock may lie between the two."""
    return (outer + Cat(C(1, 1), here))[: len(here) + 2]
