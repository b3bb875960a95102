"""Twice the smaller eigenvalue of the tensor (Eq. 2)."""

from __future__ import annotations

import numpy as np

from golden.algorithm import Algorithm
from golden.responses import Tensor
from golden.square_root import floor_sqrt


def response(a: Tensor, b: Tensor, c: Tensor, pixel_bits: int) -> Tensor:
    """D = (A + B) - isqrt((A - B)² + (2C)²), at least 0.

    Without the clamp at 0, D would be -1 where rounding A, B and C makes the root one too large.
    The radicand fits in 2·root_bits: C² <= AB holds before rounding, so the root stays below A + B
    + 2.
    """
    difference = (a - b).astype(np.float64)
    twice_c = (c + c).astype(np.float64)
    root = floor_sqrt(difference * difference + twice_c * twice_c)
    return np.maximum(a + b - root, 0)


def response_max(pixel_bits: int, algorithm: Algorithm) -> int:
    """D is at most 2·uᵀTu for any unit vector u and the tensor T.

    With u along an axis, this bound is 2A or 2B. With u = (1, -1)/√2, it is A + B - 2C. Where
    gradients are absolute, that is the mean of (|gx| - |gy|)², which is no more than one full
    product; rounding A, B and C adds less than 2.
    """
    product_max = ((1 << pixel_bits) - 1) ** 2
    return product_max + 1 if algorithm.gradient == "absolute" else 2 * product_max


def exact(a: Tensor, b: Tensor, c: Tensor, pixel_bits: int) -> Tensor:
    """D = (A + B) - sqrt((A - B)² + 4C²)."""
    return (a + b) - np.sqrt((a - b) ** 2 + 4 * c**2)
