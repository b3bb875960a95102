"""LUT divider: quotients of at most one half, to 1/128, from a table of reciprocals (Sec. 4.4).

The divisor is normalised to den' in [1/2, 1), its 8 bits below the leading one look up 1/den', and one
small product gives the quotient. The dividend is shifted along and cut to NUMERATOR_BITS.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.parameters import OFFSET_BITS

INDEX_BITS = 8
"""Divisor bits below the leading one that address the table."""
NUMERATOR_BITS = 10
"""Dividend bits kept, in units of 2**-(NUMERATOR_BITS+1): normalised like the divisor it is below 1/2."""
RECIPROCAL_BITS = 10
"""Bits of a table entry, in units of 2**-(RECIPROCAL_BITS-1); the leading one is always set."""
PRODUCT_SHIFT = NUMERATOR_BITS + 1 + RECIPROCAL_BITS - 1 - OFFSET_BITS

HALF = 1 << (OFFSET_BITS - 1)
"""One half, the largest quotient, in units of 1/128."""


def _reciprocals() -> NDArray[np.int64]:
    # the middle of each interval of divisors halves the error
    middle = (2 * np.arange(1 << INDEX_BITS) + 1 + (2 << INDEX_BITS)) / (4 << INDEX_BITS)
    return np.floor((1 << (RECIPROCAL_BITS - 1)) / middle + 0.5).astype(np.int64)


RECIPROCALS: NDArray[np.int64] = _reciprocals()
"""RECIPROCALS[i] · 2**-9 is 1/den' for den' in [256+i, 257+i) / 512."""


def bit_length(values: NDArray[np.int64]) -> NDArray[np.int64]:
    """Number of bits of positive integers below 2**62."""
    # frexp rounds above 2**53, so the high half is looked at by itself
    high = values >> 31
    low_length = np.frexp(values.astype(np.float64))[1]
    return np.where(high > 0, np.frexp(high.astype(np.float64))[1] + 31, low_length).astype(np.int64)


def _top_bits(values: NDArray[np.int64], length: NDArray[np.int64], bits: int) -> NDArray[np.int64]:
    """floor(values · 2**(bits - length)): what a normalising shifter leaves."""
    up, down = np.maximum(bits - length, 0), np.maximum(length - bits, 0)
    return (values << up) >> down


def _quotient(cut: NDArray[np.int64], index: NDArray[np.int64]) -> NDArray[np.int64]:
    """The product of the cut dividend and the reciprocal, rounded to 1/128."""
    return (cut * RECIPROCALS[index] + (1 << (PRODUCT_SHIFT - 1))) >> PRODUCT_SHIFT


def divide(numerator: NDArray[np.int64], denominator: NDArray[np.int64]) -> NDArray[np.int64]:
    """|numerator| / denominator in units of 1/128, for 0 <= 2·numerator <= denominator < 2**62.

    Off by at most :func:`worst_error`, whatever the width of the operands.
    """
    length = bit_length(denominator)
    index = _top_bits(denominator, length, INDEX_BITS + 1) - (1 << INDEX_BITS)
    cut = _top_bits(numerator, length, NUMERATOR_BITS + 1)
    return _quotient(cut, index)


def worst_error() -> float:
    """Largest |divide - exact quotient|, in pixels, over all operands of all widths: a proof by exhaustion.

    The result depends only on the table index and on the cut dividend, so it is enough to compare it, for
    each pair of them, with the smallest and the largest quotient of operands that are cut to that pair.
    """
    index = np.arange(1 << INDEX_BITS)[:, None]
    cut = np.arange(1 << NUMERATOR_BITS)[None, :]
    quotient = _quotient(cut, index) / (1 << OFFSET_BITS)
    smallest_divisor = ((1 << INDEX_BITS) + index) / (2 << INDEX_BITS)
    largest_divisor = ((1 << INDEX_BITS) + index + 1) / (2 << INDEX_BITS)
    unit = 2.0 ** -(NUMERATOR_BITS + 1)
    lowest = cut * unit / largest_divisor
    highest = np.minimum((cut + 1) * unit / smallest_divisor, 0.5)
    possible = lowest <= 0.5
    error = np.maximum(np.abs(quotient - lowest), np.abs(quotient - highest))
    return float(error[possible].max())
