"""T = S - sigma2 · L of windows made by hand, and its effect on the records."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from golden import Settings, detect
from golden.adaptive_threshold import adaptive_threshold, local_level, prominence
from golden.parameters import Parameters
from golden.thresholds import thresholds
from tests.support.profiles import ADAPTIVE


def level(total: int) -> NDArray[np.int32]:
    """A window with that sum."""
    window = np.zeros((9, 9), np.int32)
    window[8, 0] = total
    return window


def test_local_level_is_a_64th_of_the_sum() -> None:
    assert [local_level(level(total)).item() for total in (0, 63, 64, 6400)] == [0, 0, 1, 100]
    assert local_level(np.full((2, 9, 9), 130050, np.int32)).tolist() == [81 * 130050 // 64] * 2


@pytest.mark.parametrize(("weight", "left"), [(0, 1000), (1, 988), (2, 975), (4, 950), (8, 900), (15, 813)])
def test_weight_counts_in_eighths_rounded_down(weight: int, left: int) -> None:
    # 100/8 = 12.5, 15·100/8 = 187.5
    assert prominence(np.array(1000), level(6400), weight).item() == left


def test_threshold_is_strict_and_the_response_never_negative() -> None:
    windows = np.stack([level(6400)] * 3)
    accepted, response = adaptive_threshold(np.array([150, 151, 20]), windows, 100, 4)
    assert accepted.tolist() == [False, True, False]
    assert response.tolist() == [100, 101, 0]


@pytest.mark.parametrize(
    ("sigma2", "weight"), [(0, 0), (0.12, 0), (0.125, 1), (0.5, 4), (1, 8), (1.99, 15), (2, 15), (15.9, 15)]
)
def test_sigma2_is_a_weight_whatever_the_reference(sigma2: float, weight: int) -> None:
    settings, parameters = Settings(sigma1=0.5, sigma2=sigma2), Parameters.profile("paper", texture="mean")
    assert settings.mean_weight == weight
    for reference in (0, 1, 65026):
        assert thresholds(settings, reference, parameters) == (reference // 2, weight)


@given(st.integers(0, 2**32 - 1), st.integers(0, 15), st.integers(0, 130050))
def test_equals_the_formula_in_fractions(seed: int, weight: int, t1: int) -> None:
    rng = np.random.default_rng(seed)
    windows = rng.integers(0, 130050, (5, 9, 9), np.int32, endpoint=True)
    peaks = rng.integers(0, 130050, 5, np.int32, endpoint=True)
    accepted, response = adaptive_threshold(peaks, windows, t1, weight)
    for k in range(5):
        left = int(peaks[k]) - (weight * (int(windows[k].sum()) // 64)) // 8
        assert (bool(accepted[k]), int(response[k])) == (left > t1, max(left, 0))


@pytest.mark.parametrize("response_filter", ["none", "binomial"])
def test_a_higher_t1_leaves_the_largest_responses(response_filter: Any, camera: NDArray[np.uint8]) -> None:
    """Records sorted by response begin with those that a budget's threshold would have left."""
    parameters = ADAPTIVE.changed(response_filter=response_filter)
    many = detect(camera, parameters, Settings(sigma1=0.01), reference=20000)
    few = detect(camera, parameters, Settings(sigma1=0.1), reference=20000)
    large = many.response > 2000
    assert 10 < len(few) < len(many)
    assert np.array_equal(many.x[large], few.x) and np.array_equal(many.y[large], few.y)


def test_rejected_corners_are_reported_with_what_is_left_of_them(camera: NDArray[np.uint8]) -> None:
    settings = Settings(sigma1=0.02, sigma2=1, report_rejected=True)
    corners = detect(camera, ADAPTIVE, settings, reference=20000)
    accepted = corners.accepted
    assert 0 < accepted.sum() < len(corners)
    assert (corners.response[accepted] > 400).all() and (corners.response[~accepted] <= 400).all()
    plain = detect(camera, ADAPTIVE.changed(texture="patches"), settings, reference=20000)
    assert (corners.x == plain.x).all() and (corners.response <= plain.response).all()


def test_weight_of_nothing_rejects_nothing(camera: NDArray[np.uint8]) -> None:
    settings = Settings(sigma1=0.02, sigma2=0, report_rejected=True)
    corners = detect(camera, ADAPTIVE, settings)
    assert len(corners) > 100 and corners.accepted.all()
