# amaranth: UnusedElaboratable=no
"""Whole detectors with several pixels per clock: every record, every clock.

Mixtures, and eight pixels per clock, are tested without the way from pixels to responses, see
``test_lane_mixtures``, and that way without what comes behind it, see
``test_response_stage_lanes``: a whole detector of eight pixels per clock takes minutes to compile.
Amaranth's simulator runs small frames through it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flow.verilog import emit_verilog
from golden import Settings, StreamModel
from hdl.build import Build
from hdl.detector import Detector
from hdl.thresholds import Thresholds
from sim.beats import beat_count
from sim.engines import make_engine
from sim.frames import Frame, frame_stimulus, simulate_frames, split_frames
from sim.stimulus import Stalls
from tests.support.builds import each
from tests.support.detectors import (
    SMALL,
    STALLS,
    both_kinds,
    check,
    engine,
    everything,
    noise,
    run,
    run_with_reset,
)
from tests.support.photographs import PHOTOGRAPHS, photograph
from tests.support.strategies import any_frames, any_stalls

SIZE = {"max_width": 640, "max_height": 672}
BUILDS = {
    "robust, P=2": Build.profile("robust", **SIZE, pixels_per_clock=2),
    "paper, P=4": Build.profile("paper", **SIZE, pixels_per_clock=4),
}
builds = each("build", BUILDS, quick=("robust, P=2",))
stalling = pytest.mark.parametrize("stalls", STALLS.values(), ids=STALLS)


def clocks_of(build: Build, frames: list[Frame]) -> list[int]:
    """Clocks of frames that never wait: as many as they have beats."""
    return [beat_count(image.shape, build) for image, _ in frames]


@each("name", {name: name for name in PHOTOGRAPHS}, quick=("camera", "grass", "cell"))
@builds
def test_photographs(build: Build, name: str) -> None:
    """At the default thresholds and with every corner refined; widths of all remainders."""
    image = photograph(name)
    widths = [image.shape[1] - k % build.pixels_per_clock for k in range(3)]
    chosen = [Settings.default(build), everything(build), both_kinds(build)]
    frames: list[Frame] = [(image[:, :width], each) for width, each in zip(widths, chosen, strict=True)]
    result = run(build, frames)
    assert [frame.clocks for frame in result.frames] == clocks_of(build, frames)
    detector = Detector(build)
    for frame, width in zip(result.frames, widths, strict=True):
        late = frame.end_of_frame - frame.last_pixel - detector.frame_latency(width)
        assert 0 <= late <= detector.refinement_latency


@each(
    "build",
    {
        "robust, P=8": Build.profile("robust", **SMALL, pixels_per_clock=8),
        "robust banked, P=4": Build.profile("robust", **SMALL, buffering="banked", pixels_per_clock=4),
        "paper, P=8": Build.profile("paper", **SMALL, pixels_per_clock=8),
    },
    quick=("robust, P=8",),
)
def test_small_frames_in_amaranths_simulator(build: Build) -> None:
    """Whole detectors that take minutes to compile: nothing is compiled."""
    sizes = [(28, 37), (24, 42), (20, 31)]
    frames = [(noise(*size, k, build), both_kinds(build)) for k, size in enumerate(sizes)]
    result = simulate_frames(make_engine("amaranth", Detector(build)), frames, build, stalls=Stalls(0.1, 0.2))
    check(result, build, frames)
    assert min(len(frame.records) for frame in result.frames) > 3


@stalling
@builds
def test_photograph_under_stalls(build: Build, stalls: Stalls) -> None:
    image = photograph("camera")[100:301, 150:453]
    run(build, [(image, Settings.default(build)), (image, both_kinds(build))], stalls)


@stalling
@builds
def test_sizes(build: Build, stalls: Stalls) -> None:
    """The smallest frames without a pause, and every number of lanes in a row's last beat."""
    high, wide = build.algorithm.support, build.min_width
    rest = [(high + 1 + k, wide + 1 + k) for k in range(build.pixels_per_clock)]
    sizes = [(high, wide), (high, wide), *rest, (high, 512), (40, 61), (high, wide), (64, wide)]
    run(build, [(noise(*size, k, build), both_kinds(build)) for k, size in enumerate(sizes)], stalls)


@builds
def test_latency_without_corners(build: Build) -> None:
    detector, high, wide = Detector(build), build.algorithm.support, build.min_width
    for size in ((33, 47), (20, 64), (64, wide + 1), (20, 512)):
        result = run(build, [(np.zeros(size, np.uint8), Settings.default(build))] * 3)
        late = [frame.end_of_frame - frame.last_pixel for frame in result.frames]
        assert late == [detector.frame_latency(size[1])] * 3
    # the smallest frame may have to wait for its thresholds
    (frame,) = run(build, [(np.zeros((high, wide), np.uint8), Settings.default(build))]).frames
    more = frame.end_of_frame - frame.last_pixel - detector.frame_latency(wide)
    assert 0 <= more <= Thresholds(build).clocks


