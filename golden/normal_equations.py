"""The gradient step: the point to which the gradients of a window are orthogonal.

At any pixel p of an edge through the corner q, the gradient g is orthogonal to q - p. The q that
fits best over a window, in the least squares sense, minimises the sum of (g·(q - p))² (Förstner and
Gülch, 1987). With (u, v) the place of a pixel, (dx, dy) that of q, A = gx², B = gy², C = gx·gy as
in the structure tensor, and weights w, the normal equations are

    [ΣwA  ΣwC] [dx]   [Σw(A·u + C·v)]
    [ΣwC  ΣwB] [dy] = [Σw(C·u + B·v)]

The largest response, to which the paper refines, lies a pixel or two inside an L-shaped corner; q
does not. Where edges are wider than the window, a step leads to a place between q and the window's
centre: the window must be centred on the best place known, not on the nearest whole pixel, or
corners lock to pixels. So it is a box 8 pixels wide around any sixteenth of a pixel: the nine
gradients along an axis weigh as much as the box covers of them. The gradients themselves stay where
they are. ``golden.subpixel`` takes two steps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.algorithm import FIT_REACH
from golden.derivatives import Derivatives
from golden.formats import OFFSET_BITS
from golden.parameters import Parameters
from golden.preprocessing import Image, gradients

Int64 = NDArray[np.int64]

PIXEL_SIZE = 2 * FIT_REACH["gradient"] + 1
"""Side of the square of pixels around a candidate that all its windows lie in, 15."""
STEP_SIZE = 9
"""Gradients along a window's side; the outermost two weigh less, together as much as one."""
PLACE_BITS = 4
"""Fractional bits of a window's place and of the weights."""
FARTHEST = 39
"""Largest place of a window along an axis, in 1/16 pixel: others would need further pixels."""

_ONE, _HALF = 1 << PLACE_BITS, 1 << (PLACE_BITS - 1)
_REACH = STEP_SIZE // 2
_GRADIENTS = np.arange(PIXEL_SIZE - 2, dtype=np.int64) - (PIXEL_SIZE - 2) // 2
"""Places of the gradients relative to the candidate, -6 to 6."""
LARGEST = 2 * (_ONE * (STEP_SIZE - 1)) * (_ONE * (_REACH * (_REACH - 1) + _REACH))
"""None of the five sums exceeds this many full products: Σw(|u| + |v|), Σw = 128 along an axis."""


def window_place(offset: Int64) -> Int64:
    """Place of the window along an axis, in 1/16 pixel, for a corner at this offset in 1/128.

    It is rounded to nearest, halves up, and no farther than :data:`FARTHEST`.
    """
    shift = OFFSET_BITS - PLACE_BITS
    return np.clip((offset + (1 << (shift - 1))) >> shift, -FARTHEST, FARTHEST)


def centre(place: Int64) -> Int64:
    """The whole pixel, -2 to 2, in the middle of a window at this place."""
    return (place + _HALF) >> PLACE_BITS


def normal_equations(pixels: Image, x_place: Int64, y_place: Int64) -> Derivatives[Int64]:
    """The five sums over the windows of candidates, u and v counted from the windows' centres.

    They are in units of 1/256. C has its sign, whatever ``Algorithm.gradient`` is.

    Parameters
    ----------
    pixels
        (..., 15, 15) around the candidates.
    x_place, y_place
        (...) places of the windows relative to the candidates, see :func:`window_place`.
    """
    gx, gy = (g.astype(np.int64) for g in gradients(pixels))
    a, b, c = gx * gx, gy * gy, gx * gy
    across, u = _weights(x_place)
    down, v = _weights(y_place)

    def total(values: Int64, row: Int64, column: Int64) -> Int64:
        return (values * row[..., None, :] * column[..., :, None]).sum(axis=(-2, -1))

    return Derivatives(
        xx=total(a, across, down),
        yy=total(b, across, down),
        xy=-total(c, across, down),
        x=total(a, across * u, down) + total(c, across, down * v),
        y=total(c, across * u, down) + total(b, across, down * v),
    )


def _weights(place: Int64) -> tuple[Int64, Int64]:
    """Weights of the 13 gradients along an axis, and their places from the window's centre."""
    from_centre = _GRADIENTS - centre(place)[..., None]
    fraction = (place - (centre(place) << PLACE_BITS))[..., None]
    inner = np.abs(from_centre) < _REACH
    outer = [from_centre == -_REACH, from_centre == _REACH]
    weights = np.select([inner, *outer], [_ONE, _HALF - fraction, _HALF + fraction], 0)
    return weights.astype(np.int64), from_centre


def largest(parameters: Parameters) -> int:
    """Bound of the sizes of the five sums."""
    return LARGEST * parameters.product_max
