"""Faults in what is around the detector."""

from __future__ import annotations

from tests.mutations.copies import Mutation

EDGES = {
    "pixels are taken while a frame is cut": Mutation(
        "hdl/edges/frame_guard.py",
        "self.i.ready.eq(~self.cut & ~self.restart",
        "self.i.ready.eq(~self.restart",
        "tests/hdl/edges/test_frame_guard.py",
        "cut_waits",
    ),
    "a long line ends with the first pixel that is too many": Mutation(
        "hdl/edges/frame_guard.py",
        "surplus.eq(~eol)",
        "surplus.eq(0)",
        "tests/hdl/edges/test_frame_guard.py",
        "long_line",
    ),
    "records of one packet are counted into the next": Mutation(
        "hdl/edges/packet_constructor.py",
        "with m.If(self.ended | self.clear):",
        "with m.If(self.done | self.clear):",
        "tests/hdl/edges/test_packet_constructor.py",
        "packets_by_hand",
    ),
    "a packet with a time has two ends": Mutation(
        "hdl/edges/packet_constructor.py",
        "timing | ((last | self.close) & ~self.send_time)",
        "timing | last | self.close",
        "tests/hdl/edges/test_packet_constructor.py",
        "with_times_by_hand",
    ),
    "a frame's time is when it reaches the guard": Mutation(
        "hdl/edges/video_detector.py",
        "clock.arrives.eq(video.valid & video.ready & video.payload.sof)",
        "clock.arrives.eq(taken)",
        "tests/hdl/edges/test_video_detector.py",
        "amaranths and maximum",
    ),
    "a start of frame that is dropped keeps its time": Mutation(
        "hdl/edges/frame_clock.py",
        "self.arrives - self.drops",
        "self.arrives",
        "tests/hdl/edges/test_frame_clock.py",
        "times_by_hand",
    ),
    "a carry comes a clock late": Mutation(
        "hdl/edges/frame_clock.py",
        "(1 << len(low)) - 2",
        "(1 << len(low)) - 1",
        "tests/hdl/edges/test_frame_clock.py",
        "halves_count",
    ),
    "a frame that was forgotten keeps its place": Mutation(
        "hdl/edges/frame_clock.py",
        "Mux(self.forget, begun, Mux(self.ends, after, place))",
        "Mux(self.ends, after, place)",
        "tests/hdl/edges/test_frame_clock.py",
        "forgotten",
    ),
    "a cut does not wait for the frames before": Mutation(
        "hdl/edges/video_detector.py",
        "(guard.cut & empty)",
        "guard.cut",
        "tests/hdl/edges/test_video_detector.py",
        "amaranths and maximum",
    ),
    "a restart loses the reference": Mutation(
        "hdl/edges/video_detector.py",
        "settings.use_constant | ~self._packets.any_results,",
        "1,",
        "tests/hdl/edges/test_video_detector.py",
        "amaranths and maximum",
    ),
    "pixels are flagged that can be no corner": Mutation(
        "hdl/edges/overlay.py",
        "flagged & self.corner_flags.payload.corner",
        "self.corner_flags.valid & self.corner_flags.payload.corner",
        "tests/hdl/edges/test_overlay.py",
        "pixels_and_corners_in_amaranths",
    ),
    "an event is lost where it is cleared": Mutation(
        "hdl/edges/register_bank.py",
        "happens | (self._status_bits[bit] & ~cleared)",
        "(happens | self._status_bits[bit]) & ~cleared",
        "tests/hdl/edges/test_registers.py",
        "sticky",
    ),
    "a frame is done while its end waits": Mutation(
        "hdl/edges/packet_constructor.py",
        "delivered = self.o.valid & self.o.ready & self.o.payload.last",
        "delivered = self.o.valid & self.o.payload.last",
        "tests/hdl/edges/test_packet_constructor.py",
        "packets_by_hand",
    ),
    "a timeout that is lowered is passed over": Mutation(
        "hdl/edges/watchdog.py",
        "waited >= self.limit",
        "waited == self.limit",
        "tests/hdl/edges/test_watchdog.py",
        "lowered",
    ),
    "a write of no byte is refused": Mutation(
        "hdl/edges/register_bank.py",
        "bus.write & bus.write_mask.any()",
        "bus.write",
        "tests/hdl/edges/test_registers.py",
        "no_byte",
    ),
    "a control packet is taken for video": Mutation(
        "hdl/edges/avalon.py",
        "self.asi_video_data[:PACKET_TYPE_BITS] == VIDEO_PACKET",
        "self.asi_video_data[:1] == VIDEO_PACKET",
        "tests/hdl/edges/test_avalon.py",
        "low_four_bits and amaranth",
    ),
}
