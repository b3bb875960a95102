"""The gradient step: the point to which the gradients around a candidate are orthogonal.

At any pixel p of an edge through the corner q, the gradient g is orthogonal to q - p. The q that
fits best over a window, in the least squares sense, minimises the sum of (g·(q - p))² (Förstner and
Gülch, 1987). OpenCV's ``cornerSubPix`` repeats this step from the place found; here it is taken
once. With (u, v) the place of a pixel in the window, (dx, dy) that of q, and A = gx², B = gy², C =
gx·gy as in the structure tensor, the normal equations are

    [ΣA  ΣC] [dx]   [Σ(A·u + C·v)]
    [ΣC  ΣB] [dy] = [Σ(C·u + B·v)]

The largest response, to which the paper refines, lies a pixel or two inside an L-shaped corner; q
does not. All places of the window have the same weight: weights that decrease towards its edge were
found to be less accurate, and sums without weights cost least.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.algorithm import FIT_REACH
from golden.derivatives import Derivatives
from golden.parameters import Parameters
from golden.preprocessing import Image, gradients

Int64 = NDArray[np.int64]

PIXEL_SIZE = 2 * FIT_REACH["gradient"] + 1
"""Side of the window of pixels that the gradients need."""
STEP_SIZE = PIXEL_SIZE - 2
"""Side of the window of gradients, 7."""
PLACES = np.arange(STEP_SIZE, dtype=np.int64) - STEP_SIZE // 2
"""u and v, -3 to 3."""
LARGEST = 2 * STEP_SIZE * int(np.abs(PLACES).sum())
"""None of the five sums exceeds this many full products: Σ(|u| + |v|)."""


def normal_equations(pixels: Image) -> Derivatives[Int64]:
    """The five sums for (..., 9, 9) windows of pixels around candidates.

    C has its sign here, whatever ``Algorithm.gradient`` is.
    """
    gx, gy = (g.astype(np.int64) for g in gradients(pixels))
    a, b, c = gx * gx, gy * gy, gx * gy
    u, v = PLACES[None, :], PLACES[:, None]

    def total(values: Int64) -> Int64:
        return values.sum(axis=(-2, -1))

    return Derivatives(xx=total(a), yy=total(b), xy=-total(c), x=total(a * u + c * v), y=total(c * u + b * v))


def largest(parameters: Parameters) -> int:
    """Bound of the sizes of the five sums."""
    return LARGEST * parameters.product_max
