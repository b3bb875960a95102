# amaranth: UnusedElaboratable=no
"""The guarded detector against its golden model, with any video and any stalls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

from golden import Parameters, Settings
from golden.preprocessing import Image
from golden.video import VideoModel, VideoSettings, framed
from hdl.build import Build
from hdl.edges.video_detector import VideoDetector
from sim import Capture, Stalls, Stimulus
from sim.engine import Engine
from tests.hdl.edges.components import PlainVideoDetector, packets, payloads
from tests.support.blocks import engine
from tests.support.builds import each
from tests.support.filters import lenient, selective
from tests.support.malformed import Beats, random_video
from tests.support.photographs import photograph

MAX_WIDTH, MAX_HEIGHT = 40, 32
BUILDS = {
    f"{name}-{buffering}": Build.profile(
        name, buffering=buffering, max_width=MAX_WIDTH, max_height=MAX_HEIGHT
    )
    for name in ("paper", "robust")
    for buffering in ("banked", "lean")
} | {
    "robust-budget": Build.profile(
        "robust",
        response_filter="none",
        budget=True,
        suppression=2,
        max_per_cell=2,
        max_width=MAX_WIDTH,
        max_height=MAX_HEIGHT,
    ),
    "paper-cells": Build.profile("paper", max_per_cell=3, max_width=MAX_WIDTH, max_height=MAX_HEIGHT),
    "paper-budget": Build.profile("paper", budget=True, max_width=MAX_WIDTH, max_height=MAX_HEIGHT),
}
STALLS = {
    "flowing": Stalls(),
    "both stall": Stalls(0.4, 0.4, 1),
    "output stalls": Stalls(0, 0.7, 2),
    "input idles": Stalls(0.7, 0, 3),
}

builds = each("parameters", BUILDS, quick=("robust-budget",))


def video_settings(parameters: Parameters, image: Image) -> VideoSettings:
    height, width = image.shape
    budget = {"target_corners": 4, "max_corners": 6} if parameters.budget else {}
    cells = {"cell_width": 9, "cell_height": 8, "per_cell": 2} if parameters.max_per_cell else {}
    chosen = Settings.default(parameters, sigma1=0.02, sigma2=selective(parameters), **budget, **cells)
    return VideoSettings(width, height, chosen)


def run(
    runner: Engine,
    parameters: Parameters,
    parts: Sequence[tuple[Beats, VideoSettings]],
    stalls: Stalls,
    *,
    send_time: bool = True,
) -> tuple[Capture, VideoModel]:
    """Feed these and compare every packet, with its time."""
    model = VideoModel(parameters)
    parts = [(beats, replace(video, send_time=send_time)) for beats, video in parts]
    expected = [packet for beats, video in parts for packet in model.feed(beats, video)]
    starts = np.cumsum([0, *(len(beats) for beats, _ in parts)])
    changes = [(int(k), video.fixed(parameters)) for k, (_, video) in zip(starts, parts, strict=False)]
    words = payloads([beat for beats, _ in parts for beat in beats], parameters)
    capture = runner.run(Stimulus({"video": words}, changes, stalls), quiet=2000)
    got, clocks = packets(capture), capture.input_clocks["video"]
    for number, (packet, records) in enumerate(zip(expected, got, strict=False)):
        clock = int(clocks[packet.begun])
        assert packet.matches(records, clock), (number, packet.cut, clock, packet.records, records)
    # a frame that has not ended may have shown corners already
    assert len(got) == len(expected) + (model.active and len(got) > len(expected))
    return capture, model


@pytest.mark.parametrize("stalls", STALLS.values(), ids=STALLS.keys())
@builds
def test_malformed_video(parameters: Parameters, stalls: Stalls) -> None:
    runner = engine("compiled", PlainVideoDetector, parameters)
    random = np.random.default_rng(stalls.seed)
    width, height = int(random.integers(15, MAX_WIDTH + 1)), int(random.integers(15, MAX_HEIGHT + 1))
    frames = random_video(random, 128, width, height)
    assert len(frames.tried) > 8, frames.tried
    video = video_settings(parameters, frames.frames[0][0])
    run(runner, parameters, [(beats, video) for _, beats in frames.frames], stalls)


@builds
def test_full_rate_and_latency(parameters: Parameters) -> None:
    """W·H clocks per frame, and the end-of-frame record after ``latency`` if no corner waits."""
    runner = engine("compiled", PlainVideoDetector, parameters)
    dut = VideoDetector(parameters)
    for width, height in ((15, 15), (MAX_WIDTH, MAX_HEIGHT), (33, 17)):
        blank = np.zeros((height, width), np.uint8)
        parts = [(framed(blank), video_settings(parameters, blank))] * 4
        capture, _ = run(runner, parameters, parts, Stalls(), send_time=False)
        clocks = capture.input_clocks["video"]
        assert clocks.tolist() == list(range(clocks[0], clocks[0] + len(clocks)))
        ends = capture.output_clocks["records"]
        last_pixels = clocks[width * height - 1 :: width * height]
        # where cells choose, the last row of them is over a clock before the frame
        late = dut.frame_latency(width) + (parameters.max_per_cell > 0)
        assert (ends - last_pixels).tolist() == [late] * 4


@builds
def test_photographs_at_full_rate(parameters: Parameters) -> None:
    runner = engine("compiled", PlainVideoDetector, parameters)
    crops = [
        photograph(name)[100 : 100 + MAX_HEIGHT, 100 : 100 + MAX_WIDTH]
        for name in ("camera", "brick", "coins")
    ]
    parts = [(framed(crop), video_settings(parameters, crop)) for crop in crops]
    capture, _ = run(runner, parameters, parts, Stalls())
    clocks = capture.input_clocks["video"]
    assert clocks[-1] - clocks[0] + 1 == len(clocks) == 3 * MAX_WIDTH * MAX_HEIGHT


@pytest.mark.parametrize("stalls", [Stalls(), Stalls(0.3, 0.5, 4)], ids=["flowing", "both stall"])
@builds
def test_sizes_and_settings_change_from_frame_to_frame(parameters: Parameters, stalls: Stalls) -> None:
    """Also those that change in the middle of a frame, which keeps its own."""
    runner = engine("compiled", PlainVideoDetector, parameters)
    random = np.random.default_rng(5)
    parts: list[tuple[Beats, VideoSettings]] = []
    for number in range(40):
        width, height = int(random.integers(15, MAX_WIDTH + 1)), int(random.integers(15, MAX_HEIGHT + 1))
        image = random.integers(0, 256, (height, width), dtype=np.uint8)
        beats, video = framed(image), video_settings(parameters, image)
        if parameters.budget:
            budget = {"target_corners": int(random.choice([0, 2, 9])), "max_corners": number % 7}
            budget |= {"reference_rank": number % 5, "smoothing": number % 4}
            video = replace(video, settings=replace(video.settings, **budget))
        if parameters.max_per_cell:
            cells = {"cell_width": 8 + number % 11, "cell_height": 8 + number % 13, "per_cell": number % 3}
            video = replace(video, settings=replace(video.settings, **cells))
        if number % 4 == 1:
            # cut, after which the next size holds at once
            beats = beats[: int(random.integers(60, len(beats)))]
        if number % 4 == 2:
            other = VideoSettings(15, 15, Settings.default(parameters, sigma1=0.5), enabled=False)
            parts += [(beats[:100], video), (beats[100:], other)]
        else:
            parts.append((beats, video))
    run(runner, parameters, parts, stalls)


@pytest.mark.parametrize("pixels", [*range(1, 60, 2), 200, 400])
@builds
def test_a_frame_cut_right_after_a_whole_one(parameters: Parameters, pixels: int) -> None:
    """The frame before is still inside, and comes out whole."""
    runner = engine("compiled", PlainVideoDetector, parameters)
    images = [photograph("grass")[k : k + 30, 10:45] for k in (0, 40, 80)]
    whole, cut, after = (framed(image) for image in images)
    video = video_settings(parameters, images[0])
    run(runner, parameters, [(whole + cut[:pixels] + after, video)], Stalls(0, 0.5, pixels))


@builds
def test_a_stalled_output_stalls_the_input_and_loses_nothing(parameters: Parameters) -> None:
    """Frames as small as can be, of which most are inside at once."""
    runner = engine("compiled", PlainVideoDetector, parameters)
    images = [photograph("text")[k : k + 15, 60:75] for k in range(60)]
    parts = [(framed(image), video_settings(parameters, image)) for image in images]
    run(runner, parameters, parts, Stalls(0, 0.99, 6))


@pytest.mark.parametrize(("sigma1", "target"), [(0.1, 0), (0.001, 1)], ids=["maximum", "target"])
def test_cut_frames_in_amaranths_simulator(sigma1: float, target: int) -> None:
    """A frame is cut right after a whole one, which comes out whole; what that passes on reaches
    the next one.

    Nothing is compiled: it takes two seconds to tell what a change of the sources does.
    """
    parameters = Build.profile("paper", max_width=24, max_height=24, buffering="lean", budget=True)
    random = np.random.default_rng(7)
    images = [random.integers(0, top, (24, 24), np.uint8) for top in (256, 256, 100, 256, 100)]
    kept = (576, 20, 576, 300, 576)
    beats = [beat for image, pixels in zip(images, kept, strict=True) for beat in framed(image)[:pixels]]
    settings = Settings.default(
        parameters, sigma1=sigma1, sigma2=lenient(parameters), target_corners=target, constant=1
    )
    runner = engine("amaranth", PlainVideoDetector, parameters)
    capture, _ = run(runner, parameters, [(beats, VideoSettings(24, 24, settings))], Stalls(0, 0.5, 1))
    found = packets(capture)
    assert len(found) == 5 and len(found[0]) > 2
