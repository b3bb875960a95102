# amaranth: UnusedElaboratable=no
"""Candidate ring: a column is read when it has been written, and before it is written over."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import pytest
from amaranth.asserts import AnyConst, AnySeq
from amaranth.hdl import Array, Assert, Assume, C, Cat, Cover, Elaboratable, Module, Mux, Signal

import hdl.candidate_ring
from hdl.build import Build
from hdl.candidate_ring import window_order
from hdl.peak_mask import PeakMask
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of, variant
from tests.formal.properties import free, invariant, moves

SIZE = 9
"""Columns of a window."""
CAME = 2
"""Clocks in which a candidate may be in the queue that does not say so yet; proven there."""
COMES = 4
"""Clocks until a candidate that waits comes out of the queue; proven there."""


LATE = 16
"""More beats than come from the first that makes the ring full on."""


class Short(Build):
    """With a ring that is soon written through."""

    ring_beats = 32


class RingChecker(Elaboratable):
    """Assumed: what is proven of the queue, and what the stage around both does.

    Requests come in raster order, within four clocks where some wait. Where none waits, the next
    one is of a beat that has just been written: it is on its way through the peak mask, or came
    into the queue in the last two clocks. No beat is written in the second clock after ``full``.
    """

    def __init__(self, design: Any, lanes: int) -> None:
        self._design = design
        # the contents of columns have no part in this
        options: dict[str, Any] = {"pixel_bits": 4, "pixels_per_clock": lanes}
        kind = Short if hasattr(design, "SMALL") else Build
        self._build = kind.profile("paper", **options)

    def elaborate(self, platform: Any) -> Module:
        m, build = Module(), self._build
        lanes, beats = build.pixels_per_clock, build.ring_beats
        lane_bits, ring_bits = lanes.bit_length() - 1, beats.bit_length() - 1
        m.submodules.dut = dut = self._design.CandidateRing(build, 1, SIZE, 0)
        inside = probes_of(dut)
        free(m, dut)
        was_full = Signal()
        m.d.sync += was_full.eq(dut.full)
        m.d.comb += Assume(~dut.step | ~was_full)

        # in beats: age of the last request's newest column, and the most that the next one's can be
        asked = dut.i.payload.column
        fresh = PeakMask(build).latency + CAME + 1
        age, most = Signal(ring_bits + 2), Signal(ring_bits + 2, init=fresh)
        given = AnySeq(len(age))
        request, idle = moves(dut.i), ~dut.waiting & ~dut.i.valid
        oldest = Mux(idle & (most > fresh), fresh, most)
        m.d.comb += [
            Assume(~dut.i.valid | dut.waiting),
            Assume((given >= 1) & (given <= most)),
            Assume(~request | (asked[lane_bits:] == (inside["written"] - given)[:ring_bits])),
        ]
        m.d.sync += [
            age.eq(Mux(request, given, age) + dut.step),
            most.eq(Mux(request, given, oldest) + dut.step),
        ]
        overdue = Signal(range(COMES + 1))
        late = dut.waiting & ~dut.i.valid
        m.d.sync += overdue.eq(Mux(late, overdue + 1, 0))
        m.d.comb += Assume(overdue < COMES)
        if self._design not in (hdl.candidate_ring, SMALL):
            # a fault is found soonest where all comes that can come, and as late as it can
            soonest = [dut.step | was_full, dut.waiting, given == most, dut.i.valid == (overdue == COMES - 1)]
            m.d.comb += [Assume(holds) for holds in [*soonest, dut.o.ready == AnyConst(1)]]

        # where the window's column is that is read
        lane, place, running = Signal(lane_bits), Signal(range(dut.interval + 1)), Signal()
        advance = dut.o.ready
        with m.If(request):
            m.d.sync += [lane.eq(asked[:lane_bits]), place.eq(0), running.eq(1)]
        with m.Elif(running & advance):
            m.d.sync += place.eq(place + 1)
            with m.If(place == dut.interval - 1):
                m.d.sync += running.eq(0)
        order = window_order(build, SIZE)
        back = Array(C(SIZE - 1 - column, 4) for column in order)[place]
        # columns to the left are as many beats older
        reach = (back + (lanes - 1) - lane)[lane_bits:]
        read = Signal(len(age) + 1)
        newest = (inside["written"] - age)[:ring_bits]
        m.d.comb += read.eq(age + reach)
        m.d.comb += [
            # the next beat is written already while it comes
            Assert(~(running & advance) | (read < beats), "a column is read that is written over"),
            Assert(~(running & advance) | (read >= 1), "a column is read that is not written yet"),
            Assert(
                ~running | (inside["column"] == (Cat(lane, newest) - back)[: lane_bits + ring_bits]),
                "another column is read",
            ),
            Cover(running & dut.full & (read > beats - self._design.SLACK), "the ring is full"),
            Cover(dut.o.valid & dut.o.payload.eol & dut.o.ready, "a window is complete"),
        ]

        if "half" in inside:
            further = (inside["column"] + lanes // 2)[: lane_bits + ring_bits]
            m.d.comb += Assert(~running | (inside["half"] == further), "the other column is elsewhere")

        limit = beats - self._design.SLACK
        invariant(m, inside["running"] == running, "running differs")
        invariant(m, ~running | (inside["count"] == place), "places differ")
        invariant(m, ~running | (place < dut.interval), "a place is none")
        invariant(m, ~running | (inside["is_last"] == (place == dut.interval - 1)), "its end differs")
        if "stride" in inside:
            strides = Array(C(b - a, 5) for a, b in itertools.pairwise(order))[place]
            going_on = running & (place < dut.interval - 1)
            invariant(m, ~going_on | (inside["stride"].as_unsigned() == strides[:4]), "another stride")
        invariant(m, (age >= 1) | ~running, "the newest column is not written yet")
        invariant(m, ~running | (most <= age), "the next one is older")
        # full is said two clocks late, heeded one clock late, and not said anew between windows:
        # the induction is deep enough to see that
        invariant(m, ~running | (age <= limit + LATE), "what is read is too old")
        invariant(m, most <= limit + LATE, "what waits is too old")
        return m


SMALL = variant(hdl.candidate_ring, {"SLACK = 32": "SMALL = True\nSLACK = 20"})


def _claim(says: str, lanes: int, *faults: Fault) -> Claim:
    return Claim(
        says=says,
        design=hdl.candidate_ring,
        small=SMALL,
        check=lambda design: RingChecker(design, lanes),
        depth=10,
        long=True,
        covered=30,
        faults=faults,
    )


RINGS = (
    _claim(
        "CandidateRing, four pixels per clock: no column is read before it is written, or written over",
        4,
        Fault("SLACK = 20", "SLACK = 4", "written over", 45),
        Fault(
            "column.eq(self.i.payload.column - self._newest)",
            "column.eq(self.i.payload.column)",
            "another",
            8,
        ),
    ),
    _claim(
        "CandidateRing, eight pixels per clock: the same for two columns per clock",
        8,
        Fault("SLACK = 20", "SLACK = 4", "written over", 45),
    ),
)


@pytest.mark.parametrize("case", cases(*RINGS))
def test_candidate_ring(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
