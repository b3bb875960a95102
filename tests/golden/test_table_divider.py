"""The divider by a table of reciprocals: its error, found for every pair of operands."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.subpixel import FITS
from golden.table_divider import Int64, ReciprocalTable, divide_by_table

FORMATS = {
    "surface": ReciprocalTable(2 * FITS["nine"].mantissa_bits, FITS["nine"].limit),
    "printed": ReciprocalTable(2 * FITS["printed"].mantissa_bits + 2, FITS["printed"].limit),
    "gradient step": ReciprocalTable(2 * FITS["gradient"].mantissa_bits, FITS["gradient"].limit),
}
every_format = pytest.mark.parametrize("table", FORMATS.values(), ids=FORMATS)


def divide(table: ReciprocalTable, numerator: Int64, denominator: Int64) -> Int64:
    numerator, denominator = np.broadcast_arrays(numerator, denominator)
    quotient, reached = divide_by_table(numerator, denominator, table.bits, table.limit)
    assert np.array_equal(reached, np.abs(quotient) == table.limit)
    return quotient


def test_sizes() -> None:
    """Address bits, digits and the largest reciprocal; 2**9 addresses, a quarter of them unused."""
    surface, step = FORMATS["surface"], FORMATS["gradient step"]
    assert (surface.bits, surface.limit, surface.address_bits, surface.digits) == (20, 64, 9, 5)
    assert (step.bits, step.limit, step.address_bits, step.digits) == (24, 512, 12, 7)
    assert surface.reciprocals().max() == 510 and step.reciprocals().max() == 4094
    with pytest.raises(ValueError, match="bits is 21; allowed: even numbers from 9"):
        ReciprocalTable(21, 64)


@every_format
def test_reciprocals_are_those_of_the_middles(table: ReciprocalTable) -> None:
    found = table.reciprocals()
    quarter = len(found) // 4
    assert len(found) == 1 << table.address_bits and not found[:quarter].any()
    for address in range(quarter, len(found)):
        exact = len(found) * quarter / (address + Fraction(1, 2))
        assert found[address] == int(exact + Fraction(1, 2))


@every_format
def test_digits_give_the_reciprocal(table: ReciprocalTable) -> None:
    reciprocals = table.reciprocals()
    digits = table.digits_of(reciprocals)
    assert digits.shape == (len(reciprocals), table.digits)
    assert set(np.unique(digits).tolist()) == {-1, 0, 1, 2}
    assert (digits @ 4 ** np.arange(table.digits) == reciprocals).all()
    # one digit less would not hold the largest one
    assert 2 * sum(4**k for k in range(table.digits - 1)) < reciprocals.max()


@pytest.mark.parametrize(
    ("table", "step"),
    [
        (FORMATS["surface"], 1),
        (FORMATS["printed"], 1),
        (FORMATS["gradient step"], 61),
        pytest.param(FORMATS["gradient step"], 1, marks=pytest.mark.verify),
    ],
)
def test_no_pair_of_operands_is_more_than_one_unit_off(table: ReciprocalTable, step: int) -> None:
    """Every pair that the formats allow, with ``step`` 1; otherwise every so many addresses.

    Shifting both operands up by the same places changes neither the quotient nor the result, so
    that only denominators with one of the two highest bits set matter. The result is the same for
    all pairs that share the address and the used bits of the numerator, and the exact quotient
    rises or falls with either operand alone. So the error is largest at a corner of this rectangle
    of pairs. Numerators that do not fit are beyond the limit with any denominator: one of each sign
    is enough.
    """
    reach = 1 << (table.numerator_bits - 1 - table.unused_bits)
    low = np.arange(-reach - 1, reach + 1)[None] << table.unused_bits
    high = low + (1 << table.unused_bits) - 1
    width = table.bits - table.address_bits
    addresses = np.arange(1 << (table.address_bits - 2), 1 << table.address_bits, step)[:, None]
    worst = 0.0
    for part in np.array_split(addresses, -(-len(addresses) // 64)):
        least, most = part << width, ((part + 1) << width) - 1
        quotient = divide(table, low, least)
        for numerator in (low, high):
            for denominator in (least, most):
                exact = np.clip(128 * numerator / denominator, -table.limit, table.limit)
                worst = max(worst, float(np.abs(quotient - exact).max()))
        assert np.array_equal(quotient, divide(table, high, most))
    assert 0.85 < worst < 0.93


@every_format
def test_larger_numerators_are_clamped(table: ReciprocalTable) -> None:
    denominator = np.arange(1, 1 << table.bits, 997)[:, None]
    times = np.array([2, 3, 100]) * table.limit
    numerator = times * denominator // 128 + 1
    assert (divide(table, numerator, denominator) == table.limit).all()
    assert (divide(table, -numerator, denominator) == -table.limit).all()


@given(st.data(), st.sampled_from(list(FORMATS.values())))
def test_any_operands_are_within_one_unit_of_the_fraction(
    data: st.DataObject, table: ReciprocalTable
) -> None:
    length = data.draw(st.integers(1, table.bits))
    denominator = data.draw(st.integers(1 << (length - 1), (1 << length) - 1))
    numerator = data.draw(st.integers(-2 * denominator, 2 * denominator) | st.integers(-(1 << 26), 1 << 26))
    exact = min(max(Fraction(128 * numerator, denominator), Fraction(-table.limit)), Fraction(table.limit))
    quotient = int(divide(table, np.array([numerator]), np.array([denominator]))[0])
    assert abs(quotient - exact) < 1
    # doubling twice changes nothing
    if length + 2 <= table.bits:
        assert divide(table, np.array([4 * numerator]), np.array([4 * denominator])) == [quotient]


@pytest.mark.parametrize(
    ("numerator", "denominator", "expected"),
    [
        (0, 5, 0),
        # 16 places up: address 128, the first; 2**9 · 128 / 128.5 = 510.01; factor 2 · 128 + 1;
        # (257 · 510 + 2047) / 4096 = 32.5, rounded down
        (1, 4, 32),
        # 14 places: the same reciprocal; factor 321: 40.47
        (5, 16, 40),
        # 18 places: address 384, 2**9 · 128 / 384.5 = 170.4; factor 1025: 43.04
        (1, 3, 43),
        # no place: address 488, 134.2; factor 2 · 651 + 1: 43.1
        (333_333, 1_000_000, 43),
        # 10 places: factor 5: 1.12, where 0.498 is exact
        (1, 257, 1),
        # factor -3: 0.13, and -1 where it is not half a unit
        (-1, 256, 0),
        (-2, 256, -1),
        # 18 places: address 256, 255.5 rounds to 256; factors 1025 and -1023: 64.6 and -63.4
        (1, 2, 64),
        (-1, 2, -64),
        # 63.99988, which is 64 all the same, and so is called clamped
        (262_143, 1 << 19, 64),
        ((1 << 21) - 1, 1, 64),
        (-(1 << 21) + 1, 1, -64),
    ],
)
def test_by_hand(numerator: int, denominator: int, expected: int) -> None:
    assert divide(FORMATS["surface"], np.array([numerator]), np.array([denominator])).tolist() == [expected]
