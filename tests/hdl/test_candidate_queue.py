# amaranth: UnusedElaboratable=no
"""Beats of peaks become candidates one by one, with their places; none is lost where it is full."""

from __future__ import annotations

import numpy as np
import pytest

from hdl.build import Build
from hdl.candidate_queue import CandidateQueue, place_layout, request_layout
from sim.stimulus import Stalls
from tests.support.blocks import NO_STALLS, Array, engine, run, same, tags, unpack
from tests.support.blocks import pack as pack_fields

STALLS = {"unstalled": NO_STALLS, "both-stall": Stalls(0.3, 0.4, 13), "clogged": Stalls(0, 0.9, 15)}
BUILDS = {
    "paper": Build.profile("paper"),
    "rows noted": Build.profile("robust", video_out=True),
}


def masks_of(height: int, width: int, build: Build, seed: int) -> Array:
    """Rows of windows of a frame, (rows, columns): peaks, of which no two are neighbours."""
    margin = build.algorithm.margin
    found = np.random.default_rng(seed).random((height - 2 * margin, width)) < 0.4
    found[:, : 2 * margin] = False
    found[:, 1:] &= ~found[:, :-1]
    return found


@pytest.mark.parametrize("stalls", STALLS.values(), ids=STALLS)
@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("kind", BUILDS)
def test_places(kind: str, lanes: int, stalls: Stalls) -> None:
    """Frames back to back that end in every lane; peaks are so dense that the queue is full."""
    build = BUILDS[kind].changed(pixels_per_clock=lanes)
    margin, first = build.algorithm.margin, 2 * build.algorithm.response_margin // lanes
    sizes = [(2 * margin + 3, build.min_width + k) for k in range(lanes)] + [(2 * margin + 2, 90)]
    masks: list[Array] = []
    expected: dict[str, list[int]] = {name: [] for name in ("x", "y", "note", "end", "beat", "lane")}
    rows, written = [], 0
    for seed, (height, width) in enumerate(sizes):
        found = masks_of(height, width, build, seed)
        padded = np.pad(found, ((0, 0), (0, -width % lanes)))[:, first * lanes :]
        by_beat = padded.reshape(len(padded), -1, lanes)
        rows.append(by_beat.shape[:2])
        masks.append(by_beat.reshape(-1, lanes) @ (1 << np.arange(lanes)))
        for row, columns in enumerate(found):
            last = row == len(found) - 1
            # newest columns of windows, whose centres are to the left of them
            for column in np.flatnonzero(columns):
                place = written + column // lanes - first
                lane = column % lanes
                add(expected, x=column - margin, y=row + margin, note=0, end=0, beat=place, lane=lane)
            written += by_beat.shape[1]
            if last or build.video_out:
                add(expected, x=0, y=row + margin, note=1, end=int(last), beat=written - 1, lane=0)
    block = CandidateQueue(build)
    given = pack_fields(block.i.payload.shape(), {"mask": np.concatenate(masks), **tags(rows)})
    runner = engine("amaranth", CandidateQueue, build)
    capture = run_all(runner, given, stalls)
    found_places = unpack(request_layout(build), capture)
    places = found_places["place"]
    ring_bits = request_layout(build)["column"].width - (lanes - 1).bit_length()
    note = np.array(expected["note"])
    for name in ("y", "note", "end"):
        assert places[name].tolist() == expected[name], name
    column = (np.array(expected["beat"]) % (1 << ring_bits)) * lanes + np.array(expected["lane"])
    assert np.where(note, 0, places["x"]).tolist() == expected["x"]
    assert np.array_equal(found_places["column"][note == 0], column[note == 0])
    # those of a note are of the same beat
    assert np.array_equal(found_places["column"][note == 1] // lanes, column[note == 1] // lanes)
