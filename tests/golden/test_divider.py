"""The divider: every quotient is rounded as exact arithmetic rounds it."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.divider import HALF, QUOTIENT_BITS, divide


def exact(numerator: int, denominator: int) -> int:
    """The definition in fractions: nearest 1/128, halves away from zero, at most one half."""
    nearest = int(128 * abs(Fraction(numerator, denominator)) + Fraction(1, 2))  # rounded down
    return min(nearest, 64) * (1 if numerator >= 0 else -1)


def test_units() -> None:
    assert (HALF, QUOTIENT_BITS) == (64, 8)


@pytest.mark.parametrize(
    ("numerator", "denominator", "expected"),
    [
        (0, 5, 0),
        (1, 4, 32),
        (1, 3, 43),  # 42.67
        (333_333, 1_000_000, 43),
        (1, 256, 1),  # half a unit is rounded away from zero
        (1, 257, 0),
        (127, 256, 64),  # 63.5
        (126, 256, 63),
        (499, 1000, 64),  # 63.87
        (1, 2, 64),
        (501, 1000, 64),
        (1, 1, 64),
        ((1 << 54) - 1, 1, 64),
    ],
)
def test_by_hand(numerator: int, denominator: int, expected: int) -> None:
    assert divide(np.array([numerator]), np.array([denominator])).tolist() == [expected]
    assert divide(np.array([-numerator]), np.array([denominator])).tolist() == [-expected]


def test_every_pair_of_small_operands() -> None:
    """Divisors up to 12 bits, with every dividend up to more than their half, of either sign."""
    for denominator in range(1, 1 << 12):
        numerator = np.arange(denominator // 2 + 3)
        # floor(128 n/d + 1/2) in whole numbers
        nearest = np.minimum((256 * numerator + denominator) // (2 * denominator), 64)
        divisor = np.full_like(numerator, denominator)
        assert np.array_equal(divide(numerator, divisor), nearest)
        assert np.array_equal(divide(-numerator, divisor), -nearest)


@given(st.data(), st.integers(1, 62))
def test_wide_operands(data: st.DataObject, bits: int) -> None:
    denominator = data.draw(st.integers(1 << (bits - 1), (1 << bits) - 1))
    numerator = data.draw(st.integers(0, min(denominator, (1 << 54) - 1)))
    for signed in (numerator, -numerator):
        assert divide(np.array([signed]), np.array([denominator])) == exact(signed, denominator)


def test_around_every_step_of_the_result() -> None:
    """Operands of 40 bits just below, at and just above each half unit, where rounding changes."""
    rng = np.random.default_rng(1)
    for denominator in [1 << 39, (1 << 40) - 1, *rng.integers(1 << 39, 1 << 40, 20).tolist()]:
        turns = [-(-(2 * k + 1) * denominator // 256) for k in range(64)]
        numerator = np.array([turn + d for turn in turns for d in (-1, 0, 1)])
        result = divide(numerator, np.full_like(numerator, denominator))
        assert result.tolist() == [exact(value, denominator) for value in numerator.tolist()]
        # it changes there, and nowhere else
        assert result.reshape(-1, 3).tolist() == [[k, k + 1, k + 1] for k in range(64)]


def test_many_wide_operands() -> None:
    rng = np.random.default_rng(1)
    bits = rng.integers(2, 54, 20000)
    denominator = (1 << (bits - 1)) + rng.integers(0, 1 << (bits - 1))
    numerator = rng.integers(-denominator, denominator + 1)
    expected = [exact(n, d) for n, d in zip(numerator.tolist(), denominator.tolist(), strict=True)]
    assert divide(numerator, denominator).tolist() == expected


def test_ends_of_the_range() -> None:
    denominator = np.concatenate([np.arange(2, 5000, 2), 1 << np.arange(1, 55)])
    assert (divide(np.zeros_like(denominator), denominator) == 0).all()
    assert (divide(denominator // 2, denominator) == HALF).all()
    assert (divide(-denominator // 2, denominator) == -HALF).all()
