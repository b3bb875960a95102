# amaranth: UnusedElaboratable=no
"""The guarded detector around any that keeps its contract: one packet per frame, no hang."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Assert, Assume, Cover, Elaboratable, Module, Mux, ResetInserter, Signal

import hdl.edges.video_detector
from golden.output_constructor import CUT_SHIFT
from tests.formal.abstract_detector import LATE, AbstractDetector
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import Probes, probes_of
from tests.formal.frames import LEAST, PARAMETERS, Place, allowed, guard_model, receiver, restarted_since_cut
from tests.formal.properties import Scoreboard, free, invariant, moves, stable, within
from tests.formal.test_packet_constructor import closes, is_time

MOST = PARAMETERS.queue_depth + 30
"""Complete frames that the detector may hold; one more can be on its way to it."""


class VideoDetectorChecker(Elaboratable):
    """Assumed: the detector's contract, valid sizes, and ``reset`` held until it is done.

    ``others`` counts the frames that have begun and whose closing beat is not yet at the output.
    """

    resets = False

    def __init__(self, design: Any, lanes: int = 1) -> None:
        self._design = design
        self._lanes = lanes

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        build = PARAMETERS.changed(pixels_per_clock=self._lanes)
        self.detector = detector = AbstractDetector(build, MOST)
        m.submodules.dut = self.dut = dut = self._design.VideoDetector(build, detector=detector)
        self.inside = probes_of(dut)
        self.guard, self.packets = guard, packets = dut._guard, dut._packets
        guard_inside, packets_inside, _ = (probes_of(part) for part in (guard, packets, detector))
        free(m, dut)
        self._assume_software(m)
        stable(m, dut.records, "records")

        # the numbers of frames in each state
        self.restart, self.closing, opened = (self.inside[name] for name in ("restart", "closing", "opened"))
        self.complete, self.timing = self.inside["inside"], packets_inside["timing"]
        self.open = open_ = Signal(16)
        # of each packet, the beat that closes it is its end-of-frame record; a time may follow
        self.last, self.time = closes(dut.records.payload.record), is_time(dut.records.payload.record)
        self.at_output = at_output = dut.records.valid & self.last
        self.others = others = (open_ - at_output)[: len(open_)]
        self.ends = ends = moves(dut.records) & self.last
        begins = guard.taken & guard.i.payload.sof
        with m.If(self.restart & dut.control.reset):
            m.d.sync += open_.eq((at_output & ~ends) + (others != 0))
        with m.Else():
            m.d.sync += open_.eq(open_ + begins - ends)

        self.restarted = restarted = restarted_since_cut(m, guard)
        m.submodules.since_restart = ResetInserter(self.restart)(watch := Module())
        taken = guard_model(watch, guard, guard_inside, restarted, known=True)
        sent = receiver(watch, guard, taken, known=True)
        with m.If(restarted):
            invariant(m, guard.cut & taken.first & ~guard.o.valid, "something is left after a restart")

        self._contracts(m, packets_inside)
        self._frames(m)
        self._progress(m)
        self._detector_holds(m, sent)

        invariant(m, restarted == self.closing, "closing differs")
        invariant(m, ~(self.restart & self.closing), "a restart while closing")
        under_way = self.complete + guard.active + (guard.cut & ~restarted)
        timing = self.timing & packets_inside["cut"]
        invariant(m, others == Mux(self.closing, opened & ~timing, under_way), "frames in flight differ")
        invariant(m, ~timing | self.closing, "a time is due for nothing")
        drained = self.complete == 0
        invariant(m, ~self.restart | self.asked | (guard.cut & drained), "a restart out of nothing")
        invariant(m, ~self.closing | drained, "a frame goes in while closing")
        invariant(m, open_ <= MOST + 4, "more frames than there can be")
        return m

    def _assume_software(self, m: Module) -> None:
        control, asked = self.dut.control, Signal()
        m.d.comb += Assume(allowed(control.width, control.height, self._lanes))
        if self._design is not hdl.edges.video_detector:
            # a fault is found soonest with the smallest frames
            least = (LEAST["x"] - 1) * self._lanes + 1
            small = (control.width == least) & (control.height == LEAST["y"])
            m.d.comb += Assume(small & control.enable & ~control.ignore_eol)
        m.d.sync += asked.eq(control.reset & ~self.dut.reset_done)
        self.asked = asked
        m.d.comb += Assume(control.reset | ~asked) if self.resets else Assume(~control.reset)

    def _contracts(self, m: Module, packets_inside: Probes) -> None:
        """What the proofs of guard and packet constructor assume."""
        guard, packets = self.guard, self.packets
        asked = Signal()
        m.d.sync += asked.eq(packets.close & ~packets.closed)
        nothing = (packets_inside["count"] == 0) & (packets_inside["dropped"] == 0)
        idle = ~packets.i.valid & ~packets.close & nothing
        m.d.comb += [
            Assert(~guard.resume | (self.restarted & ~self.restart), "guard: resume without a restart"),
            Assert(packets.close | ~asked, "packets: close is taken back"),
            Assert(~(packets.close & packets.i.valid), "packets: a record while a packet is closed"),
            Assert(~packets.clear | packets.closed | idle, "packets: cleared in the middle of one"),
        ]
        with m.If(self.others == 0):
            invariant(m, nothing, "records are counted without a frame")
        invariant(m, ~asked | self.closing, "nothing is closed, but it is waited for")

    def _frames(self, m: Module) -> None:
        """One closing beat for each frame."""
        record = self.dut.records.valid & ~self.last & ~self.time
        m.d.comb += [
            Assert(~self.at_output | (self.open != 0), "a closing beat without a frame"),
            Assert(~record | (self.others != 0), "a record without a frame"),
            Assert(
                ~self.guard.resume | self.packets.closed | (self.others == 0),
                "a frame that is cut is not closed",
            ),
        ]

    def _progress(self, m: Module) -> None:
        """No step takes for ever while the output is ready and not taken up by a time record."""
        dut, guard, ready = self.dut, self.guard, self.dut.records.ready
        going = ready & ~self.restart & ~self.closing & ~self.timing
        within(m, 3, during=self.closing & ready, happens=guard.resume, name="closing does not end")
        cut = guard.cut & ~self.restarted & (self.complete == 0) & ready
        within(m, 2, during=cut, happens=self.restart, name="a cut frame is not followed by a restart")
        within(
            m,
            2 * LATE + 1,
            during=(self.complete != 0) & going,
            happens=self.packets.done,
            name="a complete frame does not end",
        )
        video = dut.video.valid & going & ~guard.cut
        within(m, 2 * LATE + 2, during=video, happens=dut.video.ready, name="video is not taken")

    def _detector_holds(self, m: Module, sent: Place) -> None:
        """The detector has seen what the guard has sent, and the count of frames inside is true."""
        guard, detector, packets = self.guard, self.detector, self.packets
        most, place = (1 << len(self.complete)) - 1, detector.place
        m.d.comb += [
            Assert(~(packets.done & (self.complete == 0)), "inside: counts below zero"),
            Assert(~(guard.done & ~packets.done & (self.complete == most)), "inside: overflows"),
            Assert(
                ~self.restart | self.dut.control.reset | ((self.complete == 0) & (detector.pending == 0)),
                "a complete frame is lost",
            ),
            Cover(guard.cut & ~self.restarted & (self.complete != 0), "a cut waits for a complete frame"),
        ]
        invariant(m, (place.x == sent.x) & (place.y == sent.y), "the detector's place differs")
        with m.If(~sent.first):
            sizes = (detector.size["x"] == guard.frame_width) & (detector.size["y"] == guard.frame_height)
            invariant(m, sizes, "the detector's size differs")
        on_its_way = guard.o.valid & sent.eol & sent.last_row
        invariant(m, self.complete == detector.pending + on_its_way, "frames inside differ")
        invariant(m, detector.pending <= MOST, "the detector holds too many")


class ExactChecker(VideoDetectorChecker):
    """Without soft resets: all ends of frames in order, each flagged as cut only if it was."""

    def _frames(self, m: Module) -> None:
        super()._frames(m)
        guard, was_cut = self.guard, Signal()
        m.d.sync += was_cut.eq(guard.cut)
        rises = guard.cut & ~was_cut & ~self.restarted
        marked = self.dut.records.payload.record[CUT_SHIFT]
        board = Scoreboard(
            m,
            "ends of frames",
            enters=guard.done | rises,
            given=rises,
            leaves=self.ends,
            found=marked,
            capacity=MOST + 3,
            fills=False,
        )
        m.d.comb += [
            Assert(board.inside + guard.active == self.others + self.at_output - rises, "a frame has no end"),
            Cover(self.ends & marked, "a cut frame is closed"),
            Cover(self.ends & ~marked, "a complete frame is closed"),
        ]
        invariant(m, ~self.restart | (guard.cut & was_cut & (self.complete == 0)), "restart without a cut")
        invariant(m, ~self.closing | (self.inside["opened"] & (self.complete == 0)), "closing without a cut")
        invariant(m, ~self.inside["clearing"], "a reset is under way")
        ahead = board.ahead - self.at_output
        with m.If(board.following):
            first = self.at_output & (board.ahead == 0)
            invariant(m, board.value == Mux(first, marked, ahead == self.complete), "another end")


class ResetChecker(VideoDetectorChecker):
    """With soft resets at any time: the frame under way gives one closing beat; resets end."""

    resets = True

    def _progress(self, m: Module) -> None:
        super()._progress(m)
        dut = self.dut
        asked = dut.control.reset & dut.records.ready
        within(m, 7, during=asked, happens=dut.reset_done, name="a reset is not done")
        m.d.comb += [
            Cover(dut.reset_done & self.packets.closed, "a reset closes a packet"),
            Cover(dut.reset_done & ~self.packets.closed, "a reset has nothing to close"),
        ]


DEPTH = 2 * LATE + 4
"""One more than the longest wait: so all of a wait is in sight, and nothing need be said about its
counters.
"""

EXACT = Claim(
    says="VideoDetector: one packet for each frame, in order, and none is lost by a cut",
    design=hdl.edges.video_detector,
    check=ExactChecker,
    depth=DEPTH,
    covered=11,
    long=True,
    faults=(
        Fault("(guard.cut & empty)", "guard.cut", "a complete frame is lost", within=12),
        Fault("guard.active | guard.cut | ~drained", "guard.active", "is not closed", within=8),
        Fault("stopped.eq(restart | closing)", "stopped.eq(restart)", "guard: resume without", within=10),
        Fault("self._build.queue_depth + 31", "0", "inside: ", within=10),
    ),
)
RESET = Claim(
    says="VideoDetector: a reset by software is done whenever it comes, and closes what is open once",
    design=hdl.edges.video_detector,
    check=ResetChecker,
    depth=DEPTH,
    covered=11,
    long=True,
    faults=(
        Fault(
            "packets.close.eq(closing & opened)",
            "packets.close.eq(closing)",
            "a closing beat without",
            within=10,
        ),
        Fault("(packets.closed | ~opened)", "packets.closed", "closing does not end", within=8),
        Fault("packets.clear.eq(self.reset_done)", "packets.clear.eq(restart)", "in the middle", within=10),
    ),
)
LANES = Claim(
    says="VideoDetector, four pixels per clock: one packet for each frame, and none is lost by a cut",
    design=hdl.edges.video_detector,
    check=lambda design: ExactChecker(design, lanes=4),
    depth=DEPTH,
    covered=11,
    long=True,
    faults=(Fault("(guard.cut & empty)", "guard.cut", "a complete frame is lost", within=12),),
)


@pytest.mark.parametrize("case", cases(EXACT, RESET, LANES))
def test_video_detector(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
