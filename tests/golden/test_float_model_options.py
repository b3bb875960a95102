"""Filters of pixels and responses, Sobel gradients, adaptive threshold: the same in float64."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden import Parameters, Settings, detect, float_model, reference_detect
from golden.adaptive_threshold import LEVEL_GAIN, prominence
from golden.frame import response_map
from golden.preprocessing import gradients
from golden.response_filter import response_filter
from tests.support.photographs import PHOTOGRAPHS, photograph
from tests.support.profiles import ADAPTIVE
from tests.support.strategies import detectors, images

FAINT = ("moon", "cell", "clock")
"""Their largest gradients are a few units, so that rounding decides most corners."""
LOW, HIGH = -2, 3
"""Error of D in integers; see test_float_model.py."""


def exact_responses(image: NDArray[np.uint8], parameters: Parameters) -> NDArray[np.float64]:
    return float_model.response_map(image, parameters.algorithm)


@given(images())
def test_sobel_is_rounded_to_nearest(image: NDArray[np.uint8]) -> None:
    exact = float_model.gradients(image, "sobel")
    for integer, floating in zip(gradients(image, "sobel"), exact, strict=True):
        assert (np.abs(integer - floating[1:-1, 1:-1]) <= 0.5).all()


@given(images(), detectors(derivative="sobel", pixel_filter="none"))
def test_response_to_rounded_gradients_is_within_bounds(
    image: NDArray[np.uint8], parameters: Parameters
) -> None:
    """√(D/2) is a smallest singular value: it moves by no more than the gradients' norm.

    Each is off by 1/2 at most, and weights sum to 1.
    """
    exact = np.sqrt(np.maximum(exact_responses(image, parameters)[3:-3, 3:-3], 0) / 2)
    moved = np.sqrt(0.5) + 1e-9
    responses = response_map(image, parameters)
    assert (responses >= 2 * np.maximum(exact - moved, 0) ** 2 + LOW).all()
    assert (responses < 2 * (exact + moved) ** 2 + HIGH).all()


@given(images(max_side=30), detectors(derivative="central", pixel_filter="none"))
def test_filtered_responses_and_what_the_threshold_leaves_of_them(
    image: NDArray[np.uint8], parameters: Parameters
) -> None:
    responses, exact = response_map(image, parameters), exact_responses(image, parameters)
    filtered = response_filter(responses)[3:-3, 3:-3]
    floating = float_model.binomial(exact)[7:-7, 7:-7]
    assert (filtered - floating > LOW - 0.5 - 1e-6).all() and (filtered - floating <= HIGH + 0.5 + 1e-6).all()
    windows = sliding_window_view(responses, (9, 9))
    means = sliding_window_view(exact[3:-3, 3:-3], (9, 9)).mean(axis=(-2, -1))
    for weight in (1, 4, 15):
        left = prominence(filtered, windows, weight)
        share = weight / 8 * LEVEL_GAIN
        error = left - (floating - share * means)
        # L and the part of it that is subtracted are rounded down
        assert (error > LOW - 0.5 - share * HIGH - 1e-6).all()
        assert (error < HIGH + 0.5 - share * LOW + weight / 8 + 1 + 1e-6).all()


# a smoothed pixel is rounded to one of 256 values, and its differences are small
@pytest.mark.parametrize(
    ("parameters", "least"),
    [(Parameters.profile("robust"), 0.93), (ADAPTIVE.changed(fit="nine"), 0.95)],
    ids=["robust", "adaptive"],
)
@pytest.mark.parametrize("name", [name for name in PHOTOGRAPHS if name not in FAINT])
def test_float64_finds_the_same(name: str, parameters: Parameters, least: float) -> None:
    """Rounded pixels and gradients change only a few ties, and hardly any common response."""
    image, settings = photograph(name), Settings(sigma1=0.03)
    dref = max(int(response_map(image, parameters).max()), settings.floor)
    one = detect(image, parameters, settings, reference=dref)
    other = reference_detect(image, parameters, settings, reference=dref)
    assert len(one) > 10
    apart = np.hypot(one.x[:, None] - other.x, one.y[:, None] - other.y)
    common = apart.min(axis=1) < 0.25
    assert common.mean() > least and (apart.min(axis=0) < 0.25).mean() > least
    responses = other.response[apart.argmin(axis=1)][common]
    assert np.median(np.abs(one.response[common] / responses - 1)) < 0.02


def test_constants_are_the_golden_models() -> None:
    assert float_model.LEVEL_GAIN == LEVEL_GAIN
