# amaranth: UnusedElaboratable=no
"""Candidate texture: tau of single windows against T2, with one and with two columns per clock."""

from __future__ import annotations

import numpy as np
import pytest

from golden.algorithm import Patches
from golden.texture_filter import texturization
from hdl.build import Build
from hdl.candidate_texture import CandidateTexture
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, Array, run_block
from tests.support.candidates import window_columns

PATCHES: list[Patches] = ["regions", "pixels"]
both = pytest.mark.parametrize("patches", PATCHES)
every = pytest.mark.parametrize("lanes", [2, 4, 8])


def build_of(lanes: int, patches: Patches, pixel_bits: int = 8) -> Build:
    return Build.profile("paper", pixels_per_clock=lanes, patches=patches, pixel_bits=pixel_bits)


def noise(count: int, build: Build) -> Array:
    """Half of them of the two bounds only, with the largest differences that there are."""
    rng = np.random.default_rng(count)
    windows = rng.integers(0, build.response_max, (count, 9, 9), endpoint=True)
    return np.where(np.arange(count)[:, None, None] % 2, windows, build.response_max * (windows % 2))


def check(
    build: Build, windows: Array, t2: int, name: EngineName = "compiled", stalls: Stalls = NO_STALLS
) -> Capture:
    """T2 is a frame's; here all windows are one frame's."""
    textured = texturization(windows, build.algorithm.patches) >= t2
    reports = t2 % 2
    limits = {"t1": np.zeros(1), "t2": np.array([t2]), "report_rejected": np.array([reports])}
    ends = {"eol": np.ones(len(windows)), "eof": np.arange(len(windows)) == len(windows) - 1}
    if build.pixels_per_clock > 1:
        limits["last_lanes"] = np.zeros(1)
    verdicts = {"textured": textured, "keep": ~textured | bool(reports)}
    return run_block(
        (CandidateTexture, build),
        {"i": window_columns(windows, build), "thresholds": limits},
        {"o": {"data": verdicts, **ends}},
        name,
        stalls,
    )


def between(windows: Array, patches: Patches) -> int:
    """A tau that occurs, in the middle of them all: the comparison must be exact."""
    return int(np.sort(texturization(windows, patches))[len(windows) // 2])


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("lanes", [4, 8])
@both
def test_noise(lanes: int, patches: Patches, name: EngineName, stalls: Stalls) -> None:
    build = build_of(lanes, patches)
    windows = noise(400 if name == "compiled" else 20, build)
    capture = check(build, windows, between(windows, patches), name, stalls)
    if stalls == NO_STALLS:
        last = capture.input_clocks["i"][-1]
        assert capture.output_clocks["o"][-1] - last == CandidateTexture(build).latency
        assert len(capture.input_clocks["i"]) == len(windows) * (5 if build.window_reads == 2 else 10)


@every
@both
def test_around_every_tau(lanes: int, patches: Patches) -> None:
    """F is tau < T2: at each of some taus, and next to them, up to the largest T2 there is."""
    build = build_of(lanes, patches)
    windows = noise(30, build)
    tau = texturization(windows, patches)
    for t2 in {0, 1, *tau[:4].tolist(), *(tau[:4] + 1).tolist(), build.texture_max, build.texture_max + 1}:
        check(build, windows, t2)


@pytest.mark.parametrize("lanes", [4, 8])
@both
def test_every_place_of_the_window(lanes: int, patches: Patches) -> None:
    """A lone response in each of 81 places, on dark and on bright ground."""
    build = build_of(lanes, patches)
    lone = np.eye(81, dtype=np.int64).reshape(81, 9, 9) * build.response_max
    for windows in (lone, build.response_max - lone):
        for t2 in np.unique(texturization(windows, patches)).tolist():
            check(build, windows, t2)
            check(build, windows, t2 + 1)


@pytest.mark.parametrize("lanes", [4, 8])
@pytest.mark.parametrize("pixel_bits", [4, 10])
def test_pixel_bits(lanes: int, pixel_bits: int) -> None:
    """Stripes have the largest tau."""
    build = build_of(lanes, "regions", pixel_bits)
    stripes = np.zeros((9, 9), np.int64)
    stripes[::2] = build.response_max
    windows = np.concatenate([noise(20, build), stripes[None], stripes.T[None]])
    assert texturization(windows, "regions").max() == build.texture_max
    for t2 in (build.texture_max, build.texture_max + 1, between(windows, "regions")):
        check(build, windows, t2)
