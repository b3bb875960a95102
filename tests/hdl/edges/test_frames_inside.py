# amaranth: UnusedElaboratable=no
"""How many complete frames are inside when an output stalls: no more than are counted."""

from __future__ import annotations

from typing import Any

import numpy as np
from amaranth.hdl import Module, Signal
from amaranth.lib import stream
from amaranth.lib.wiring import Out

from golden import Settings
from golden.video import VideoModel, VideoSettings, framed
from hdl.build import Build
from hdl.edges.lane_overlay import LaneOverlay
from hdl.edges.overlay import Overlay
from hdl.edges.video_detector import VideoDetector
from sim import Stalls, Stimulus
from sim.beats import beat_count
from tests.formal.design import probes_of
from tests.hdl.edges.components import PlainVideoDetector, packets, payloads
from tests.support.blocks import engine
from tests.support.builds import each
from tests.support.malformed import packed

BUILDS = {
    f"{profile}-{lanes}-{buffering}{'-video' * video_out}": Build.profile(
        profile,
        pixels_per_clock=lanes,
        buffering=buffering,
        video_out=video_out,
        max_width=64,
        max_height=32,
        queue_depth=8,
    )
    for profile, lanes, buffering, video_out in (
        ("paper", 1, "banked", True),
        ("paper", 1, "lean", False),
        ("robust", 2, "banked", False),
        ("robust", 4, "lean", False),
        ("robust", 4, "banked", True),
        ("paper", 8, "banked", True),
        ("robust", 8, "banked", False),
    )
}
COUNT_BITS = 8


class Counting(PlainVideoDetector):
    """Tells of each number of complete frames inside that was never reached before.

    They are those whose records, or with ``video_out`` whose pixels, have not all come out.
    """

    def __init__(self, parameters: Build) -> None:
        super().__init__(parameters, counts=Out(stream.Signature(COUNT_BITS, always_ready=True)))
        self._shows = parameters.video_out

    def elaborate(self, platform: Any) -> Module:
        inside = probes_of(self.dut)["shown" if self._shows else "inside"]
        m = super().elaborate(platform)
        most = Signal(COUNT_BITS)
        m.d.comb += [self.counts.valid.eq(inside > most), self.counts.payload.eq(inside)]
        with m.If(self.counts.valid):
            m.d.sync += most.eq(inside)
        return m


@each("parameters", BUILDS, quick=("robust-4-lean",))
def test_all_are_counted(parameters: Build) -> None:
    """Frames as small as can be, most without a corner, while nearly nothing is taken."""
    random = np.random.default_rng(parameters.pixels_per_clock)
    height, width = parameters.algorithm.support, parameters.min_width
    images = [random.integers(0, 256 if k % 9 == 0 else 1, (height, width), np.uint8) for k in range(90)]
    settings = Settings.default(parameters, sigma1=0.02)
    video = VideoSettings(width, height, settings, send_time=True)
    lanes = parameters.pixels_per_clock
    beats = [beat for image in images for beat in packed(framed(image), lanes)]
    expected = VideoModel(parameters, lanes).feed(beats, video)
    stimulus = Stimulus(
        {"video": payloads(beats, parameters)}, [(0, video.fixed(parameters))], Stalls(0, 0.995, 3)
    )
    capture = engine("compiled", Counting, parameters).run(stimulus, quiet=3000)
    clocks = capture.input_clocks["video"]
    for packet, words in zip(expected, packets(capture), strict=True):
        assert packet.matches(words, int(clocks[packet.begun]))
    most, promised = int(capture.outputs["counts"].max()), VideoDetector(parameters)._most_inside
    print(f"{most} of {promised}")
    assert least_inside(parameters, height * beat_count((1, width), parameters)) <= most <= promised


def least_inside(build: Build, beats: int) -> int:
    """Frames of so many beats that there must be inside, or such frames would show nothing.

    Several stages reserve what these do not use. Pixels wait in the overlay.
    """
    if build.video_out:
        return (LaneOverlay if build.pixels_per_clock > 1 else Overlay)(build).depth // beats
    return VideoDetector(build)._most_inside // 4
