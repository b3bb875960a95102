"""Divider (Sec. 4.4): quotients of at most one half, rounded to 1/128.

The paper looks reciprocals up in a table. Here the quotient's bits are found one after the other, each by one
subtraction, as in the square root: with a few clocks for each corner that takes fewer cells than the table's
multiplier, no memory, and is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.parameters import OFFSET_BITS

QUOTIENT_BITS = OFFSET_BITS + 1
"""Bits found: one more than the result has, to round by."""

HALF = 1 << (OFFSET_BITS - 1)
"""One half, the largest quotient, in units of 1/128."""

Int64 = NDArray[np.int64]


def divide(numerator: Int64, denominator: Int64) -> Int64:
    """numerator / denominator in units of 1/128, rounded to nearest, halves away from zero; at most one half.

    numerator of either sign, ``|numerator| < 2**54``; denominator positive.
    """
    magnitude = np.abs(numerator)
    quotient = np.where(2 * magnitude >= denominator, 2 * HALF, (magnitude << QUOTIENT_BITS) // denominator)
    return np.sign(numerator) * ((quotient + 1) >> 1)
