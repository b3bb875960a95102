"""Integer square root: Li and Chu's non-restoring algorithm, and a fast equivalent."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def li_chu(radicand: NDArray[np.int64], result_bits: int) -> NDArray[np.int64]:
    """Floor square root of ``radicand`` < 4**result_bits, bit by bit as the hardware finds it.

    Each step takes two bits d of the radicand, and adds or subtracts once (Li and Chu 1996):

        r >= 0:  r' = (4r + d) - (4q + 1)
        r <  0:  r' = (4r + d) + (4q + 3)
        q' = 2q + (r' >= 0)
    """
    radicand = np.asarray(radicand, dtype=np.int64)
    root = np.zeros_like(radicand)
    remainder = np.zeros_like(radicand)
    for step in reversed(range(result_bits)):
        shifted = 4 * remainder + ((radicand >> (2 * step)) & 3)
        remainder = np.where(remainder >= 0, shifted - (4 * root + 1), shifted + (4 * root + 3))
        root = 2 * root + (remainder >= 0)
    return root


def floor_sqrt(radicand: NDArray[np.float64]) -> NDArray[np.int32]:
    """Floor square root of whole numbers below 2**46, which float64 holds exactly.

    IEEE 754 rounds the root correctly. The root closest to an integer k from below is sqrt(k² - 1)
    = k - 1/(2k), and 1/(2k) >= 2**-24 is far more than half a unit in the last place of k <= 2**23,
    so truncation gives the floor.
    """
    return np.sqrt(radicand).astype(np.int32)
