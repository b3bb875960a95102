"""Thresholds of a frame, by hand."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.parameters import Parameters
from golden.settings import Reference, Settings
from golden.thresholds import choose_reference, thresholds


@pytest.mark.parametrize(
    ("reference", "previous", "constant", "floor", "expected"),
    [
        ("previous", 5000, 8192, 1024, 5000),
        ("previous", 1024, 8192, 1024, 1024),
        ("previous", 1000, 8192, 1024, 1024),  # below the floor
        ("previous", 0, 8192, 1, 1),
        ("previous", None, 8192, 1024, 8192),  # first frame
        ("previous", None, 500, 1024, 1024),  # the floor holds for the constant too
        ("constant", 5000, 8192, 1024, 8192),
        ("constant", None, 8192, 1024, 8192),
        ("constant", 5000, 500, 1024, 1024),
    ],
)
def test_reference(
    reference: Reference, previous: int | None, constant: int, floor: int, expected: int
) -> None:
    settings = Settings(reference=reference, constant=constant, floor=floor)
    assert choose_reference(settings, previous) == expected


@pytest.mark.parametrize(
    ("sigma1", "sigma2", "reference", "t1", "t2", "t2_pixels"),
    [
        (0.5, 0.25, 1000, 500, 2250, 250),
        # sigma1 = 6554/65536: 6554 · 11148 = 73063992; sigma2 = 13107/65536: 13107 · 11148 =
        # 146116836
        (0.1, 0.2, 11148, 1114, 20066, 2229),
        (0.0, 0.0, 130050, 0, 0, 0),
        (0.5, 15.0, 1, 0, 135, 15),
        (65535 / 65536, 1.0, 65536, 65535, 589824, 65536),
    ],
)
def test_products(sigma1: float, sigma2: float, reference: int, t1: int, t2: int, t2_pixels: int) -> None:
    settings = Settings(sigma1=sigma1, sigma2=sigma2)
    assert thresholds(settings, reference, Parameters.profile("paper")) == (t1, t2)
    assert thresholds(settings, reference, Parameters.profile("paper", patches="pixels")) == (t1, t2_pixels)


@given(
    # smaller ones are refused, except for 0
    st.just(0.0) | st.floats(2**-16, 1, exclude_max=True),
    st.just(0.0) | st.floats(2**-16, 16, exclude_max=True),
    st.integers(0, 130050),
    st.integers(0, 130050),
)
def test_rounding_down_t1_decides_nothing_and_t2_at_most_one_unit(
    sigma1: float, sigma2: float, reference: int, response: int
) -> None:
    settings = Settings(sigma1=sigma1, sigma2=sigma2)
    t1, t2 = thresholds(settings, reference, Parameters.profile("paper"))
    assert (response > t1) == (response > Fraction(settings.sigma1_fixed * reference, 1 << 16))
    assert 0 <= Fraction(9 * settings.sigma2_fixed * reference, 1 << 16) - t2 < 1
