"""Corner detection (Eqs. 3-5): non-maximum suppression and threshold."""

from __future__ import annotations

from collections.abc import Iterable
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from golden.algorithm import Ties
from golden.preprocessing import IntArray


def corner_detection(response: IntArray, t1: int, ties: Ties, radius: int = 1) -> NDArray[np.bool_]:
    """E(x, y): D > T1 and D > gamma, the largest neighbour in the (2r+1)x(2r+1) square around it.

    With r = 1 there are eight neighbours, as in Eqs. 3 and 4. Eq. 5 prints ``sigma1 > D``, but
    small responses shall be removed, so it is read as D > T1. With ``ties="first"``, neighbours
    that are later in raster order may be equal.

    (height, width) responses in, (height-2r, width-2r) out: the outermost ones lack neighbours.
    """
    height, width = (side - 2 * radius for side in response.shape)
    before, after, across = range(radius), range(radius + 1, 2 * radius + 1), range(2 * radius + 1)
    above = _largest(response[k : k + height] for k in before)
    here = response[radius : radius + height]
    below = _largest(response[k : k + height] for k in after)
    centre = here[:, radius : radius + width]
    earlier = _largest(
        [*(above[:, k : k + width] for k in across), *(here[:, k : k + width] for k in before)]
    )
    later = _largest([*(below[:, k : k + width] for k in across), *(here[:, k : k + width] for k in after)])
    beats_later = centre > later if ties == "strict" else centre >= later
    return (centre > earlier) & beats_later & (centre > t1)


def _largest(values: Iterable[IntArray]) -> IntArray:
    return reduce(np.maximum, values)
