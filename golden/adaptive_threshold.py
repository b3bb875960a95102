"""Adaptive threshold, in place of the paper's texture filter: T1 rises with the local level of D.

In foliage or gravel every pixel has a response, and which of the many peaks are above T1 changes
from view to view. So a corner must stand out from what is around it: its response S less a part of
the mean D there must be above T1,

    T = S - sigma2 · L > T1        L = (sum of D over the 9x9 window) / 64

that is S > T1 + sigma2 · L, as thresholds by local means have it in document scanning. L is 81/64
of the mean: powers of two cost nothing to divide by. sigma2 counts in eighths.

T is also the response that is reported: so the corners with the largest responses are those that a
higher T1 leaves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.formats import MEAN_WEIGHT_FRACTION_BITS, WINDOW_SIZE
from golden.preprocessing import IntArray

LEVEL_SHIFT = 6
LEVEL_GAIN = WINDOW_SIZE**2 / (1 << LEVEL_SHIFT)
"""The local level is so many times the mean."""


def local_level(windows: IntArray) -> IntArray:
    """L of (..., 9, 9) windows of D, rounded down; returns (...)."""
    total: IntArray = windows.sum(axis=(-2, -1), dtype=np.int64) >> LEVEL_SHIFT
    return total


def prominence(peaks: IntArray, windows: IntArray, weight: int) -> IntArray:
    """T of peaks (...) and the (..., 9, 9) windows of D around them; weight is
    ``Settings.mean_weight``.
    """
    return peaks - ((weight * local_level(windows)) >> MEAN_WEIGHT_FRACTION_BITS)


def adaptive_threshold(
    peaks: IntArray, windows: IntArray, t1: int, weight: int
) -> tuple[NDArray[np.bool_], IntArray]:
    """F = T > T1, true where the corner stands out, and the response to report: T, or 0 where that
    is negative.
    """
    standing_out = prominence(peaks, windows, weight)
    return standing_out > t1, np.maximum(standing_out, 0)
