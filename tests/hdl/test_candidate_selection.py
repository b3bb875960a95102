# amaranth: UnusedElaboratable=no
"""Candidate selection: who is reported, where it lies, and how each frame is closed."""

from __future__ import annotations

import numpy as np
import pytest

from golden.parameters import MARGIN, Parameters
from hdl.candidate_selection import CandidateSelection, note_layout
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls, Stimulus
from tests.hdl.blocks import NO_STALLS, RUN_IDS, RUNS, Array, Size, engine, pack, same, tags, unpack

PARAMETERS = Parameters()
FULL = PARAMETERS.response_max


def check(
    sizes: list[Size],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    chances: tuple[float, float, float] = (0.2, 0.4, 0.7),
) -> Capture:
    """Frames of so many window centres, random ones of them corners, textured, and kept."""
    rng = np.random.default_rng(len(sizes))
    tagged = tags(sizes)
    total = len(tagged["eol"])
    corner, textured, keep = (rng.random(total) < chance for chance in chances)
    patches = rng.integers(0, FULL, (total, 3, 3), endpoint=True)
    block = CandidateSelection(PARAMETERS)
    beats = {
        "corners": pack(
            block.corners.payload.shape(), {"data": {"corner": corner, "patch": patches}, **tagged}
        ),
        "textures": pack(
            block.textures.payload.shape(), {"data": {"textured": textured, "keep": keep}, **tagged}
        ),
    }
    quiet = 20 * int(1 / ((1 - stalls.inputs) * (1 - stalls.outputs))) + 200
    capture = engine(name, CandidateSelection, PARAMETERS).run(Stimulus(beats, [], stalls), quiet=quiet)
    notes = unpack(note_layout(PARAMETERS), capture.outputs["note"])
    is_corner = notes["end"] == 0

    # each candidate's note and patch, and between them the frames' ends
    chosen = np.flatnonzero(corner & keep)
    x = np.concatenate([np.tile(np.arange(width), height) for height, width in sizes]) + MARGIN
    y = np.concatenate([np.repeat(np.arange(height), width) for height, width in sizes]) + MARGIN
    expected = {"x": x, "y": y, "response": patches[:, 1, 1], "textured": textured, "end": 0 * x}
    expected = {field: values[chosen] for field, values in expected.items()}
    same(
        "note",
        pack(note_layout(PARAMETERS), {field: values[is_corner] for field, values in notes.items()}),
        pack(note_layout(PARAMETERS), expected),
    )
    same(
        "patch",
        capture.outputs["patch"][is_corner],
        pack(block.patch.payload.shape(), patches[chosen]),
    )
    frame_ends = np.flatnonzero(tagged["eof"])
    before = np.searchsorted(chosen, frame_ends, side="right")
    assert np.array_equal(np.flatnonzero(~is_corner), before + np.arange(len(sizes)))
    if stalls == NO_STALLS:
        check_clocks(capture, chosen, frame_ends, is_corner)
    return capture


def check_clocks(capture: Capture, chosen: Array, frame_ends: Array, is_corner: Array) -> None:
    accepted = capture.input_clocks["corners"]
    latency = CandidateSelection.latency
    for stream in ("note", "patch"):
        clocks = capture.output_clocks[stream]
        assert np.array_equal(clocks[is_corner], accepted[chosen] + latency)
        expected_ends = accepted[frame_ends] + latency + CandidateSelection.END_DELAY
        assert np.array_equal(clocks[~is_corner], expected_ends)
    # full rate, but for the frame's end: the first eight columns of the next frame make no window anyway
    waits = np.diff(accepted) - 1
    assert (waits[frame_ends[:-1]] == CandidateSelection.END_DELAY).all()
    assert waits.sum() == CandidateSelection.END_DELAY * (len(frame_ends) - 1)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_frames(name: EngineName, stalls: Stalls) -> None:
    sizes = [(20, 31), (1, 1), (1, 9), (9, 1), (1, 1), (14, 14)]
    check(sizes if name == "compiled" else [(3, 5), (1, 1), (1, 4), (4, 1)], name, stalls)


@pytest.mark.parametrize(
    "chances", [(0, 0.5, 0.5), (1, 0.5, 0), (1, 0.5, 1), (1, 1, 1), (1, 0, 0.5)], ids=str
)
def test_none_and_all(chances: tuple[float, float, float]) -> None:
    check([(5, 7), (1, 1), (2, 2)], chances=chances)


def test_places_to_the_built_maximum() -> None:
    """The last centre of the largest frame there is in x, and in y."""
    capture = check([(2, 8192 - 2 * MARGIN), (8192 - 2 * MARGIN, 2), (1, 3)], chances=(1, 0.5, 1))
    notes = unpack(note_layout(PARAMETERS), capture.outputs["note"])
    corners = notes["end"] == 0
    assert notes["x"][corners].max() == notes["y"][corners].max() == 8191 - MARGIN
    assert notes["x"][corners].min() == notes["y"][corners].min() == MARGIN


def test_latency() -> None:
    assert (CandidateSelection.latency, CandidateSelection.END_DELAY) == (1, 2)
