# amaranth: UnusedElaboratable=no
"""Beats of peaks become candidates one by one, with their places, however full the queue is."""

from __future__ import annotations

import numpy as np
import pytest

from hdl.build import Build
from hdl.candidate_queue import CandidateQueue
from hdl.step_layouts import reads_pixels
from sim.stimulus import Stalls, Stimulus
from tests.support.blocks import NO_STALLS, Array, engine, pack, tags, unpack

STALLS = {"unstalled": NO_STALLS, "both-stall": Stalls(0.3, 0.4, 13), "clogged": Stalls(0, 0.8, 15)}
BUILDS = {
    "paper": Build.profile("paper"),
    "rows noted": Build.profile("robust", video_out=True),
    "gradient steps": Build.profile("precise"),
}
Candidates = list[tuple[int, int, int, int, int]]


def peaks_of(rows: int, width: int, margin: int, seed: int) -> Array:
    """By rows of windows and their newest columns: no two neighbours, some rows without any."""
    found = np.random.default_rng(seed).random((rows, width)) < 0.4
    found[:, : 2 * margin] = found[1::3] = False
    found[:, 1:] &= ~found[:, :-1]
    return found


def candidates_of(peaks: Array, build: Build, before: int) -> tuple[Candidates, int]:
    """Newest column in the ring, x, y, note and end of each; beats written so far, and then."""
    lanes, margin = build.pixels_per_clock, build.algorithm.margin
    first = 2 * build.algorithm.response_margin // lanes
    found: Candidates = []
    for row, columns in enumerate(peaks):
        y, last = row + margin, row == len(peaks) - 1
        offset = (before - first) * lanes
        found += [(offset + int(x), int(x) - margin, y, 0, 0) for x in np.flatnonzero(columns)]
        before += -(-len(columns) // lanes) - first
        if last or build.video_out or reads_pixels(build):
            # the place of a note in its row means nothing
            found.append((0, 0, y, 1, int(last)))
    return found, before


@pytest.mark.parametrize("stalls", STALLS.values(), ids=STALLS)
@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("kind", BUILDS)
def test_places(kind: str, lanes: int, stalls: Stalls) -> None:
    """Frames back to back that end in every lane."""
    build = BUILDS[kind].changed(pixels_per_clock=lanes)
    margin, first = build.algorithm.margin, 2 * build.algorithm.response_margin // lanes
    widths = [*range(build.min_width, build.min_width + lanes), 90, 120]
    masks, rows, before = [], [], 0
    expected: Candidates = []
    for seed, width in enumerate(widths):
        peaks = peaks_of(7 + seed % 3, width, margin, seed)
        found, before = candidates_of(peaks, build, before)
        expected += found
        beats = np.pad(peaks, ((0, 0), (0, -width % lanes))).reshape(len(peaks), -1, lanes)[:, first:]
        rows.append(beats.shape[:2])
        masks.append(beats.reshape(-1, lanes) @ (1 << np.arange(lanes)))

    block = CandidateQueue(build)
    given = pack(block.i.payload.shape(), {"mask": np.concatenate(masks), **tags(rows)})
    capture = engine("amaranth", CandidateQueue, build).run(Stimulus({"i": given}, [], stalls), quiet=100)
    requests = unpack(block.o.payload.shape(), capture.outputs["o"])
    places = requests["place"]
    is_candidate = places["note"] == 0
    column = np.where(is_candidate, requests["column"], 0)
    x = np.where(is_candidate, places["x"], 0)
    got = np.stack([column, x, places["y"], places["note"], places["end"]], axis=1)
    wanted = np.array(expected)
    beat = wanted[:, 0] // lanes
    wanted[:, 0] %= build.ring_beats * lanes
    assert got.tolist() == wanted.tolist()
    assert is_candidate.sum() > 3 * block.beats
    if stalls == NO_STALLS:
        check_rate(beat, is_candidate, capture.input_clocks["i"][beat], capture.output_clocks["o"])


def check_rate(beat: Array, is_candidate: Array, came: Array, left: Array) -> None:
    """Where none has to be waited for: a clock for each candidate, and two more for each beat."""
    both = is_candidate[1:] & is_candidate[:-1]
    same, waited = both & (np.diff(beat) == 0), both & (came[1:] + 7 < left[:-1])
    steps = np.diff(left)
    assert (steps[same] == 1).all()
    assert (waited & ~same).any() and (steps[waited & ~same] == 3).all()
