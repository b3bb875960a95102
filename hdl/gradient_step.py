# amaranth: UnusedElaboratable=no
"""Gradient steps of candidates: from the surface's peak, twice, by the pixels around them."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Member, Out

from hdl.build import Build
from hdl.fits import candidate_layout
from hdl.normal_equations import NormalEquations
from hdl.parts.queue import Queue
from hdl.pixel_store import store_members
from hdl.step_judge import StepJudge
from hdl.step_layouts import pixel_place_layout, rows_kept, step_layout, steps_in_flight, under_way_layout
from hdl.subpixel import Subpixel, offset_layout
from hdl.window_reader import WindowReader

_PLACES = 8


def step_members(build: Build) -> dict[str, Member]:
    """Members beside its streams."""
    rows = rows_kept(build)
    of_store = {name: member.flip() for name, member in store_members(build, rows).items()}
    return {"picked": In(1), "row": In(range(2 * rows)), **of_store}


class GradientStep(wiring.Component):
    """Offsets of candidates by two gradient steps (``golden.subpixel.gradient_steps``).

        candidates ┬ surfaces ──────────────────────┐
                   │    ┌ window reader ─ equations ┴ subpixel ─ judge ─ offsets
                   │    └──────── steps ─────────────────────────┤
                   └ places ─────────────────────────────────────┘

    Each candidate goes round three times: its surface is solved, then the equations of its first
    window, then those of its second one. All keep the order of the candidates. Windows are read one
    after the other, of several candidates in turn, so that solving takes no time of its own.

    Members
    -------
    i
        Stream of ``candidate_layout(build)``.
    picked, row
        In this clock there is a new candidate, which will come to ``i``; and the number of
        the row of pixels a margin above the place at which one can be now.
    needed
        The oldest row of pixels that any candidate needs, or will.
    reading, place, column
        Those of the pixel store.
    o
        Stream of ``offset_layout("gradient")``.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        self.inside = steps_in_flight(build)
        self.reader = WindowReader(build)
        self.equations = NormalEquations(build)
        self.subpixel = Subpixel(build, bits_per_clock=build.refinement_bits)
        self.judge = StepJudge(build)
        super().__init__(
            {
                "i": In(stream.Signature(candidate_layout(build))),
                **step_members(build),
                "o": Out(stream.Signature(offset_layout("gradient"))),
            }
        )

    @property
    def interval(self) -> int:
        """Clocks from one candidate to the next, where many wait.

        The solver takes the equations of a window when it moves on, which it does at its own pace.
        With several pixels per clock the next window is read meanwhile.
        """
        pace = self.subpixel.interval
        if self._build.pixels_per_clock == 1:
            return 2 * pace * -(-self.reader.interval // pace)
        return max(2 * self.reader.interval, 3 * pace)

    @property
    def latency(self) -> int:
        """Most clocks from a candidate that finds the unit idle to its offset."""
        solved = self.subpixel.latency + self.judge.clocks
        return 3 * (solved + self.subpixel.interval) + 2 * (self.reader.interval + self.equations.latency + 8)

    @property
    def memory_bits(self) -> int:
        return self.equations.memory_bits

    def elaborate(self, platform: Any) -> Module:
        m, build = Module(), self._build
        m.submodules.reader = reader = self.reader
        m.submodules.equations = equations = self.equations
        m.submodules.subpixel = subpixel = self.subpixel
        m.submodules.judge = judge = self.judge
        m.submodules.steps = steps = Queue(step_layout(build), _PLACES)
        m.submodules.under_way = under_way = Queue(under_way_layout(build), _PLACES)
        m.submodules.surfaces = surfaces = Queue(pixel_place_layout(build), _PLACES)
        for source, sink in (
            (judge.step, steps.i),
            (steps.o, reader.i),
            (reader.under_way, under_way.i),
            (reader.o, equations.i),
            (subpixel.o, judge.solution),
            (under_way.o, judge.under_way),
            (surfaces.o, judge.surface),
        ):
            wiring.connect(m, source, sink)
        wiring.connect(m, judge.o, wiring.flipped(self.o))
        m.d.comb += [
            self.reading.eq(reader.reading),
            self.place.eq(reader.place),
            reader.column.eq(self.column),
            judge.by_gradients.eq(subpixel.o_kind),
        ]
        self._solve(m, surfaces)
        self._need(m)
        return m

    def _solve(self, m: Module, surfaces: Queue) -> None:
        """Equations of windows come first, surfaces of new candidates in between."""
        equations, subpixel, candidate = self.equations.o, self.subpixel, self.i
        in_flight, begins, ends = Signal(range(self.inside + 1)), Signal(), Signal()
        free = in_flight != self.inside
        m.d.comb += [
            equations.ready.eq(subpixel.i.ready),
            subpixel.kind.eq(equations.valid),
            subpixel.i.valid.eq(equations.valid | (candidate.valid & free)),
            candidate.ready.eq(subpixel.i.ready & free & ~equations.valid),
            begins.eq(candidate.valid & candidate.ready),
            ends.eq(self.o.valid & self.o.ready),
            surfaces.i.valid.eq(begins),
            surfaces.i.payload.eq(candidate.payload.place),
        ]
        with m.If(begins ^ ends):
            m.d.sync += in_flight.eq(in_flight + Mux(begins, 1, -1))
        for name, form in self.subpixel.surface_formats._asdict().items():
            surface = candidate.payload.surface[name] << form.zeros
            m.d.comb += subpixel.i.payload[name].eq(Mux(equations.valid, equations.payload[name], surface))

    def _need(self, m: Module) -> None:
        """While any candidate has windows to be read, the row of the first of these is needed."""
        # in the queue, at its output and here
        waiting = Signal(range(self._build.queue_depth + 1 + self.inside + 1))
        with m.If(self.picked ^ self.reader.read):
            m.d.sync += waiting.eq(waiting + Mux(self.picked, 1, -1))
        begins = self.reader.under_way
        with m.If(waiting == 0):
            m.d.sync += self.needed.eq(self.row)
        with m.Elif(begins.valid & begins.payload.step.second):
            m.d.sync += self.needed.eq(begins.payload.step.candidate.row)
