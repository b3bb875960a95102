# amaranth: UnusedElaboratable=no
"""Candidate queue: peaks leave one by one, in raster order, and none is lost."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Assert, Assume, Cat, Cover, Elaboratable, Module, Mux, Signal, Value
from amaranth.lib import data

import hdl.candidate_queue
from hdl.build import Build
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of, stored, variant
from tests.formal.properties import Scoreboard, accepts_within, free, invariant, moves, stable, within
from tests.formal.queues import queue_holds

LANES = 4


class Short(Build):
    """With a queue that is soon full, and a ring that is soon written through."""

    candidate_beats = 4
    ring_beats = 8


DEFAULT = Build.profile("paper", pixels_per_clock=LANES)
SMALL = Short.profile("paper", pixels_per_clock=LANES)


class QueueChecker(Elaboratable):
    """Peaks and ends come in any clock; nothing is assumed but that a frame ends with a row."""

    def __init__(self, design: Any) -> None:
        self._design = design
        self._build = SMALL if hasattr(design, "SMALL") else DEFAULT

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.CandidateQueue(self._build)
        inside = probes_of(dut)
        entries = inside["entries"]
        in_entries = probes_of(entries)
        free(m, dut)
        marks = dut.i.payload
        m.d.comb += Assume(~marks.eof | marks.eol)
        stable(m, dut.o, "o")

        # any beat that holds something, with its place, leaves the memory in order
        depth = self._build.candidate_beats
        enters = moves(dut.i) & (marks.mask.any() | marks.eof)
        board = Scoreboard(
            m,
            "beats",
            enters=enters,
            given=self._placed(m, dut, inside),
            leaves=moves(entries.o),
            found=entries.o.payload,
            capacity=depth + 1,
            fills=depth < DEFAULT.candidate_beats,
        )
        stuck = board.leaves_within(LANES + 5, dut.o.ready)
        closed = Signal()
        m.d.sync += closed.eq(dut.full)
        going = dut.o.ready & ~dut.full & ~closed
        # three beats are to be taken, each of them in two clocks more than it holds candidates
        most = 3 * (LANES + 3) + LANES + 4
        overdue = accepts_within(m, most + 1, dut.i, during=going, name="i")
        queue_holds(m, entries, in_entries, board, depth, registered=True)
        level, room, left = in_entries["level"], inside["room"], inside["left"]
        begun = inside["begun"]
        invariant(m, ~room | (level <= depth - 2), "room is none")
        surplus = Mux(level > depth - 3, level - (depth - 3), 0)
        here = Mux(begun, left, Cat(entries.o.payload.mask, entries.o.payload.note))
        taken = sum(here[k] for k in range(LANES + 1)) + Mux(begun, 1, 2)
        to_come = surplus * (LANES + 3) + Mux(entries.o.valid, taken, 1) + ~room
        behind = LANES + 3 + Mux(in_entries["read_out"], 1, 2)
        still = (board.inside != 0) & (stuck + Mux(entries.o.valid, taken, behind) > LANES + 5)
        invariant(m, ~still, "a beat leaves late")
        invariant(m, room | (overdue + to_come <= most), "room comes late")
        # an entry is there because it holds something
        for place in range(depth):
            filled = data.View(inside["entry"].shape(), stored(m, in_entries["memory"], place))
            offset = place - in_entries["read"].addr
            is_kept = Mux(offset < 0, offset + depth, offset) < level
            invariant(m, ~is_kept | filled.mask.any() | filled.note, "an entry is empty")
        read_out = data.View(inside["entry"].shape(), in_entries["read"].data)
        for there, head in ((entries.o.valid, entries.o.payload), (in_entries["read_out"], read_out)):
            invariant(m, ~there | head.mask.any() | head.note, "one of the first entries is empty")
        invariant(m, (left == 0) | begun, "nothing has begun")
        invariant(m, ~begun | entries.o.valid, "what has begun is not there")
        self._lanes_in_turn(m, dut, inside, board)
        self._waits(m, dut, inside, board, enters)
        return m

    def _placed(self, m: Module, dut: Any, inside: Any) -> Value:
        """The beat as it must be kept: with its number, which is its place in the ring, and y."""
        build, marks = self._build, dut.i.payload
        algorithm = build.algorithm
        first = 2 * algorithm.response_margin // LANES
        kept = Signal(inside["given"].shape(), name="placed")
        number, beat, y = (
            Signal.like(Value.cast(getattr(kept, name)), name=f"model_{name}", init=init)
            for name, init in (("ring", 0), ("beat", first), ("y", algorithm.margin))
        )
        with m.If(moves(dut.i)):
            m.d.sync += [number.eq(number + 1), beat.eq(Mux(marks.eol, first, beat + 1))]
            with m.If(marks.eol):
                m.d.sync += y.eq(Mux(marks.eof, algorithm.margin, y + 1))
        m.d.comb += [
            kept.mask.eq(marks.mask),
            kept.note.eq(marks.eof),
            kept.end.eq(marks.eof),
            kept.ring.eq(number),
            kept.beat.eq(beat),
            kept.y.eq(y),
        ]
        for name, model in (("ring", number), ("beat", beat), ("y", y)):
            invariant(m, Value.cast(getattr(inside["given"], name)) == model, f"{name} differs")
        return Value.cast(kept)

    def _lanes_in_turn(self, m: Module, dut: Any, inside: Any, board: Scoreboard) -> None:
        """The followed beat's lanes come out from the left, then its note, and nothing between."""
        build, o, entry, left = self._build, dut.o, inside["entry"], inside["left"]
        beat = Signal(entry.shape(), name="followed")
        due, behind = Signal(LANES + 1), Signal()
        watching, rest = due.any(), due & (due - 1)[: LANES + 1]
        leaves = moves(o) & watching & ~behind
        # the one before it may still be watched: then it is let pass
        out = board.following & inside["entries"].o.valid & ~inside["begun"] & (board.ahead == 0)
        with m.If(out & (~watching | (leaves & (rest == 0)))):
            here = data.View(entry.shape(), board.value)
            m.d.sync += [
                Value.cast(beat).eq(board.value),
                due.eq(Cat(here.mask, here.note)),
                behind.eq((o.valid & ~o.ready) | (left != 0)),
            ]
        with m.Elif(moves(o)):
            m.d.sync += behind.eq(0)
            with m.If(leaves):
                m.d.sync += due.eq(rest)
        lane, found = Signal(range(LANES)), o.payload
        for k in reversed(range(LANES)):
            with m.If(due[k]):
                m.d.comb += lane.eq(k)
        note = ~due[:LANES].any()
        x = (Cat(lane, beat.beat) - build.algorithm.margin)[: len(found.place.x)]
        right = (
            (found.column == Cat(lane, beat.ring))
            & (found.place.x == x)
            & (found.place.y == beat.y)
            & (found.place.note == note)
            & (found.place.end == (note & beat.end))
        )
        m.d.comb += [
            Assert(~leaves | right, "candidates: another one comes out than is due"),
            Cover(leaves & note, "a note comes out"),
            Cover(leaves & (lane == LANES - 1), "the last lane's candidate"),
        ]
        with m.If(watching):
            same = Value.cast(entry) == Value.cast(beat)
            waits = o.valid & ~behind
            invariant(m, ~behind | o.valid, "nothing is before it")
            last = waits & (rest == 0)
            invariant(m, last | (left == Mux(waits, rest, due)), "lanes that are left differ")
            invariant(m, last | same, "another beat is taken")
            invariant(m, ~waits | right, "another candidate is at the output")

    def _waits(self, m: Module, dut: Any, inside: Any, board: Scoreboard, enters: Value) -> None:
        """What the ring's guard builds on."""
        just_came = Signal()
        m.d.sync += just_came.eq(enters)
        m.d.comb += Assert(dut.waiting | (board.inside == just_came), "waiting: not said in time")
        late = within(m, 4, during=dut.waiting, happens=dut.o.valid, name="o: what waits does not come")
        entries, left, begun = inside["entries"], inside["left"], inside["begun"]
        far = Mux(left != 0, 2, entries.o.valid)
        invariant(m, late <= Mux(dut.o.valid, 3, far), "it comes late")
        invariant(m, ~begun | (left != 0) | dut.o.valid, "what is taken has not come out")
        m.d.comb += Assert(dut.waiting | ~dut.o.valid, "waiting: a request is none")


QUEUE = Claim(
    says="CandidateQueue, four pixels per clock: candidates in raster order, none lost, stream rules",
    design=hdl.candidate_queue,
    small=variant(hdl.candidate_queue, {"PLACE_BITS = ": "SMALL = True\nPLACE_BITS = "}),
    check=QueueChecker,
    long_proof=True,
    depth=4,
    covered=16,
    faults=(
        Fault("entries.room & ~self.full", "~self.full", "beats: more is inside", 24),
        Fault("for k in reversed(range(lanes)):", "for k in range(lanes):", "candidates: another", 12),
        Fault("ready.eq((left == 0) & begun)", "ready.eq((rest == 0) & begun)", "candidates: another", 12),
        Fault("Cat(lane, entry.ring)", "Cat(lane, entry.ring + 1)", "candidates: another", 12),
        Fault("self.o.valid | entries.waiting", "self.o.valid", "waiting", 12),
    ),
)


@pytest.mark.parametrize("case", cases(QUEUE))
def test_candidate_queue(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
