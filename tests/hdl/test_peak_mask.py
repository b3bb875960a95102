# amaranth: UnusedElaboratable=no
"""Peaks by lanes: the mask of every beat, against the golden model."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from golden.corner_detection import corner_detection
from hdl.build import Build
from hdl.peak_mask import PeakMask
from sim.stimulus import Stalls
from tests.support.beats import in_beats
from tests.support.blocks import NO_STALLS, Array, check_block, noise, tags

BUILDS = {
    "strict": Build.profile("paper"),
    "first": Build.profile("robust", response_filter="none", texture="none"),
    "first, textures": Build.profile("robust", response_filter="none", texture="patches"),
    "suppression 2": Build.profile("robust", texture="none", response_filter="none", suppression=2),
    "suppression 4": Build.profile("paper", texture="none", suppression=4, ties="first", budget=True),
}
# most peaks are larger, and some are equal
T1 = {"strict": 21, "first": 21, "first, textures": 21, "suppression 2": 28, "suppression 4": 27}


def peaks_of(frame: Array, build: Build, t1: int) -> Array:
    """For each window's newest response, is its centre a peak: (rows of columns, width)."""
    algorithm = build.algorithm
    r, middle = algorithm.suppression, algorithm.window_size // 2
    found = corner_detection(frame, -1 if build.budget else t1, algorithm.ties, r)
    late = np.zeros((found.shape[0], frame.shape[1]), bool)
    window = 2 * middle
    late[:, window:] = found[:, middle - r : found.shape[1] - (middle - r)]
    return late


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.3, 0.4, 13)], ids=["unstalled", "both-stall"])
@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("kind", BUILDS)
def test_noise(kind: str, lanes: int, stalls: Stalls) -> None:
    """Few values, so that neighbours are often equal; lanes that do not count are larger.

    Rows end with every number of lanes; windows are complete first in any lane.
    """
    build = BUILDS[kind].changed(pixels_per_clock=lanes)
    lost, margin, rows = 2 * build.algorithm.response_margin, build.algorithm.margin, PeakMask(build).rows
    narrow = max(2 * margin + 1, build.min_width)
    sizes = [(rows + 5, narrow - lost), *((rows + 9, narrow + 20 + k - lost) for k in range(lanes))]
    t1 = T1[kind]
    frames = noise(sizes, 30, seed=lanes)
    beats, _ = in_beats(frames, lanes, lost=lost, largest=63)
    masks, lower = (
        in_beats([peaks_of(frame, build, limit) for frame in frames], lanes, lost=lost, largest=0)[0]
        for limit in (t1, t1 - 1)
    )
    above, all_of_lower = (sum(int(mask.sum()) for mask in each) for each in (masks, lower))
    assert above and (all_of_lower > above or build.budget or lanes == 2)

    columns = [np.moveaxis(sliding_window_view(frame, rows, axis=0), -1, 2) for frame in beats]
    ends = tags([frame.shape[:2] for frame in columns])
    starts = np.cumsum([0, *(frame.shape[0] * frame.shape[1] for frame in columns)])
    levels = [
        (int(start), {"last_lanes": (size[1] + lost) % lanes, "t1": t1, "permit": 1})
        for start, size in zip(starts, sizes, strict=False)
    ]
    given = np.concatenate([frame.reshape(-1, rows, lanes) for frame in columns])
    expected = np.concatenate([mask.reshape(-1, lanes) for mask in masks]) @ (1 << np.arange(lanes))
    check_block(
        (PeakMask, build),
        {"i": {"data": {"response": given}, **ends}},
        {"o": {"mask": expected, **ends}},
        "amaranth",
        stalls,
        levels=levels,
    )
