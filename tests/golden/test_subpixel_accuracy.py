"""The accuracy of peaks: mantissas against exact arithmetic, and mirrored corners."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden.algorithm import Fit
from golden.corner_detection import corner_detection
from golden.frame import response_map
from golden.parameters import Parameters
from golden.settings import Settings
from golden.subpixel import (
    subpixel,
)
from golden.thresholds import thresholds
from tests.support.offsets import bounds, exact_peaks
from tests.support.photographs import PHOTOGRAPHS, photograph


def errors(patches: NDArray[np.integer], parameters: Parameters) -> NDArray[np.float64]:
    """Errors of the offsets, the larger of both axes; asserts that none exceeds its bound."""
    offset, exact = subpixel(patches, parameters), exact_peaks(patches, parameters)
    error = np.maximum(np.abs(offset.dx / 128 - exact.dx), np.abs(offset.dy / 128 - exact.dy))
    bound = bounds(patches, parameters)
    assert (error <= bound + 1e-9).all()
    assert (exact.maximum == ~offset.not_maximum)[np.isfinite(bound)].all()
    return error


def random_peaks(pixel_bits: int, top: int) -> NDArray[np.int64]:
    """Random patches with the largest sample in the centre."""
    patches = np.random.default_rng([pixel_bits, top]).integers(0, top, (50_000, 9), endpoint=True)
    every, place = np.arange(len(patches)), patches.argmax(axis=1)
    patches[every, place], patches[:, 4] = patches[:, 4], patches[every, place]
    return patches.reshape(-1, 3, 3)


@pytest.mark.parametrize("fit", ["nine", "six"])
@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
def test_error_of_random_peaks(pixel_bits: int, fit: Fit) -> None:
    parameters = Parameters.profile("paper", pixel_bits=pixel_bits, fit=fit, gradient="signed")
    for top in (30, 1000):
        errors(random_peaks(pixel_bits, min(top, parameters.response_max)), parameters)
    patches = random_peaks(pixel_bits, parameters.response_max)
    error, surely = errors(patches, parameters), np.isfinite(bounds(patches, parameters))
    assert np.quantile(error[surely], 0.5) <= 0.0026
    assert np.quantile(error[surely], 0.99) <= 0.015
    # all but one in three hundred maxima can be told from the rest
    assert (exact_peaks(patches, parameters).maximum & ~surely).mean() <= 1 / 300


@cache
def candidates(profile_name: str, fit: Fit) -> tuple[Parameters, NDArray[np.int32]]:
    """The 3x3 responses of every corner of the photographs, by the default thresholds."""
    parameters = Parameters.profile(profile_name, fit=fit)
    settings, patches = Settings.default(parameters), []
    for name in PHOTOGRAPHS:
        responses = response_map(photograph(name), parameters)
        t1, _ = thresholds(settings, max(int(responses.max()), settings.floor), parameters)
        corners = corner_detection(responses, t1, parameters.algorithm.ties)
        patches.append(sliding_window_view(responses, (3, 3))[corners])
    return parameters, np.concatenate(patches)


@pytest.mark.parametrize("fit", ["nine", "six"])
@pytest.mark.parametrize("profile_name", ["paper", "robust"])
def test_error_of_photographs_corners(profile_name: str, fit: Fit) -> None:
    """Median, 95th and 99th percentile in pixels; rounding to 1/128 accounts for 1/256."""
    parameters, patches = candidates(profile_name, fit)
    assert len(patches) > 11_500
    error = errors(patches, parameters)
    assert np.quantile(error, 0.5) <= 0.003
    assert np.quantile(error, 0.95) <= 0.0065
    assert np.quantile(error, 0.99) <= 0.012
    offset, exact = subpixel(patches, parameters), exact_peaks(patches, parameters)
    # a maximum is hardly ever taken for none, or none for a maximum, and no direction is preferred
    assert (exact.maximum == offset.not_maximum).mean() <= 0.0004
    assert abs((offset.dx / 128 - exact.dx).mean()) <= 1 / 1000
    assert abs((offset.dy / 128 - exact.dy).mean()) <= 1 / 1000


@pytest.mark.parametrize("profile_name", ["paper", "robust"])
def test_mirrored_corners_of_photographs_are_one_unit_off_at_most(profile_name: str) -> None:
    """At least 98 in a hundred are one unit off at most, and seven in ten are equal."""
    parameters, patches = candidates(profile_name, "nine")
    whole = subpixel(patches, parameters)
    for turned, x, y in ((patches[:, :, ::-1], -1, 1), (patches[:, ::-1], 1, -1)):
        mirrored = subpixel(turned, parameters)
        apart = np.maximum(np.abs(x * mirrored.dx - whole.dx), np.abs(y * mirrored.dy - whole.dy))
        assert (apart == 0).mean() >= 0.7
        assert (apart <= 1).mean() >= 0.98
