"""Serial divider: quotients up to a limit, rounded to 1/128.

The bits of the quotient are found one after the other, each by one subtraction, as in the square
root. This takes no memory and is exact. ``golden.table_divider`` is the paper's way (Sec. 4.4).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.formats import OFFSET_BITS

HALF = 1 << (OFFSET_BITS - 1)
"""One half in units of 1/128: the largest offset of a surface's peak."""

Int64 = NDArray[np.int64]


def quotient_bits(limit: int) -> int:
    """Number of bits that are found for quotients up to ``limit``, a power of two.

    It is one more than the result has, for rounding.
    """
    return limit.bit_length() + 1


QUOTIENT_BITS = quotient_bits(HALF)


def divide(numerator: Int64, denominator: Int64, limit: int = HALF) -> Int64:
    """numerator / denominator in units of 1/128, rounded to nearest, halves away from zero.

    Parameters
    ----------
    numerator
        Any sign; ``|numerator| < 2**54``.
    denominator
        Positive.
    limit
        Largest size of the result, in units of 1/128, a power of two; larger results are clamped.
    """
    magnitude = np.abs(numerator)
    halves = np.where(
        reaches(numerator, denominator, limit), 2 * limit, (magnitude << (OFFSET_BITS + 1)) // denominator
    )
    return np.sign(numerator) * ((halves + 1) >> 1)


def reaches(numerator: Int64, denominator: Int64, limit: int) -> NDArray[np.bool_]:
    """Is the size of the quotient ``limit`` or more?"""
    places = limit.bit_length() - HALF.bit_length()
    return np.abs(numerator) << 1 >= denominator << places
