# amaranth: UnusedElaboratable=no
"""Texture filter: tau against T2, both readings of the patches, from frame to frame."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from golden.algorithm import Patches
from golden.texture_filter import texture_filter, texturization
from hdl.build import Build
from hdl.texture_filter import TextureFilter
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    check_block,
    columns,
    extremes,
    noise,
    raster,
)

PATCHES: list[Patches] = ["regions", "pixels"]
FULL = Build.profile("paper").response_max
both = pytest.mark.parametrize("patches", PATCHES)


def windows(frame: Array) -> Array:
    return sliding_window_view(frame, (9, 9))


def check(
    patches: Patches,
    frames: list[Array],
    t2: list[int],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    pixel_bits: int = 8,
) -> Capture:
    """Every other frame also reports what is rejected."""
    reported = [k % 2 for k in range(len(frames))]
    results = []
    for frame, limit, report in zip(frames, t2, reported, strict=True):
        textured = ~texture_filter(windows(frame), limit, patches)
        results.append(np.stack([textured, ~textured | bool(report)], axis=-1))
    # T1 is not for this block
    limits = {"t1": np.full(len(t2), FULL), "t2": np.array(t2), "report_rejected": np.array(reported)}
    return check_block(
        (TextureFilter, Build.profile("paper", patches=patches, pixel_bits=pixel_bits)),
        {"i": columns(frames, 9), "thresholds": limits},
        {"o": raster(results, ("textured", "keep"))},
        name,
        stalls,
        window=9,
        held={"thresholds": "o"},
    )


def between(frame: Array, patches: Patches) -> int:
    """A tau that occurs in the frame, in the middle of them all: the comparison must be exact."""
    tau = np.sort(texturization(windows(frame), patches), axis=None)
    return int(tau[len(tau) // 2])


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@both
def test_noise(patches: Patches, name: EngineName, stalls: Stalls) -> None:
    sizes = [(25, 30), (9, 9), (9, 40), (14, 9), (11, 17), (9, 9)]
    frames = noise(sizes if name == "compiled" else [(9, 9), (10, 13), (10, 9)], FULL)
    check(patches, frames, [between(frame, patches) for frame in frames], name, stalls)


@both
def test_around_every_tau(patches: Patches) -> None:
    """T2 at each tau of a small frame, and one above it: F is tau < T2."""
    (frame,) = noise([(10, 11)], 20, 1)
    tau = np.unique(texturization(windows(frame), patches)).tolist()
    t2 = sorted({0, *tau, *(value + 1 for value in tau)})
    check(patches, [frame] * len(t2), t2)


@both
def test_every_place_of_the_window(patches: Patches) -> None:
    """A lone response in each of 81 places, with T2 at its tau, above it, and at all multiples."""
    frames, t2 = [], []
    for place in range(81):
        frame = np.where(np.arange(81).reshape(9, 9) == place, FULL, 0)
        tau = int(texturization(frame, patches))
        frames += [frame, frame]
        t2 += [tau, tau + 1]
    check(patches, frames, t2)


@both
@pytest.mark.parametrize("pixel_bits", [8, 10])
def test_extremes(patches: Patches, pixel_bits: int) -> None:
    """Up to the largest tau there is, which horizontal stripes have."""
    parameters = Build.profile("paper", patches=patches, pixel_bits=pixel_bits)
    frames = [frame for frame in extremes((11, 18), parameters.response_max) for _ in range(4)]
    largest = parameters.texture_max
    assert max(int(texturization(windows(frame), patches).max()) for frame in frames) == largest
    # even more than any tau, as sigma2 of 16 makes it
    beyond = 16 * parameters.pixels_per_region * parameters.response_max - 1
    t2 = [(largest, largest + 1, between(frame, patches), beyond)[k % 4] for k, frame in enumerate(frames)]
    check(patches, frames, t2, pixel_bits=pixel_bits)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """A response of 7 in the middle counts four times with regions: 28, which is not below 28."""
    frame = np.zeros((9, 9), np.int64)
    frame[4, 4] = 7
    capture = check("regions", [frame] * 4, [28, 28, 29, 29], name)
    textured, keep = capture.outputs["o"] & np.uint64(1), capture.outputs["o"] >> np.uint64(1) & np.uint64(1)
    assert textured.tolist() == [1, 1, 0, 0]
    assert keep.tolist() == [0, 1, 1, 1]


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@both
def test_each_result_has_its_own_frames_threshold(patches: Patches, name: EngineName, stalls: Stalls) -> None:
    """Frames of one window, back to back: the next T2 must not come too soon."""
    parameters = Build.profile("paper", patches=patches)
    beyond = 16 * parameters.pixels_per_region * parameters.response_max - 1
    check(patches, noise([(9, 9)] * 12, FULL, 5), [0, beyond, beyond, 0] * 3, name, stalls)


def test_latency() -> None:
    assert TextureFilter.latency == 5
