# amaranth: UnusedElaboratable=no
"""Frame guard: only whole frames pass, up to a cut; well-formed video passes without events."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.asserts import AnyConst
from amaranth.hdl import (
    Assert,
    Assume,
    Cat,
    Cover,
    Elaboratable,
    Module,
    Mux,
    ResetInserter,
    Signal,
    Value,
)

import hdl.edges.frame_guard
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of
from tests.formal.frames import (
    PARAMETERS,
    Kept,
    Place,
    allowed,
    counts,
    guard_model,
    in_beats,
    kept_inside,
    receiver,
    restarted_since_cut,
)
from tests.formal.properties import (
    Scoreboard,
    accepts_within,
    assume_stable,
    free,
    invariant,
    moves,
    stable,
)


class AnyVideoChecker(Elaboratable):
    """Any video. Assumed: sizes in range; and after a cut, ``restart`` before ``resume``."""

    def __init__(self, design: Any, lanes: int = 1) -> None:
        self._design = design
        self._lanes = lanes

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.FrameGuard(PARAMETERS.changed(pixels_per_clock=self._lanes))
        inside = probes_of(dut)
        free(m, dut)
        restarted = restarted_since_cut(m, dut)
        m.d.comb += [
            Assume(allowed(dut.width, dut.height, self._lanes)),
            Assume(~dut.resume | (restarted & ~dut.restart)),
            Assert(~(dut.cut & moves(dut.i)), "something is taken after the cut"),
            Cover(restarted & dut.resume, "a cut is over"),
            *(Cover(dut.events[name], f"{name} happens") for name, _ in dut.events.shape()),
        ]
        was_cut, resumed, done = Signal(), Signal(), Signal()
        m.d.sync += [was_cut.eq(dut.cut), resumed.eq(dut.resume)]
        m.d.comb += Assert(~was_cut | dut.cut | resumed, "the cut is over before it is resumed")
        with m.If(dut.resume):
            m.d.sync += done.eq(1)
        m.d.comb += Cover(done & dut.done, "a frame is complete after one was cut")

        # a restart forgets all, and so do those who watch
        m.submodules.since_restart = ResetInserter(dut.restart)(watch := Module())
        assume_stable(watch, dut.i, "i")
        stable(watch, dut.o, "o")
        place = guard_model(watch, dut, inside, restarted)
        receiver(watch, dut, place)
        with m.If(restarted):
            invariant(m, dut.cut & place.first & ~dut.o.valid, "something is left after a restart")
        return m


class GoodVideoChecker(Elaboratable):
    """Frames of any size, well marked, with pauses of any length."""

    def __init__(self, design: Any, lanes: int = 1) -> None:
        self._design = design
        self._lanes = lanes

    def elaborate(self, platform: Any) -> Module:
        m, lanes = Module(), self._lanes
        m.submodules.dut = dut = self._design.FrameGuard(PARAMETERS.changed(pixels_per_clock=lanes))
        inside = probes_of(dut)
        free(m, dut, but=("width", "height", "enable", "restart", "resume"))
        width, height = AnyConst(16), AnyConst(16)
        m.d.comb += [
            dut.width.eq(width),
            dut.height.eq(height),
            dut.enable.eq(1),
            Assume(allowed(width, height, lanes)),
        ]
        assume_stable(m, dut.i, "i")
        place = Place(m, "given", in_beats(width, lanes), height, moves(dut.i))
        framing = Cat(dut.i.payload.sof, dut.i.payload.eol)
        if lanes > 1:
            kept = Kept(dut, width, place.eol)
            m.d.comb += [
                Assume(~dut.i.valid | ~(kept.lacking | kept.beyond)),
                Cover(moves(dut.i) & place.eol & ~dut.i.payload.keep.all(), "a row ends within a beat"),
            ]
            framing = Cat(Mux(place.eol, kept.last, -1)[: len(kept.last)], framing)
        marks = (dut.i.payload.sof == place.first) & (dut.i.payload.eol == place.eol)
        m.d.comb += [
            Assume(~dut.i.valid | marks),
            Assert(~dut.cut, "a frame is cut"),
            *(Assert(~dut.events[name], f"{name} happens") for name, _ in dut.events.shape()),
            Assert(dut.done == (moves(dut.i) & place.eol & place.last_row), "done: wrong"),
            Cover(moves(dut.o) & dut.o.payload.sof & moves(dut.i), "a frame begins"),
            Cover(dut.done, "a frame ends"),
        ]
        board = Scoreboard(
            m,
            "i to o",
            enters=moves(dut.i),
            given=Cat(dut.i.payload.pixel, framing),
            leaves=moves(dut.o),
            found=dut.o.payload,
            capacity=1,
        )
        board.leaves_within(1, dut.o.ready)
        accepts_within(m, 1, dut.i, during=dut.o.ready, name="i")
        invariant(m, board.inside == dut.o.valid, "what is at the output is not what went in")
        with m.If(board.following):
            invariant(m, Value.cast(dut.o.payload) == board.value, "another beat is at the output")
        invariant(m, (dut.active == ~place.first) & ~inside["surplus"], "active differs")
        with m.If(dut.active):
            counts(m, inside, place)
            if lanes > 1:
                kept_inside(m, inside, kept)
        return m


ANY_VIDEO = Claim(
    says="FrameGuard: whole frames or a cut, for any video",
    design=hdl.edges.frame_guard,
    check=AnyVideoChecker,
    depth=2,
    covered=16,
    faults=(
        Fault("self.i.ready.eq(~self.cut & ", "self.i.ready.eq(", "taken after the cut", within=8),
        Fault("(free | ~belongs)", "1", "i to o", within=8),
        Fault("with m.Elif(self.o.ready):", "with m.Else():", "o: valid falls", within=8),
        Fault("early.eq(self.active & sof)", "early.eq(self.active & sof & eol)", "wrong", within=8),
        Fault("inside & ~row_end & ~ignore_eol", "inside & ~row_end", "wrong", within=8),
        Fault("Mux(start, ~self.ignore_eol,", "Mux(start, 0,", "eol_early: wrong", within=8),
        Fault("surplus.eq(~eol)", "surplus.eq(0)", "wrong", within=12),
        Fault("[x.eq(1), y.eq(0), row_end", "[x.eq(1), row_end", "done: wrong", within=10),
        Fault("(x == last_but_one_x) & ~line_over", "x == last_but_one_x", "wrong", within=16),
        Fault(
            "with m.If(~self.active):\n            m.d.sync += [\n                last",
            "if True:\n            m.d.sync += [\n                last",
            "wrong",
            within=10,
        ),
    ),
)
GOOD_VIDEO = Claim(
    says="FrameGuard: well-formed video passes untouched and without an event",
    design=hdl.edges.frame_guard,
    check=GoodVideoChecker,
    depth=2,
    covered=12,
    faults=(
        Fault("self._beats(self.width) - 2", "self._beats(self.width) - 1", "happens", within=10),
        Fault("[self.active.eq(0), after.eq(1)]", "after.eq(1)", "sof_early happens", within=12),
        Fault("last_row.eq(y == last_but_one_y)", "last_row.eq(y == last_but_one_x)", "wrong", within=16),
    ),
)
LANES = 4
ANY_LANES = Claim(
    says="FrameGuard, four pixels per clock: whole frames or a cut, for any video",
    design=hdl.edges.frame_guard,
    check=lambda design: AnyVideoChecker(design, LANES),
    depth=2,
    covered=16,
    faults=(
        Fault(
            "short_line |= (inside | start) & lacking", "short_line |= inside & lacking", "wrong", within=8
        ),
        Fault("(~eol | beyond)", "~eol", "eol_late", within=10),
        Fault("Mux(row_end & self.active, ~needed, 0)", "Mux(row_end, ~needed, 0)", "wrong", within=16),
        Fault("Mux(row_end & self.active, last_lane, -1)", "last_lane", "i to o", within=8),
        Fault("with m.Elif(late):", "with m.Elif(too_long):", "wrong", within=12),
    ),
)
GOOD_LANES = Claim(
    says="FrameGuard, four pixels per clock: well-formed video passes untouched and without an event",
    design=hdl.edges.frame_guard,
    check=lambda design: GoodVideoChecker(design, LANES),
    depth=2,
    covered=12,
    faults=(
        Fault("(width + lanes - 1)", "width", "happens", within=10),
        Fault("needed.eq((2 << lane) - 1)", "needed.eq((2 << lane) + 1)", "happens", within=10),
    ),
)


@pytest.mark.parametrize("case", cases(ANY_VIDEO, GOOD_VIDEO, ANY_LANES, GOOD_LANES))
def test_frame_guard(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
