# amaranth: UnusedElaboratable=no
"""Frame clock: it counts each clock, and each frame ends with the time at which it arrived."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Assert, Assume, Cover, Elaboratable, Module, Signal

import hdl.edges.frame_clock
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import Probes, probes_of, stored, variant
from tests.formal.properties import Scoreboard, free, invariant

MOST = 4


class ClockChecker(Elaboratable):
    """Assumed: no more than ``MOST`` are inside, what begins waits, and what ends has begun.

    Nothing is dropped or forgotten here.
    """

    def __init__(self, design: Any) -> None:
        self._design = design

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.FrameClock(MOST)
        inside = probes_of(dut)
        free(m, dut, but=("drops", "forget"))
        self._counts(m, dut, inside["carry"])

        waiting, begun = Signal(4), Signal(4)
        m.d.comb += [
            Assume(~dut.arrives | (waiting + begun < MOST)),
            Assume(~dut.begins | (waiting != 0)),
            Assume(~dut.ends | (begun != 0)),
        ]
        m.d.sync += [
            waiting.eq(waiting + dut.arrives - dut.begins),
            begun.eq(begun + dut.begins - dut.ends),
        ]
        invariant(m, waiting + begun <= MOST, "more is inside than allowed")
        self._times(m, dut, inside, waiting, begun)
        return m

    def _counts(self, m: Module, dut: Any, carry: Signal) -> None:
        expected, half = Signal.like(dut.now), len(dut.now) // 2
        m.d.sync += expected.eq(expected + 1)
        m.d.comb += Assert(dut.now == expected, "a clock is not counted as one")
        invariant(m, carry == dut.now[:half].all(), "the carry differs")

    def _times(self, m: Module, dut: Any, inside: Probes, waiting: Signal, begun: Signal) -> None:
        """A time leaves in the clock after its frame's end, and then stays."""
        write, read, first_place = (inside[name] for name in ("write", "read", "place"))
        ended, before, none = Signal(), Signal.like(dut.time), Signal(init=1)
        m.d.sync += ended.eq(dut.ends)
        m.d.sync += [before.eq(dut.time), none.eq(none & ~dut.ends)]
        board = Scoreboard(
            m,
            "times",
            enters=dut.arrives,
            given=dut.now,
            leaves=ended,
            found=dut.time,
            capacity=MOST + 1,
            fills=False,
        )
        m.d.comb += [
            Assert(ended | none | (dut.time == before), "a time does not stay"),
            Assert(~none | (dut.time == 0), "a time without a frame"),
            Cover(dut.ends & (waiting == 2), "a frame ends while two wait"),
        ]
        address = len(first_place)
        invariant(m, write.addr == (first_place + begun + waiting)[:address], "places differ")
        invariant(m, inside["begun"] == (first_place + begun)[:address], "frames differ")
        invariant(m, inside["after"] == (first_place + 1)[:address], "what is next differs")
        with m.If(begun != 0):
            ahead = stored(m, inside["memory"], first_place)
            invariant(m, read.data == ahead, "another time is read ahead")
        invariant(m, board.inside == waiting + begun + ended, "what is inside differs")
        with m.If(board.following & (board.ahead >= ended)):
            place = (first_place + board.ahead - ended)[:address]
            invariant(m, stored(m, inside["memory"], place) == board.value, "another time is stored")
        with m.Elif(board.following):
            invariant(m, dut.time == board.value, "another time is shown")


CLOCK = Claim(
    says="FrameClock: every clock is counted, and every frame ends with its own time",
    design=hdl.edges.frame_clock,
    # a counter whose carry comes soon
    small=variant(hdl.edges.frame_clock, {"TIME_BITS = 64": "TIME_BITS = 6"}),
    check=ClockChecker,
    depth=2,
    covered=9,
    faults=(
        Fault("(1 << len(low)) - 2", "(1 << len(low)) - 1", "counted as one", within=10),
        Fault(
            "write.en.eq(self.arrives)",
            "write.en.eq(self.begins)",
            "another beat comes out",
            within=8,
        ),
        Fault("with m.If(self.ends):", "with m.If(1):", "", within=8),
        Fault("Mux(self.ends, after, place)", "begun", "another beat comes out", within=10),
    ),
)


@pytest.mark.parametrize("case", cases(CLOCK))
def test_frame_clock(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
