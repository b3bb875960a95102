"""Frames as beats of several columns, for tests of blocks with several pixels per clock."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.support.blocks import Array

LANES = (1, 2, 4, 8)
LANES_IN_TURN = [lanes if lanes < 4 else pytest.param(lanes, marks=pytest.mark.verify) for lanes in LANES]
"""For blocks whose simulators take long to build where beats are wide."""


def in_beats(
    frames: Sequence[Array], lanes: int, *, lost: int = 0, largest: int = 255, seed: int = 7
) -> tuple[list[Array], list[Array]]:
    """Frames in beats, and which of their values count.

    Parameters
    ----------
    frames
        Arrays of (height, width, ...).
    lanes
        Columns of a beat.
    lost
        Columns of a row that completed nothing before: they are no columns of the frames.
    largest
        Values that do not count are noise from 0 to this.

    Returns
    -------
    For each frame an array of (height, beats, lanes, ...), or without the axis of lanes where a
    beat is one column; and the same of bool.
    """
    rng = np.random.default_rng(seed)
    beats, counting = [], []
    for frame in frames:
        height, width, *more = frame.shape
        left = lost % lanes
        right = -(left + width) % lanes
        noise = rng.integers(0, largest, (height, left + width + right, *more), endpoint=True)
        counts = np.zeros(noise.shape, bool)
        noise[:, left : left + width], counts[:, left : left + width] = frame, True
        shape = (height, noise.shape[1] // lanes, *([lanes] if lanes > 1 else []), *more)
        beats.append(noise.reshape(shape))
        counting.append(counts.reshape(shape))
    return beats, counting


def in_words(values: Sequence[int]) -> NDArray[np.uint64]:
    """Payloads as the engines take them: 64 bits and, where there are more, the rest."""
    wide = max(values) >> 64 > 0
    halves = [[value & (1 << 64) - 1, value >> 64][: 1 + wide] for value in values]
    return np.array(halves, np.uint64).squeeze(axis=() if wide else 1)
