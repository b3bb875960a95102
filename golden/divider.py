"""Divider (Sec. 4.4): quotients up to a limit, rounded to 1/128.

The paper looks reciprocals up in a table. Here the quotient's bits are found one after the other,
each by one subtraction, as in the square root: with a few clocks for each corner that takes fewer
cells than the table's multiplier, no memory, and is exact.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.formats import OFFSET_BITS

HALF = 1 << (OFFSET_BITS - 1)
"""One half in units of 1/128: the largest quotient of a surface's peak."""

Int64 = NDArray[np.int64]


def quotient_bits(limit: int) -> int:
    """Bits found for quotients up to ``limit``, a power of two: one more than the result has, to
    round by.
    """
    return limit.bit_length() + 1


QUOTIENT_BITS = quotient_bits(HALF)


def divide(numerator: Int64, denominator: Int64, limit: int = HALF) -> Int64:
    """numerator / denominator in units of 1/128, rounded to nearest, halves away from zero; at most
    ``limit``.

    numerator of either sign, ``|numerator| < 2**54``; denominator positive; limit a power of two of
    1/128.
    """
    magnitude = np.abs(numerator)
    halves = np.where(
        reaches(numerator, denominator, limit), 2 * limit, (magnitude << (OFFSET_BITS + 1)) // denominator
    )
    return np.sign(numerator) * ((halves + 1) >> 1)


def reaches(numerator: Int64, denominator: Int64, limit: int) -> NDArray[np.bool_]:
    """Is the quotient's size ``limit`` or more?"""
    places = limit.bit_length() - HALF.bit_length()
    return np.abs(numerator) << 1 >= denominator << places
