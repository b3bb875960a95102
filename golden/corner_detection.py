"""Corner detection (Eqs. 3-5): non-maximum suppression and threshold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.parameters import Ties
from golden.preprocessing import IntArray


def corner_detection(response: IntArray, t1: int, ties: Ties) -> NDArray[np.bool_]:
    """E(x, y): D > T1 and D > gamma, the largest of its 8 neighbours.

    Eq. 5 prints ``sigma1 > D``; small responses are to be thresholded away, so it is read as D > T1.
    With ``ties="first"`` neighbours later in raster order may be equal.

    Takes (height, width), returns (height-2, width-2): the outermost responses lack neighbours.
    """
    above, here, below = response[:-2], response[1:-1], response[2:]
    centre = here[:, 1:-1]
    if ties == "strict":
        column = np.maximum(np.maximum(above, below), here)
        gamma = np.maximum(column[:, :-2], column[:, 2:])
        gamma = np.maximum(gamma, np.maximum(above, below)[:, 1:-1])
        return (centre > gamma) & (centre > t1)
    earlier = np.maximum(np.maximum(above[:, :-2], above[:, 1:-1]), np.maximum(above[:, 2:], here[:, :-2]))
    later = np.maximum(np.maximum(below[:, :-2], below[:, 1:-1]), np.maximum(below[:, 2:], here[:, 2:]))
    return (centre > earlier) & (centre >= later) & (centre > t1)
