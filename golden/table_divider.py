"""Divider by a table of reciprocals (Sec. 4.4): quotients up to a limit, in units of 1/128.

"A Look Up Table manages the quotient operations." The denominator is shifted up by pairs of places
until one of its two highest bits is set; its highest bits are the address. The reciprocal that is
stored there is multiplied by the numerator, which has been shifted along. The reciprocal is held in
digits of -1, 0, 1 and 2, each worth four times the one before, so that the product is a sum with
one addition for each digit, and there is no multiplier.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from golden.divider import HALF
from golden.formats import OFFSET_BITS

Int64 = NDArray[np.int64]

HALF_ADDRESS_BITS = 9
"""Address bits for quotients up to one half: with one less, the error would exceed 1/128."""
NUMERATOR_BITS = 11
"""Bits of a numerator below the highest bit of a denominator that go into the product."""


@dataclass(frozen=True)
class ReciprocalTable:
    """Formats and contents of the table.

    Parameters
    ----------
    bits
        Width of a denominator, even.
    limit
        Largest size of a quotient, in units of 1/128, a power of two from one half.
    """

    bits: int
    limit: int

    def __post_init__(self) -> None:
        if self.bits % 2 or self.bits < self.address_bits:
            raise ValueError(f"bits is {self.bits}; allowed: even numbers from {self.address_bits}")

    @property
    def _doublings(self) -> int:
        """How often the limit is the double of one half; so much more exact is the reciprocal."""
        return self.limit.bit_length() - HALF.bit_length()

    @property
    def address_bits(self) -> int:
        """Highest bits of a shifted denominator. One of the first two is set."""
        return HALF_ADDRESS_BITS + self._doublings

    @property
    def digits(self) -> int:
        """Digits of a reciprocal: as many as the largest one needs."""
        largest, digits = 0, 0
        while largest < 1 << self.address_bits:
            largest, digits = 4 * largest + 2, digits + 1
        return digits

    @property
    def numerator_bits(self) -> int:
        """Width of a shifted numerator, signed, that can have a quotient within the limit."""
        return self.bits + self._doublings

    @property
    def unused_bits(self) -> int:
        """Lowest bits of a shifted numerator that do not go into the product."""
        return self.bits - NUMERATOR_BITS

    @property
    def factor_bits(self) -> int:
        """Width of the numerator's factor, signed: the bits that are used, and one half below."""
        return self.numerator_bits - self.unused_bits + 1

    @property
    def product_bits(self) -> int:
        """Bits of the product below one unit of the quotient."""
        return self.address_bits + NUMERATOR_BITS - OFFSET_BITS - 1

    @property
    def start(self) -> int:
        """What is added to the product: just below one half of a unit, to round to nearest."""
        return (1 << (self.product_bits - 1)) - 1

    def reciprocals(self) -> Int64:
        """2**address_bits · q / d for each address, 0 for those that do not occur.

        d is the middle of the denominators with this address, q the smallest shifted denominator.
        """
        address = np.arange(1 << self.address_bits)
        quarter = len(address) // 4
        middle = 2 * np.maximum(address, quarter) + 1
        doubled = 2 * (2 * quarter << self.address_bits) // middle
        return np.where(address < quarter, 0, (doubled + 1) >> 1)

    def digits_of(self, reciprocals: Int64) -> Int64:
        """(..., digits) of -1, 0, 1, 2, the lowest first."""
        left, found = reciprocals, []
        for _ in range(self.digits):
            digit = ((left + 1) & 3) - 1
            left = (left - digit) >> 2
            found.append(digit)
        return np.stack(found, axis=-1)


@cache
def _reciprocals(table: ReciprocalTable) -> Int64:
    return table.reciprocals()


def divide_by_table(
    numerator: Int64, denominator: Int64, bits: int, limit: int
) -> tuple[Int64, NDArray[np.bool_]]:
    """numerator / denominator in units of 1/128, and whether its size is the limit or more.

    The error is below one unit; rounding alone makes half of it.

    Parameters
    ----------
    numerator
        Any sign; ``|numerator| < 2**(62 - bits)``.
    denominator
        1 to ``2**bits - 1``.
    bits
        Width of a denominator, even.
    limit
        Largest size of the result, in units of 1/128, a power of two; larger results are clamped.
    """
    table = ReciprocalTable(bits, limit)
    length = np.frexp(denominator.astype(np.float64))[1].astype(np.int64)
    places = (bits - length) & ~1
    shifted = numerator << places
    # so large that the quotient is beyond the limit whatever the denominator
    beyond = np.abs(2 * shifted + 1) >> table.numerator_bits != 0
    factor = 2 * (shifted >> table.unused_bits) + 1
    address = (denominator << places) >> (bits - table.address_bits)
    product = np.where(beyond, 0, factor) * _reciprocals(table)[address]
    quotient = (product + table.start) >> table.product_bits
    quotient = np.where(beyond, np.sign(numerator) * limit, np.clip(quotient, -limit, limit))
    return quotient, np.abs(quotient) == limit
