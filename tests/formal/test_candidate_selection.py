# amaranth: UnusedElaboratable=no
"""Candidate selection: pending records and candidates in step, queues never overflow."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Assert, Assume, Cat, Cover, Elaboratable, Module, Mux, Signal
from amaranth.lib import data

import hdl.candidate_selection
from hdl.build import Build
from hdl.candidate_selection import INSIDE
from hdl.parts.queue import ROOM
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of, variant
from tests.formal.properties import (
    Scoreboard,
    accepts_within,
    assume_stable,
    free,
    invariant,
    moves,
    stable,
)
from tests.formal.queues import queue_holds

DEFAULT = Build.profile("paper")
MARGIN = DEFAULT.algorithm.margin
SHORT = Build.profile("paper", pixel_bits=4)
"""With queues that are soon full, shorter than any that can be built: for covers and faults."""
object.__setattr__(SHORT, "queue_depth", ROOM)


class SelectionChecker(Elaboratable):
    """All inputs of a centre come in one clock, and none in the clock after a frame's last."""

    def __init__(self, design: Any) -> None:
        self._design = design

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        design = self._design
        parameters = DEFAULT if design.INSIDE == INSIDE else SHORT
        m.submodules.dut = dut = design.CandidateSelection(parameters)
        inside = probes_of(dut)
        candidates, waiting = probes_of(inside["candidates"]), probes_of(inside["pending"])
        free(m, dut)
        centre, texture = dut.corners.payload, dut.textures.payload
        after_end = Signal()
        m.d.sync += after_end.eq(moves(dut.corners) & centre.eof)
        for name in ("corners", "textures", "surfaces"):
            port = getattr(dut, name)
            assume_stable(m, port, name)
            m.d.comb += [
                Assume(port.valid == dut.corners.valid),
                Assert(port.ready == dut.corners.ready, f"{name}: not ready when the others are"),
            ]
        m.d.comb += [Assume(~(after_end & dut.corners.valid)), Assume(~centre.eof | centre.eol)]
        for name in ("candidate", "pending"):
            stable(m, getattr(dut, name), name)

        x, y = (Signal(design.PIXEL_COORDINATE_BITS, name=axis, init=MARGIN) for axis in ("x", "y"))
        with m.If(moves(dut.corners)):
            m.d.sync += x.eq(Mux(centre.eol, MARGIN, x + 1))
            with m.If(centre.eol):
                m.d.sync += y.eq(Mux(centre.eof, MARGIN, y + 1))
        picked = moves(dut.corners) & centre.data.corner & texture.data.keep
        chosen = Scoreboard(
            m,
            "candidate",
            enters=picked,
            given=dut.surfaces.payload,
            leaves=moves(dut.candidate),
            found=dut.candidate.payload,
            capacity=parameters.queue_depth,
        )
        # of a frame's end only the flag `end` counts, and the frame's largest response
        first, largest = Signal(init=1), Signal(parameters.response_bits)
        with m.If(moves(dut.corners)):
            response = centre.data.response
            m.d.sync += [
                first.eq(centre.eof),
                largest.eq(Mux(first | (response > largest), response, largest)),
            ]
        place = Cat(x, y, centre.data.response, texture.data.textured)
        pending = dut.pending.payload
        said = Cat(pending.x, pending.y, pending.response, pending.textured)
        noted = Scoreboard(
            m,
            "pending",
            enters=picked | after_end,
            given=Cat(Mux(after_end, largest, place), after_end),
            leaves=moves(dut.pending),
            found=Cat(Mux(pending.end, pending.response, said), pending.end),
            capacity=parameters.queue_depth + design.INSIDE + 1,
        )
        for board, port in ((chosen, dut.candidate), (noted, dut.pending)):
            board.leaves_within(2, port.ready)
        ready = dut.candidate.ready & dut.pending.ready
        overdue = accepts_within(m, 5, dut.corners, during=ready, name="corners")
        m.d.comb += Cover(
            moves(dut.pending) & pending.end & dut.candidate.valid, "an end overtakes a candidate"
        )

        def what_counts(kept: Any) -> Any:
            stored_record = data.View(design.pending_record_layout(parameters), kept)
            return Cat(Mux(stored_record.end, stored_record.response, kept[:-1]), stored_record.end)

        for name, here in (("x", x), ("y", y), ("ending", after_end), ("first", first)):
            invariant(m, inside[name] == here, f"{name} differs")
        invariant(m, first | (dut.largest == largest), "largest differs")
        queue_holds(m, inside["candidates"], candidates, chosen, parameters.queue_depth)
        depth = parameters.queue_depth + design.INSIDE
        # how full the queues can be, as room is heeded a clock late, and as they are emptied
        room, surfaces, records = inside["room"], candidates["level"], waiting["level"]
        invariant(
            m, ~room | ((surfaces <= parameters.queue_depth - 2) & (records <= depth - 2)), "room is none"
        )
        empty = surfaces == 0
        invariant(m, empty | (surfaces + overdue < parameters.queue_depth), "a candidate too many")
        empty = records + after_end == 0
        invariant(m, empty | (records + overdue + after_end <= depth), "a pending record too many")
        invariant(m, room | (overdue < 4), "room comes late")
        queue_holds(m, inside["pending"], waiting, noted, depth, compared=what_counts)
        return m


NARROW = """
def derivatives_layout(parameters):
    return data.StructLayout({"dxx": 2})


candidate_layout = derivatives_layout
"""
SELECTION = Claim(
    says="CandidateSelection: pending records and candidates in step, nothing lost, stream rules",
    design=hdl.candidate_selection,
    small=variant(
        hdl.candidate_selection,
        {
            "INSIDE = 4": "INSIDE = 1",
            "COORDINATE_BITS - OFFSET_BITS": "4",
            "from hdl.fits import candidate_layout, derivatives_layout": NARROW,
        },
    ),
    check=SelectionChecker,
    depth=2,
    long_proof=True,
    covered=14,
    faults=(
        Fault("candidates.room & pending.room", "pending.room", "candidate: more is inside", 14),
        Fault("pending.i.valid.eq(picked | ending | closing)", "pending.i.valid.eq(picked)", "pending: ", 5),
        Fault("first | (response > self.largest)", "response > self.largest", "pending: another beat", 14),
        Fault("[x.eq(margin), y.eq(y + 1)]", "x.eq(margin)", "pending: another beat", 6),
        Fault("picked.eq(step &", "picked.eq(self.corners.valid &", "", 14),
    ),
)


@pytest.mark.parametrize("case", cases(SELECTION))
def test_candidate_selection(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
