"""Shi-Tomasi corner response (Eq. 2)."""

from __future__ import annotations

import numpy as np

from golden.preprocessing import IntArray
from golden.square_root import floor_sqrt


def response(a: IntArray, b: IntArray, c: IntArray) -> IntArray:
    """D = (A + B) - isqrt((A - B)² + (2C)²), at least 0: twice the tensor's smaller eigenvalue.

    Without the clamp at 0, D would be -1 where rounding A, B and C makes the root one too large.
    The radicand fits in 2·root_bits: C² <= AB holds before rounding, so the root stays below A + B
    + 2.
    """
    difference = (a - b).astype(np.float64)
    twice_c = (c + c).astype(np.float64)
    root = floor_sqrt(difference * difference + twice_c * twice_c)
    return np.maximum(a + b - root, 0)
