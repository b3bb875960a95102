"""Integer square roots where they are hardest: at the squares and one below."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from golden.parameters import Parameters
from golden.square_root import floor_sqrt, li_chu


def test_around_every_square_up_to_2_to_17() -> None:
    k = np.arange(1, (1 << 17) + 1, dtype=np.int64)
    for radicand, root in ((k * k, k), (k * k - 1, k - 1), (k * k + 2 * k, k)):
        assert (li_chu(radicand, 18) == root).all()
        assert (floor_sqrt(radicand.astype(np.float64)) == root).all()


def test_around_every_square_of_ten_bit_pixels() -> None:
    k = np.arange(1, 1 << Parameters.profile("paper", pixel_bits=10).response_bits, dtype=np.int64)
    for radicand, root in ((k * k, k), (k * k - 1, k - 1), (k * k + 2 * k, k)):
        assert (floor_sqrt(radicand.astype(np.float64)) == root).all()


def test_every_radicand_of_16_bits() -> None:
    radicand = np.arange(1 << 16, dtype=np.int64)
    expected = [math.isqrt(value) for value in range(1 << 16)]
    assert li_chu(radicand, 8).tolist() == expected
    assert floor_sqrt(radicand.astype(np.float64)).tolist() == expected


@given(st.lists(st.integers(0, 2**42 - 1), min_size=1, max_size=50))
def test_any_radicand_equals_isqrt(radicands: list[int]) -> None:
    expected = [math.isqrt(value) for value in radicands]
    assert li_chu(np.array(radicands), 21).tolist() == expected
    assert floor_sqrt(np.array(radicands, dtype=np.float64)).tolist() == expected


def test_more_result_bits_than_needed_change_nothing() -> None:
    radicand = np.arange(1000, dtype=np.int64)
    assert (li_chu(radicand, 5) == li_chu(radicand, 17)).all()


def test_extremes() -> None:
    assert li_chu(np.array([0, 1, 3, 4**17 - 1]), 17).tolist() == [0, 1, 1, 2**17 - 1]
    assert floor_sqrt(np.array([0.0, 1.0, 3.0, 2.0**46 - 1])).tolist() == [0, 1, 1, 2**23 - 1]
