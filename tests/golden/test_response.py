"""Corner response of chosen structure tensors, and its clamp."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.parameters import Parameters
from golden.response import response

PAPER = Parameters.profile("paper")


def of(a: int, b: int, c: int) -> int:
    return int(
        response(np.array([[a]], np.int32), np.array([[b]], np.int32), np.array([[c]], np.int32), PAPER)[0, 0]
    )


@pytest.mark.parametrize(
    ("a", "b", "c", "expected"),
    [
        (0, 0, 0, 0),
        (100, 100, 0, 200),
        (100, 0, 0, 0),
        (0, 65025, 0, 0),
        (9, 1, 3, 0),  # a single edge: 10 - sqrt(64 + 36)
        (25, 9, 0, 18),  # 34 - 16
        (50, 50, 30, 40),  # 100 - 60
        (50, 50, -30, 40),
        (10, 5, 2, 9),  # 15 - isqrt(25 + 16 = 41)
        (65025, 65025, 0, 130050),  # full scale
        (65025, 65025, 65025, 0),
        (65025, 65025, -65025, 0),
        (1046529, 1046529, 0, 2093058),
        (1046529, 1046529, -1046529, 0),
        (0, 1, 1, 0),  # 1 - isqrt(1 + 4 = 5) = -1, clamped
    ],
)
def test_by_hand(a: int, b: int, c: int, expected: int) -> None:
    assert of(a, b, c) == expected


@given(st.data(), st.integers(0, 1046529), st.integers(0, 1046529))
def test_equals_the_formula_in_whole_numbers(data: st.DataObject, a: int, b: int) -> None:
    bound = math.isqrt(a * b)
    c = data.draw(st.integers(-bound, bound))
    expected = max(a + b - math.isqrt((a - b) ** 2 + (2 * c) ** 2), 0)
    assert of(a, b, c) == of(b, a, c) == of(a, b, -c) == expected


def test_rounding_the_tensor_makes_the_root_at_most_one_too_large() -> None:
    """All tensors with C² <= AB up to 10 in steps of 1/64, rounded as smoothing rounds."""
    a, b = np.meshgrid(np.arange(641), np.arange(641))
    c = np.floor(np.sqrt(a * b)).astype(np.int64)
    a, b, c = ((values + 32) >> 6 for values in (a, b, c))
    excess = np.floor(np.sqrt((a - b) ** 2 + 4 * c**2)) - (a + b)
    assert excess.max() == 1
    assert (response(a, b, c, PAPER) >= 0).all()