@builds
def test_full_rate(build: Build) -> None:
    """Back-to-back frames of one size never wait, be it for their thresholds."""
    for size in ((build.algorithm.support + 1, 64), (20, build.min_width), (20, 512), (64, 61)):
        frames = [(noise(*size, seed, build), Settings.default(build)) for seed in range(5)]
        assert [frame.clocks for frame in run(build, frames).frames] == clocks_of(build, frames)


@builds
def test_the_smallest_frames_wait_for_their_thresholds(build: Build) -> None:
    """As long as the page says, at most."""
    at_least = 56 if build.buffering == "banked" else 48
    for height in range(build.algorithm.support, 20):
        size = height, build.min_width
        frames = [(noise(*size, seed, build), Settings.default(build)) for seed in range(5)]
        beats = beat_count(size, build)
        longest = max(frame.clocks for frame in run(build, frames).frames)
        assert beats <= longest <= max(beats, at_least + 8 * beat_count((1, size[1]), build))
        assert longest > beats or height > build.algorithm.support


@builds
def test_a_change_of_size_costs_at_most_the_push(build: Build) -> None:
    """A frame waits for the rows of a wider one, one in each buffer."""
    least = (build.algorithm.support, build.min_width)
    sizes = [(24, 64), (20, 512), (24, 64), (512, least[1] + 3), (20, 509), (24, 64)]
    frames = [(noise(*size, k, build), Settings.default(build)) for k, size in enumerate(sizes)]
    result = run(build, frames)
    push = build.rows_late * 512 // build.pixels_per_clock
    for frame, beats in zip(result.frames, clocks_of(build, frames), strict=True):
        assert beats <= frame.clocks <= beats + push


@builds
def test_silence_of_rejected_corners(build: Build) -> None:
    """Candidates in plenty up to the last row, each read and found textured: no record but ends."""
    y, x = np.mgrid[:48, :512]
    rejecting = Settings.default(build, sigma1=0, sigma2=0)
    images_of = [255 * ((x % n == 0) & (y % n == 0)).astype(np.uint8) for n in (3, 5)]
    images_of += [255 * (noise(48, 512, 1, build) // 128)]
    for frame in run(build, [(image, rejecting) for image in images_of]).frames:
        assert frame.end_of_frame - frame.last_pixel <= Detector(build).longest_silence(512)
        assert len(frame.records) == 1 or build.algorithm.texture == "none"


def test_corners_on_the_last_possible_pixels() -> None:
    """Nearest to a frame's end that a candidate can come, in every lane of a row's last beat."""
    build = BUILDS["robust, P=2"]
    margin = build.algorithm.margin
    for width in (16, 17):
        image = [noise(2 * margin + 2, width, seed, build) for seed in range(400)]
        result = run(build, [(each, Settings.default(build, sigma1=0, sigma2=0)) for each in image])
        last_rows = [records_in_row(frame.records, margin + 1) for frame in result.frames]
        columns = {column for row in last_rows for column in row}
        assert {width - 1 - margin, width - 2 - margin} <= columns


def records_in_row(records: Any, row: int) -> list[int]:
    """Nearest pixel columns of the corners in a row."""
    places = records[:-1] & np.uint64((1 << 40) - 1)
    x, y = (np.round((part & np.uint64(0xFFFFF)) / 128) for part in (places, places >> np.uint64(20)))
    return [int(column) for column in x[y == row]]


@builds
@given(data=st.data())
@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])
def test_any_images_sizes_and_stalls(build: Build, data: st.DataObject) -> None:
    run(build, data.draw(any_frames(build)), data.draw(any_stalls()))


@builds
@given(data=st.data(), seed=st.integers(0, 99))
@settings(max_examples=20, suppress_health_check=[HealthCheck.too_slow])
def test_reset_in_mid_frame(build: Build, data: st.DataObject, seed: int) -> None:
    """After a reset anywhere the next frames are as after power-on."""
    sizes = [(30, 41), (20, 27), (25, 26)]
    broken, *frames = [(noise(*size, seed + k, build), both_kinds(build)) for k, size in enumerate(sizes)]
    cut = data.draw(st.integers(1, beat_count(sizes[0], build) - 1))
    before = run_with_reset(build, broken, frames, cut, seed)
    assert np.array_equal(before, StreamModel(build).process(*broken).records[: len(before)])


@builds
def test_the_emitted_verilog_in_an_independent_simulator(build: Build, tmp_path: Path) -> None:
    """Verilator, starting from random contents of everything that is not reset.

    Rows end in every lane, and what is beyond them differs from row to row.
    """
    verilog = tmp_path / "cornerstream.v"
    verilog.write_text(emit_verilog(build))
    simulator = make_engine("verilog", Detector(build), verilog=verilog)
    image = photograph("camera")
    widths = [512, *(300 - k for k in range(build.pixels_per_clock))]
    frames: list[Frame] = [(image[: width // 2, :width], both_kinds(build)) for width in widths]
    stimulus = frame_stimulus(frames, build, Stalls(0.1, 0.1, 7))
    capture = simulator.run(stimulus, quiet=3000)
    check(split_frames(capture, [beat_count(part.shape, build) for part, _ in frames]), build, frames)
    compiled = engine(build).run(stimulus, quiet=3000)
    assert np.array_equal(capture.output_clocks["o"], compiled.output_clocks["o"])
