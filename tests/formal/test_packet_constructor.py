# amaranth: UnusedElaboratable=no
"""Packet constructor: packets are whole, counted and numbered; records passed or counted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Assert, Assume, C, Cat, Cover, Elaboratable, Module, Mux, Signal, Value

import hdl.edges.packet_constructor
from golden.output_constructor import (
    COUNT_BITS,
    CUT_SHIFT,
    END_OF_FRAME,
    FLAG_SHIFT,
    FRAME_BITS,
    RESPONSE_FIELD_BITS,
    RESPONSE_SHIFT,
    TIME_BITS,
    TIME_RECORD,
)
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of
from tests.formal.properties import (
    Scoreboard,
    accepts_within,
    assume_stable,
    free,
    invariant,
    moves,
    stable,
    within,
)


def ends(record: Value) -> Value:
    """The record is an end-of-frame record, cut or not."""
    return record[FLAG_SHIFT:CUT_SHIFT] == END_OF_FRAME


def assume_detector(m: Module, i: Any) -> None:
    """Input as the output constructor sends it: ``last`` exactly with the end-of-frame record."""
    assume_stable(m, i, "i")
    m.d.comb += Assume(i.payload.last == ends(i.payload.record))


def is_time(record: Value) -> Value:
    """The record is a time record."""
    return record[TIME_BITS:] == TIME_RECORD


def closes(record: Value) -> Value:
    """The record is the end-of-frame record of a packet."""
    return ends(record) & ~is_time(record)


class PacketChecker(Elaboratable):
    """The model of it: how many records a frame has had, by what became of them.

    Assumed: records as the output constructor sends them; ``close`` stays until it is answered, and
    no record is offered meanwhile; ``clear`` comes with the answer, or when no packet is open. The
    proof of the video detector shows that it keeps to that.
    """

    def __init__(self, design: Any) -> None:
        self._design = design

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.PacketConstructor()
        inside = probes_of(dut)
        free(m, dut)
        i, o = dut.i, dut.o
        last, end = i.payload.last, o.payload.record
        assume_detector(m, i)
        stable(m, o, "o")

        passed, dropped, number = Signal(COUNT_BITS), Signal(COUNT_BITS), Signal(FRAME_BITS)
        taken = moves(i)
        # the time record of the frame that has ended last has not been made
        due, room = Signal(), ~o.valid | o.ready
        cuts, times = dut.close & room & ~due, room & due
        closed = (taken & last) | cuts
        m.d.sync += due.eq(Mux(closed, dut.send_time, due & ~times))
        passes = taken & ~last & (passed < dut.max_records)
        asked = Signal()
        m.d.sync += asked.eq(dut.close & ~dut.closed)
        m.d.comb += [
            Assume(dut.close | ~asked),
            Assume(~(dut.close & i.valid)),
            Assume(~dut.clear | dut.closed | (~i.valid & ~dut.close & (passed == 0) & (dropped == 0))),
            Assert(~dut.closed | dut.close, "closed without being asked"),
            Assert(dut.ended == closed, "an end is not reported when it is made"),
        ]
        self._closes_once(m, dut, cuts, due & inside["cut"], asked)
        with m.If(closed):
            m.d.sync += [passed.eq(0), dropped.eq(0), number.eq(number + 1)]
        with m.Elif(taken):
            m.d.sync += [passed.eq(passed + passes), dropped.eq(dropped + ~passes)]
        with m.If(dut.clear):
            m.d.sync += number.eq(0)

        maximum = i.payload.record[RESPONSE_SHIFT : RESPONSE_SHIFT + RESPONSE_FIELD_BITS]
        closing = Cat(passed, number, Mux(dut.close, 0, maximum), C(END_OF_FRAME, 2), dut.close)
        given = Mux(dut.close | last, closing, i.payload.record)
        time = Cat(dut.time, C(TIME_RECORD, 4), C(1, 1))
        board = Scoreboard(
            m,
            "i to o",
            enters=passes | closed | times,
            given=Mux(due, time, Cat(given, (dut.close | last) & ~dut.send_time)),
            leaves=moves(o),
            found=Cat(o.payload.record, o.payload.last),
            capacity=1,
        )
        board.leaves_within(1, o.ready)
        accepts_within(m, 2, i, during=o.ready, name="i")
        within(m, 3, during=dut.close & o.ready, happens=dut.closed, name="a cut frame is not closed")
        self._packets(m, dut, passed, due)
        self._results(m, dut, passed, dropped, inside["cut"])

        invariant(m, board.inside == o.valid, "what is at the output is not what went in")
        with m.If(board.following):
            invariant(m, Cat(end, o.payload.last) == board.value, "another beat is at the output")
        invariant(m, dut.results.frames == number, "frames are counted wrong")
        counted = (inside["count"] == passed) & (inside["dropped"] == dropped)
        invariant(m, counted, "records are counted wrong")
        invariant(m, inside["timing"] == due, "another time is due")
        invariant(m, ~due | (passed + dropped == 0), "records are counted while a time is due")
        return m

    def _closes_once(self, m: Module, dut: Any, cuts: Value, due: Value, asked: Signal) -> None:
        """One end for each answer: with it, or some clocks before with its time record."""
        begun = Signal()
        m.d.sync += begun.eq((begun | cuts) & ~dut.closed)
        m.d.comb += [
            Assert(~(cuts & begun), "a cut frame has two ends"),
            Assert(~dut.closed | cuts | begun, "a cut frame is closed without an end"),
            Cover(dut.closed & begun, "a cut frame is closed with its time"),
        ]
        invariant(m, begun == due, "the wrong time is due")
        invariant(m, ~begun | asked, "nothing is closed, but a time is due for it")

    def _packets(self, m: Module, dut: Any, passed: Signal, due: Signal) -> None:
        """What a receiver sees, which knows nothing of the input."""
        o, end = dut.o, dut.o.payload.record
        sent, expected, limit = Signal(COUNT_BITS), Signal(FRAME_BITS), Signal(COUNT_BITS)
        # the end-of-frame record at the output is from before a clear; a packet's last is a time
        stale, timed = Signal(), Signal()
        time, is_end = is_time(end), closes(end)
        end_moves = moves(o) & is_end
        waits = (o.valid & is_end & ~o.ready) | (dut.closed & ~due)
        with m.If(moves(o)):
            m.d.sync += [sent.eq(Mux(is_end, 0, sent + ~time)), timed.eq(is_end & ~o.payload.last)]
        with m.If(end_moves):
            m.d.sync += [expected.eq(Mux(stale, 0, expected + 1)), stale.eq(0)]
        with m.If(dut.clear):
            m.d.sync += stale.eq(waits)
            with m.If(~waits):
                m.d.sync += expected.eq(0)
        # the largest limit in this packet, should it change
        m.d.sync += limit.eq(Mux(end_moves | (limit < dut.max_records), dut.max_records, limit))
        with m.If(o.valid):
            m.d.comb += [
                Assert(time == timed, "o: a time is not right after an end-of-frame record without last"),
                Assert(~o.payload.last | time | is_end, "o: last is with a corner"),
                Assert(~time | o.payload.last, "o: a time without last"),
                Assert(~is_end | (end[:COUNT_BITS] == sent), "o: the number of records is wrong"),
                Assert(is_end | time | (sent < limit), "o: more records than are allowed"),
                Assert(
                    ~is_end | (end[COUNT_BITS : COUNT_BITS + FRAME_BITS] == expected),
                    "o: frame numbers are not consecutive",
                ),
            ]
        m.d.comb += [
            Cover(moves(o) & end[CUT_SHIFT] & o.payload.last & (sent == 1), "a cut frame with a record"),
            Cover(moves(o) & ~end[CUT_SHIFT] & o.payload.last & (sent == 2), "a complete frame with two"),
        ]
        at_output = o.valid & is_end
        record = o.valid & ~is_end & ~time
        invariant(m, due == (at_output & ~o.payload.last), "the time is not made at once")
        invariant(m, timed == (o.valid & time), "no time is at the output")
        counted = Mux(at_output, passed == 0, (sent + record)[:COUNT_BITS] == passed)
        invariant(m, counted, "what was sent and what went in differ in number")
        invariant(m, sent <= limit, "more has been sent than is allowed")
        invariant(m, ~stale | at_output, "nothing waits from before the clear")
        number = Mux(stale, 0, (expected + at_output)[:FRAME_BITS])
        invariant(m, dut.results.frames == number, "the numbers of frames differ")

    def _results(self, m: Module, dut: Any, passed: Signal, dropped: Signal, last_cut: Signal) -> None:
        """Reported: all corners of the last complete frame, and those that were dropped."""
        results = dut.results
        record, before = dut.o.payload.record, Signal()
        end, cut = moves(dut.o) & dut.o.payload.last, Mux(is_time(record), before, record[CUT_SHIFT])
        with m.If(moves(dut.o) & ~is_time(record)):
            m.d.sync += before.eq(record[CUT_SHIFT])
        closing = dut.o.valid & (is_time(record) | ends(record))
        invariant(m, ~closing | (last_cut == cut), "another frame was cut")
        found, lost, any_results = Signal(COUNT_BITS), Signal(COUNT_BITS), Signal()
        with m.If(moves(dut.i) & dut.i.payload.last):
            m.d.sync += [found.eq(passed + dropped), lost.eq(dropped), any_results.eq(1)]
        with m.If(dut.clear):
            m.d.sync += [found.eq(0), lost.eq(0), any_results.eq(0)]
        m.d.comb += [
            Assert((results.corners == found) & (results.dropped == lost), "the results are wrong"),
            Assert(dut.any_results == any_results, "it is not known whether there are results"),
            Assert(dut.done == (moves(dut.i) & dut.i.payload.last), "the wrong end is reported as done"),
            Assert(dut.events.frame_done == (end & ~cut), "an end is not reported when it is taken"),
            Assert(dut.events.frame_cut == (end & cut), "a cut is not reported when it is taken"),
            Assert(
                dut.events.records_dropped
                == (moves(dut.i) & ~dut.i.payload.last & (passed >= dut.max_records)),
                "dropping is not reported",
            ),
            Cover((lost == 1) & (found == 2), "one of two records was dropped"),
        ]


PACKETS = Claim(
    says="PacketConstructor: packets are whole, counted and numbered",
    design=hdl.edges.packet_constructor,
    check=PacketChecker,
    depth=2,
    covered=10,
    faults=(
        Fault("send.eq(step & (last | ~full))", "send.eq(step)", "o: more records", within=8),
        Fault(
            "full.eq(count >= self.max_records)", "full.eq(count > self.max_records)", "dropping", within=8
        ),
        Fault(
            "with m.If(self.ended | self.clear):",
            "with m.If(self.done):",
            "the number of records",
            within=10,
        ),
        Fault("delivered = self.o.valid & self.o.ready", "delivered = self.o.valid", "when it is taken", 6),
        Fault("(last | ~full)", "~full", "does not leave", within=8),
        Fault("(last | self.close) & ~self.send_time", "last & ~self.send_time", "o: ", within=8),
        Fault("with m.If(self.ended):", "with m.If(self.done):", "consecutive", within=8),
        Fault("timing.eq(self.ended & self.send_time)", "timing.eq(0)", "o: a time is not right", within=8),
        Fault("(self.close & free & ~timing)", "(self.close & free)", "when it is made", within=8),
        Fault("Mux(timing, cut, ~self.send_time)", "Mux(timing, 1, ~self.send_time)", "without an end", 8),
        Fault("results.dropped.eq(missing)", "results.dropped.eq(count)", "results are wrong", within=8),
        Fault("self.i.ready.eq(free & ~timing)", "self.i.ready.eq(~timing)", "more is inside", within=6),
        Fault("free.eq(~self.o.valid | self.o.ready)", "free.eq(1)", "more is inside", within=6),
    ),
)


@pytest.mark.parametrize("case", cases(PACKETS))
def test_packet_constructor(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
