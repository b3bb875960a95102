"""Non-textured corner filter (Eqs. 6-9): it rejects corners inside complex texture."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from golden.algorithm import Patches
from golden.formats import WINDOW_SIZE
from golden.preprocessing import IntArray

_CENTRE = WINDOW_SIZE // 2


def patch(windows: IntArray, k: int, patches: Patches) -> IntArray:
    """The four regions of patch k = 1, 2, 3 of Fig. 5, as (..., 4, side, side).

    ``"regions"``: the 3x3 regions at the corners of the (2k+3)x(2k+3) square; their centres are k
    pixels away along each diagonal. ``"pixels"``: these centres only. This is an assumption, since
    the figure itself is not public.
    """
    reach = 1 if patches == "regions" else 0
    regions = []
    for down, right in product((-1, 1), repeat=2):
        y, x = _CENTRE + k * down, _CENTRE + k * right
        regions.append(windows[..., y - reach : y + reach + 1, x - reach : x + reach + 1])
    return np.stack(regions, axis=-3)


def texturization(windows: IntArray, patches: Patches) -> IntArray:
    """tau = tau12 + tau23 of (..., 9, 9) response windows: shape (...).

    tau_ab is the sum of |patch a - patch b| over the four regions, pixel by pixel. The mean over
    the pixels of a region would need a division by 9; instead, tau and T2 stay multiplied by
    ``Parameters.pixels_per_region``.
    """
    first, second, third = (patch(windows, k, patches) for k in (1, 2, 3))
    tau12 = np.abs(first - second).sum(axis=(-3, -2, -1))
    tau23 = np.abs(second - third).sum(axis=(-3, -2, -1))
    return tau12 + tau23


def texture_filter(windows: IntArray, t2: int, patches: Patches) -> NDArray[np.bool_]:
    """F = tau < T2 (Eq. 9) of (..., 9, 9) response windows: true where the corner is accepted."""
    return texturization(windows, patches) < t2
