"""The LUT divider: at most 1/128 pixel off, shown over all operands."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from golden.divider import HALF, INDEX_BITS, NUMERATOR_BITS, RECIPROCALS, bit_length, divide, worst_error

WORST = worst_error()


def test_stated_worst_error_is_within_the_goal() -> None:
    assert worst_error() <= 1 / 128


def test_table_by_hand() -> None:
    # the first interval of divisors, [256, 257)/512, has its middle at 513/1024: 512 · 1024/513 = 1022.0
    # the last, [511, 512)/512, at 1023/1024: 512 · 1024/1023 = 512.5005
    assert len(RECIPROCALS) == 256
    assert (RECIPROCALS[0], RECIPROCALS[255]) == (1022, 513)
    assert (np.diff(RECIPROCALS) <= 0).all()


def test_every_pair_of_small_operands() -> None:
    """Divisors up to 12 bits: every table entry, each with both of its neighbours."""
    worst = Fraction(worst_error())
    for denominator in range(1, 1 << 12):
        numerator = np.arange(denominator // 2 + 1)
        result = divide(numerator, np.full_like(numerator, denominator))
        error = np.abs(result * denominator - 128 * numerator).max()
        assert Fraction(int(error), 128 * denominator) <= worst


def test_worst_error_is_the_worst_and_no_more() -> None:
    """Operands of 40 bits at both ends of every (table entry, cut dividend): the bound holds and is met."""
    width = 40
    index = np.arange(1 << INDEX_BITS, dtype=np.int64)[:, None]
    cut = np.arange(1 << NUMERATOR_BITS, dtype=np.int64)[None, :]
    errors = []
    for last_divisor in (0, 1):
        denominator = ((256 + index + last_divisor) << (width - INDEX_BITS - 1)) - last_divisor
        for last_dividend in (0, 1):
            numerator = ((cut + last_dividend) << (width - NUMERATOR_BITS - 1)) - last_dividend
            wide, tall = np.broadcast_arrays(np.minimum(numerator, denominator // 2), denominator)
            errors.append(np.abs(divide(wide, tall) / 128 - wide / tall).max())
    assert max(errors) <= worst_error() + 1e-9
    assert max(errors) >= worst_error() - 1e-6


@given(st.data(), st.integers(1, 61))
def test_wide_operands(data: st.DataObject, bits: int) -> None:
    denominator = data.draw(st.integers(1 << (bits - 1), (1 << bits) - 1))
    numerator = data.draw(st.integers(0, denominator // 2))
    result = int(divide(np.array([numerator]), np.array([denominator]))[0])
    assert 0 <= result <= HALF
    assert abs(Fraction(result, 128) - Fraction(numerator, denominator)) <= WORST


def test_many_wide_operands() -> None:
    rng = np.random.default_rng(1)
    bits = rng.integers(2, 62, 20000)
    denominator = (1 << (bits - 1)) + rng.integers(0, 1 << (bits - 1))
    numerator = rng.integers(0, denominator // 2 + 1)
    limit = Fraction(worst_error())
    for n, d, result in zip(
        numerator.tolist(), denominator.tolist(), divide(numerator, denominator).tolist(), strict=True
    ):
        assert abs(Fraction(result, 128) - Fraction(n, d)) <= limit


def test_ends_of_the_range_are_exact() -> None:
    denominator = np.concatenate([np.arange(2, 5000, 2), 1 << np.arange(1, 62)])
    assert (divide(np.zeros_like(denominator), denominator) == 0).all()
    assert (divide(denominator // 2, denominator) == HALF).all()


def test_bit_length() -> None:
    values = sorted({(1 << k) + d for k in range(62) for d in (-1, 0, 1) if (1 << k) + d > 0})
    assert bit_length(np.array(values)).tolist() == [value.bit_length() for value in values]
