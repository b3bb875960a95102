"""Adaptive threshold, in place of the paper's texture filter: T1 rises with the local level of D.

In foliage or gravel every pixel has a response, and which of the many peaks are above T1 changes
from view to view. So a corner must stand out from its surroundings: its response S, less a part of
the mean of D around it, must be above T1,

    T = S - sigma2 · L > T1        L = (sum of D over the 9x9 window) / 64

which is S > T1 + sigma2 · L, as in thresholds by local means, known from document scanning. L is
81/64 of the mean, because the division by a power of two costs nothing. sigma2 is a number of
eighths.

T is also the response that is reported: the corners with the largest reported responses are those
that remain with a higher T1.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.formats import MEAN_WEIGHT_FRACTION_BITS, WINDOW_SIZE
from golden.preprocessing import IntArray

LEVEL_SHIFT = 6
LEVEL_GAIN = WINDOW_SIZE**2 / (1 << LEVEL_SHIFT)
"""The local level divided by the mean."""


def local_level(windows: IntArray) -> IntArray:
    """L of (..., 9, 9) windows of D, rounded down: shape (...)."""
    total: IntArray = windows.sum(axis=(-2, -1), dtype=np.int64) >> LEVEL_SHIFT
    return total


def prominence(peaks: IntArray, windows: IntArray, weight: int) -> IntArray:
    """T of peaks (...) in (..., 9, 9) windows of D; ``weight`` is ``Settings.mean_weight``."""
    return peaks - ((weight * local_level(windows)) >> MEAN_WEIGHT_FRACTION_BITS)


def adaptive_threshold(
    peaks: IntArray, windows: IntArray, t1: int, weight: int
) -> tuple[NDArray[np.bool_], IntArray]:
    """F = T > T1, true where the corner is accepted, and the reported response max(T, 0)."""
    standing_out = prominence(peaks, windows, weight)
    return standing_out > t1, np.maximum(standing_out, 0)
