"""Convolution unit (Eq. 1): the 5x5 smoothing kernel, separable, with one rounding at the end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.preprocessing import IntArray

TAPS = (1, 2, 2, 2, 1)
"""One dimension of the kernel. Eq. 1 is outer(TAPS, TAPS) / 64. Its single 19/512 is read as
16/512, which makes the kernel symmetric and its sum exactly 1.
"""
SHIFT = 6
"""The two-dimensional kernel is scaled by 64."""

KERNEL: NDArray[np.int64] = np.outer(TAPS, TAPS)


def _taps_along_rows(image: IntArray) -> IntArray:
    # [1 2 2 2 1] = [1 1] * [1 1] * [1 0 1]: three additions, no multiplication, as in hardware
    pairs = image[:-1] + image[1:]
    pairs = pairs[:-1] + pairs[1:]
    return pairs[:-2] + pairs[2:]


def smooth(image: IntArray) -> IntArray:
    """Convolve an int32 (height, width) array with Eq. 1; returns (height-4, width-4) int32.

    The full-precision sum s is rounded once, half away from zero: (s + 31 + (s >= 0)) >> 6.
    """
    total = _taps_along_rows(_taps_along_rows(image).T).T
    if total.size and total.min() < 0:
        return (total + 31 + (total >= 0)) >> SHIFT
    return (total + 32) >> SHIFT
