# amaranth: UnusedElaboratable=no
"""Every mixture with several pixels per clock, from responses to records, against golden."""

from __future__ import annotations

from dataclasses import replace
from itertools import cycle
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from golden import Settings
from golden.algorithm import FIT_REACH
from hdl.build import Build
from hdl.candidate_stage import CandidateStage
from hdl.record_stage import RecordStage
from hdl.thresholds import Thresholds
from sim.beats import beat_count
from sim.frames import Frame
from sim.stimulus import Stalls
from tests.support.behind_responses import run, run_with_reset
from tests.support.builds import each
from tests.support.detectors import MIXTURES, SMALL, STALLS, both_kinds, everything, noise
from tests.support.photographs import PHOTOGRAPHS, photograph
from tests.support.strategies import any_frames, any_stalls

WITH_LANES = {
    name: build.changed(**SMALL)
    for name, build in MIXTURES.items()
    # gradient steps need the pixels, too; paper is tested as a whole
    if name != "paper" and not FIT_REACH[build.algorithm.fit]
} | {
    "all that can be built": Build.profile(
        "robust", **SMALL, texture="mean", max_per_cell=4, budget=True, video_out=True
    ),
    "10-bit pixels, mean, suppression 3": Build.profile(
        "paper", **SMALL, texture="mean", suppression=3, pixel_bits=10, max_per_cell=3
    ),
    "shortest queues, suppression 4, cells of 8 pixels": Build.profile(
        "paper",
        **SMALL,
        texture="none",
        suppression=4,
        ties="first",
        queue_depth=8,
        refinement_units=3,
        video_out=True,
        max_per_cell=8,
        min_cell_width=8,
    ),
}
# each number of lanes with different values of the other fields
BUILDS = {
    f"{name}, P={lanes}": build.changed(pixels_per_clock=lanes)
    for (name, build), lanes in zip(WITH_LANES.items(), cycle((8, 2, 4)), strict=False)
}
builds = each("build", BUILDS, quick=("all that can be built, P=8",))


def beats_of_responses(build: Build, size: tuple[int, int]) -> list[int]:
    """Beats of each row of responses of a frame of this (height, width)."""
    lost, (height, width) = 2 * build.algorithm.response_margin, size
    return [beat_count((1, width), build) - lost // build.pixels_per_clock] * (height - lost)


def black_and_white(build: Build, values: Any) -> Any:
    """The smallest and the largest pixel, where these are false and true."""
    return (values * build.pixel_max).astype(np.uint8 if build.pixel_bits <= 8 else np.uint16)


@pytest.mark.parametrize("stalls", STALLS.values(), ids=STALLS)
@builds
def test_sizes(build: Build, stalls: Stalls) -> None:
    """The smallest frames without a pause, and every number of lanes in a row's last beat."""
    high, wide = build.algorithm.support, build.min_width
    rest = [(high + 1 + k, wide + 1 + k) for k in range(build.pixels_per_clock)]
    sizes = [(high, wide), (high, wide), *rest, (high, 64), (40, 61), (high, wide), (high, wide), (64, wide)]
    run(build, [(noise(*size, k, build), both_kinds(build)) for k, size in enumerate(sizes)], stalls)


@pytest.mark.parametrize("stalls", [Stalls(), Stalls(outputs=0.95, seed=1)], ids=["unstalled", "clogged"])
@builds
def test_more_candidates_than_can_be_read(build: Build, stalls: Stalls) -> None:
    """Dots as near to each other as peaks can be, ties in plenty, noise: the samples wait."""
    y, x = np.mgrid[:64, :64]
    grids = [(x % n == 0) & (y % n == 0) for n in range(2, 7)]
    tosses = [noise(64, 64, seed, build) > build.pixel_max // 2 for seed in range(2)]
    frames = [(black_and_white(build, values), everything(build)) for values in [*grids, *tosses]]
    capture = run(build, frames, stalls)
    assert len(capture.output_clocks["o"]) > 150 or build.algorithm.suppression > 2


@builds
def test_latency(build: Build) -> None:
    """From a frame's last response to its end, where there is no candidate: what blocks say.

    Windows of the smallest frames wait for thresholds.
    """
    stage, records = CandidateStage(build), RecordStage(build)
    late = sum(block.latency for block in [*stage.blocks.values(), *records.blocks.values()]) + stage.end_late
    high, wide = build.algorithm.support, build.min_width
    # one row of windows each: ends of rows may take longer to read than such narrow rows to come
    sizes = [(high, 64), (high, 61), (high, wide), (high, wide + 1)]
    flat = [(black_and_white(build, np.zeros(size)), Settings.default(build)) for size in sizes]
    capture = run(build, flat)
    rows = [beats_of_responses(build, size) for size in sizes]
    ends = np.cumsum([sum(beats) for beats in rows])
    buffers = (1 + build.buffers_smoothed) * (build.buffering == "banked")
    read_out = buffers * (np.array([beats[0] for beats in rows]) - 1)
    more = capture.output_clocks["o"] - capture.input_clocks["samples"][ends - 1] - late - read_out
    assert (more[:2] == 0).all() and (more >= 0).all() and (more <= Thresholds(build).clocks).all()


@builds
@given(data=st.data())
@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow])
def test_any_images_sizes_and_stalls(build: Build, data: st.DataObject) -> None:
    run(build, data.draw(any_frames(build)), data.draw(any_stalls()))


@each("name", {name: name for name in PHOTOGRAPHS}, quick=())
@pytest.mark.parametrize("profile", ["paper", "robust"])
def test_photographs(profile: str, name: str) -> None:
    """With eight pixels per clock the samples never wait within a frame, whatever is refined."""
    build = Build.profile(profile, max_width=640, max_height=672, buffering="lean", pixels_per_clock=8)
    image = photograph(name)
    chosen = [Settings.default(build), everything(build), both_kinds(build)]
    frames: list[Frame] = [(image[:, : image.shape[1] - k], each) for k, each in enumerate(chosen)]
    clocks = run(build, frames).input_clocks["samples"]
    ends = np.cumsum([sum(beats_of_responses(build, image.shape)) for image, _ in frames])
    within = [np.diff(each) for each in np.split(clocks, ends[:-1])]
    assert [int(steps.max()) for steps in within] == [1, 1, 1]


@builds
@given(percent=st.integers(5, 99), seed=st.integers(0, 99))
@settings(max_examples=15)
def test_reset_in_mid_frame(build: Build, percent: int, seed: int) -> None:
    """Candidates, counts, cells, flags and thresholds of a broken frame are gone."""
    sizes = [(40, 41), (20, 27), (25, 46)]
    aimed = aiming(build)
    broken, *frames = [(noise(*size, seed + k, build), aimed) for k, size in enumerate(sizes)]
    cut = percent * sum(beats_of_responses(build, sizes[0])) // 100
    run_with_reset(build, broken, frames, cut, Stalls(outputs=0.3, seed=seed))


def aiming(build: Build) -> Settings:
    """Corners in plenty, and of the others settings as many as there are."""
    chosen: dict[str, int] = {"target_corners": 9, "max_corners": 20} if build.budget else {}
    if build.max_per_cell:
        chosen |= {"cell_width": 16, "cell_height": 9, "per_cell": 1}
    return replace(both_kinds(build), **chosen)
