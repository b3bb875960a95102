# amaranth: UnusedElaboratable=no
"""What follows from each solution of the gradient step: the next step, or the corner's offset."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.divider import HALF
from golden.formats import OFFSET_BITS
from golden.subpixel import DISAGREEMENT
from hdl.build import Build
from hdl.parts.arithmetic import magnitude
from hdl.step_layouts import LIMIT, STEP_BITS, pixel_place_layout, step_layout, under_way_layout
from hdl.subpixel import offset_layout

_HALF_BITS = HALF.bit_length() - 1
_LIMIT_BITS = LIMIT.bit_length() - 1


class StepJudge(wiring.Component):
    """Turns the surface's peak into a first step, that one into a second, and judges this one.

        clock 1   the place: the window's centre and the step from there, or the surface's peak
        clock 2   how far that is from the step's start, along both axes
        clock 3   sizes of that
        clock 4   the larger one; has the step failed?
        clock 5   can both steps be trusted, or the first one alone?
        clock 6   the next step, or the offset

    Members
    -------
    solution
        Stream of ``offset_layout("gradient")``, held until its clock 6.
    by_gradients
        The solution is that of a step, not the surface's peak.
    surface
        Stream of ``pixel_place_layout(build)``: the candidates of the surfaces being solved.
    under_way
        Stream of ``under_way_layout(build)``: the steps being solved.
    step
        Stream of ``step_layout(build)``, always ready.
    o
        Stream of ``offset_layout("gradient")``.
    """

    clocks = 6

    def __init__(self, build: Build) -> None:
        offset = offset_layout("gradient")
        super().__init__(
            {
                "solution": In(stream.Signature(offset)),
                "by_gradients": In(1),
                "surface": In(stream.Signature(pixel_place_layout(build))),
                "under_way": In(stream.Signature(under_way_layout(build))),
                "step": Out(stream.Signature(step_layout(build), always_ready=True)),
                "o": Out(stream.Signature(offset)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        solution, under_way = self.solution.payload, self.under_way.payload
        known, step = under_way.step, self.step.payload
        clock, done = Signal(range(self.clocks)), Signal()
        final = self.by_gradients & known.second
        last = clock == self.clocks - 1
        m.d.comb += [
            done.eq(last & (~final | self.o.ready)),
            self.o.valid.eq(last & final),
            self.step.valid.eq(last & ~final),
            self.solution.ready.eq(done),
            self.surface.ready.eq(done & ~self.by_gradients),
            self.under_way.ready.eq(done & self.by_gradients),
        ]
        with m.If(done):
            m.d.sync += clock.eq(0)
        with m.Elif(self.solution.valid & ~last):
            m.d.sync += clock.eq(clock + 1)

        places, sizes, beyond = [], [], []
        for axis in "xy":
            moved = solution[f"d{axis}"]
            centre = Cat(C(0, OFFSET_BITS), under_way[f"centre_{axis}"]).as_signed()
            place, way = Signal(signed(STEP_BITS), name=f"place_{axis}"), Signal(signed(STEP_BITS + 1))
            size = Signal(STEP_BITS, name=f"size_{axis}")
            m.d.sync += [
                place.eq(Mux(self.by_gradients, centre + moved, _within_half(moved))),
                way.eq(place - known[f"from_{axis}"]),
                size.eq(magnitude(way)),
            ]
            places.append(place)
            sizes.append(size)
            beyond.append(_reaches_limit(place))
        length, failed, trusted, leads = Signal(STEP_BITS), Signal(), Signal(), Signal()
        # twice the length, compared with the first step's and DISAGREEMENT
        short = length <= (known.length >> 1) + DISAGREEMENT // 2
        m.d.sync += [
            length.eq(Mux(sizes[0] > sizes[1], sizes[0], sizes[1])),
            failed.eq(beyond[0] | beyond[1] | solution.clamped | solution.not_maximum),
            trusted.eq(short & ~failed & ~known.failed),
            leads.eq(known.length[_HALF_BITS:].any() & ~known.failed),
        ]
        offset = self.o.payload
        first = ~self.by_gradients
        m.d.comb += [
            step.candidate.eq(Mux(first, self.surface.payload, known.candidate)),
            step.from_x.eq(places[0]),
            step.from_y.eq(places[1]),
            # of a second step only: the first one began there
            step.surface_x.eq(known.from_x),
            step.surface_y.eq(known.from_y),
            step.no_surface.eq(Mux(first, solution.not_maximum, known.no_surface)),
            step.length.eq(length),
            step.failed.eq(failed),
            step.second.eq(self.by_gradients),
            offset.dx.eq(Mux(trusted, places[0], Mux(leads, known.from_x, known.surface_x))),
            offset.dy.eq(Mux(trusted, places[1], Mux(leads, known.from_y, known.surface_y))),
            offset.clamped.eq(~trusted & (leads | ~known.no_surface)),
            offset.not_maximum.eq(~trusted & ~leads & known.no_surface),
        ]
        return m


def _reaches_limit(place: Value) -> Value:
    """Is the size of the place the limit or more, a power of two?"""
    low, high, sign = place[:_LIMIT_BITS], place[_LIMIT_BITS], place[-1]
    return (high ^ sign) | (sign & ~low.any())


def _within_half(offset: Value) -> Value:
    """The offset of a surface's peak, which has no meaning beyond half a pixel."""
    low, high, sign = offset[:_HALF_BITS], offset[_HALF_BITS:-1], offset[-1]
    beyond = (high ^ sign.replicate(len(high))).any()
    # half a pixel is a one, which a negative number has there anyway
    return Cat(low & ~beyond.replicate(len(low)), beyond | sign, sign).as_signed()
