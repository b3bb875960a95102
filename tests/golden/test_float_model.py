"""The float reference by hand, and how far rounding takes the golden model from it.

Where the bounds come from: smoothing rounds A, B and C by at most 1/2 each, which moves (A + B) -
sqrt((A - B)² + 4C²) by at most 2 (the worst case is A and B both off by 1/2, and the root by 1);
the floor square root then adds less than 1. So -2 <= D - D_float < 3, and D's errors spread over
less than 5.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from numpy.typing import NDArray

from golden import PROFILES, Corners, Parameters, Settings, detect, float_model, reference_detect
from golden.corner_detection import corner_detection
from golden.frame import response_map
from golden.subpixel import fit_nine, fit_six, subpixel
from golden.texture_filter import texturization
from golden.thresholds import thresholds
from tests.support.offsets import bounds
from tests.support.photographs import PHOTOGRAPHS, photograph
from tests.support.strategies import detectors, images

SPREAD = 5
"""Two responses' errors differ by less than this."""
SETTINGS = Settings(sigma1=0.05, report_rejected=True)
ABSOLUTE = PROFILES["paper"]
SIGNED = replace(ABSOLUTE, gradient="signed")
CENTRAL = {"derivative": "central", "pixel_filter": "none"}
"""Gradients that nothing rounds."""
NINE = np.linalg.pinv(float_model.design_matrix(float_model.GRID_X, float_model.GRID_Y))
"""The nine-point fit as a matrix."""


def inside(values: NDArray[Any]) -> NDArray[Any]:
    """The part of a map of the image's size that has a response."""
    return values[3:-3, 3:-3]


def test_kernel_answers_an_impulse_and_a_constant() -> None:
    impulse = np.zeros((9, 9))
    impulse[4, 4] = 64
    smoothed = float_model.smooth(impulse)
    assert smoothed[2:7, 2:7].tolist() == [
        [1, 2, 2, 2, 1],
        [2, 4, 4, 4, 2],
        [2, 4, 4, 4, 2],
        [2, 4, 4, 4, 2],
        [1, 2, 2, 2, 1],
    ]
    assert np.isnan(smoothed[:2]).all() and np.isnan(smoothed[:, -2:]).all()
    assert float_model.smooth(np.full((5, 5), 0.3))[2, 2] == pytest.approx(0.3)


def test_maps_are_undefined_at_the_edges_only() -> None:
    gx, gy = float_model.gradients(np.zeros((20, 30), np.uint8))
    for values, edge in (
        (gx, 1),
        (gy, 1),
        (float_model.response_map(np.zeros((20, 30), np.uint8), SIGNED), 3),
    ):
        assert values.shape == (20, 30)
        assert not values[edge:-edge, edge:-edge].any()
        assert np.isnan(values).sum() == 600 - (20 - 2 * edge) * (30 - 2 * edge)


def test_edges_at_45_degrees() -> None:
    """A = 48, B = 64, C = 48 or 0, as in the golden model's test, with an unrounded root."""
    y, x = np.mgrid[-10:11, -10:11]
    image = (60 + 4 * (y + np.abs(x))).astype(np.uint8)
    assert float_model.response_map(image, ABSOLUTE)[10, 10] == pytest.approx(112 - np.sqrt(16**2 + 96**2))
    assert float_model.response_map(image, SIGNED)[10, 10] == pytest.approx(96)


@pytest.mark.parametrize(("v", "u"), [(0, 1), (1, -1), (1, 0), (1, 1)])
def test_ties_and_threshold(v: int, u: int) -> None:
    responses = np.zeros((20, 20))
    responses[9, 9] = 3.5
    assert np.argwhere(float_model.corner_map(responses, 3.0, ABSOLUTE)).tolist() == [[9, 9]]
    assert not float_model.corner_map(responses, 3.5, ABSOLUTE).any()
    responses[9 + v, 9 + u] = 3.5
    assert not float_model.corner_map(responses, 3.0, ABSOLUTE).any()
    assert np.argwhere(float_model.corner_map(responses, 3.0, replace(ABSOLUTE, ties="first"))).tolist() == [
        [9, 9]
    ]


@pytest.mark.parametrize("fit", ["nine", "six"])
def test_peak_of_a_paraboloid(fit: Any) -> None:
    y, x = np.mgrid[-1:2, -1:2]
    samples = 10 - 2 * (x - 0.3) ** 2 - 3 * (y + 0.2) ** 2 + (x - 0.3) * (y + 0.2)
    coefficients = float_model.surface(samples, fit)
    assert coefficients[:3] == pytest.approx([-2, -3, 1])
    assert float_model.peak(coefficients) == pytest.approx((0.3, -0.2, 0))


def test_printed_formulas_do_not_find_it() -> None:
    y, x = np.mgrid[-1:2, -1:2]
    coefficients = float_model.surface(10 - (x - 0.3) ** 2 - (y + 0.2) ** 2, "printed")
    dx, dy, flag = float_model.peak(coefficients, printed=True)
    assert (round(dx, 2), dy, flag) == (-0.34, -0.5, 1)
    # even without the misprint L2 for L3 in Eq. 13
    l0, l1, l2, l3, l4, _ = coefficients
    denominator = l2**2 - 4 * l0 * l1
    peak = (2 * l1 * l3 - l2 * l4) / denominator, (2 * l0 * l4 - l2 * l3) / denominator
    assert (round(peak[0], 2), round(peak[1], 2)) == (0.04, -0.54)


@given(images(), detectors(**CENTRAL))
def test_response_is_within_rounding(image: NDArray[np.uint8], parameters: Parameters) -> None:
    error = response_map(image, parameters) - inside(float_model.response_map(image, parameters.algorithm))
    assert error.min() >= -2
    assert error.max() < 3


@given(images(pixel_bits=10), detectors(pixel_bits=10, **CENTRAL))
def test_response_is_within_rounding_for_wide_pixels(
    image: NDArray[np.uint16], parameters: Parameters
) -> None:
    error = response_map(image, parameters) - inside(float_model.response_map(image, parameters.algorithm))
    assert error.min() >= -2 - 1e-6  # four times 20 + 6 bits, squared, no longer fit a float64
    assert error.max() < 3 + 1e-6


def offset_bound(samples: NDArray[np.float64]) -> float:
    """How far the nine-point peak moves if samples move by less than SPREAD, up to a constant.

    With gradient g, Hessian H and peak p of the moved surface, H'(p' - p) = -(dg + dH p). Each
    sample is off by 5/2 at most once the constant is taken away, so |dg| <= sqrt(2)·5/2 by its
    coefficients 1/6, |dH| <= 2·5 + 5/2 by theirs, and |p| <= sqrt(1/2) as far as it matters.
    """
    l0, l1, l2 = NINE[:3] @ samples.reshape(9)
    flattest = -(l0 + l1 + np.hypot(l0 - l1, l2))  # the smaller of -H's eigenvalues
    if flattest <= 0:
        return 1.0
    return float((np.sqrt(2) * 2.5 + 12.5 * np.sqrt(0.5)) / flattest)


PLAIN: dict[str, Any] = {
    **CENTRAL,
    "response_filter": "none",
    "texture": "patches",
    "fit": "nine",
}
"""The paper's responses and filter in any profile; the others have tests of their own."""


@dataclass(frozen=True)
class Pair:
    """One photograph through both models, with the same reference Dref."""

    photo: NDArray[np.uint8]
    parameters: Parameters
    responses: NDArray[np.int32]
    exact: NDArray[np.float64]
    dref: int
    golden: Corners
    floating: Corners
    found: NDArray[np.bool_]
    expected: NDArray[np.bool_]
    """Where golden model and reference see a corner: maps of the image's size."""

    def both(self) -> Iterator[tuple[int, int, int, int]]:
        """y and x of common corners, and their indices in ``golden`` and ``floating``."""
        in_golden, in_floating = (
            mask.cumsum().reshape(mask.shape) - 1 for mask in (self.found, self.expected)
        )
        for y, x in np.argwhere(self.found & self.expected).tolist():
            yield y, x, int(in_golden[y, x]), int(in_floating[y, x])


@cache
def both_models(name: str, profile_name: str) -> Pair:
    photo, parameters = photograph(name), Parameters.profile(profile_name, **PLAIN)
    exact = float_model.response_map(photo, parameters.algorithm)
    dref = max(int(np.nanmax(exact)), SETTINGS.floor)
    t1, _ = thresholds(SETTINGS, dref, parameters)
    found = np.zeros(photo.shape, dtype=bool)
    responses = response_map(photo, parameters)
    found[7:-7, 7:-7] = corner_detection(responses[3:-3, 3:-3], t1, parameters.algorithm.ties)
    return Pair(
        photo,
        parameters,
        responses,
        exact,
        dref,
        detect(photo, parameters, SETTINGS, reference=dref),
        reference_detect(photo, parameters, SETTINGS, reference=dref),
        found,
        float_model.corner_map(exact, SETTINGS.sigma1 * dref, parameters.algorithm),
    )


@pytest.fixture(params=product(PHOTOGRAPHS, ["paper", "robust"]), ids="-".join)
def pair(request: pytest.FixtureRequest) -> Pair:
    return both_models(*request.param)


def test_every_disagreement_about_a_corner_is_a_near_tie(pair: Pair) -> None:
    assert pair.found.sum() == len(pair.golden) and pair.expected.sum() == len(pair.floating)
    for y, x in np.argwhere(pair.found != pair.expected):
        value = pair.exact[y, x]
        neighbours = np.delete(pair.exact[y - 1 : y + 2, x - 1 : x + 2].reshape(9), 4)
        to_threshold = abs(value - SETTINGS.sigma1 * pair.dref)
        assert min(abs(value - neighbours.max()), to_threshold) < SPREAD


def test_every_disagreement_about_texture_is_near_the_threshold(pair: Pair) -> None:
    for y, x, g, f in pair.both():
        if pair.golden.accepted[g] != pair.floating.accepted[f]:
            tau = float_model.texturization(pair.exact, x, y, pair.parameters.algorithm.patches)
            # T2 itself is quantised: sigma2 to 2**-17 of at most 2**17, and rounded down
            assert abs(tau - SETTINGS.sigma2 * pair.dref) < 8 * SPREAD + 2


def test_positions_of_common_corners_differ_by_mantissas_and_rounding(pair: Pair) -> None:
    common = list(pair.both())
    # the map of responses begins 3 pixels inside
    patches = np.stack([pair.responses[y - 4 : y - 1, x - 4 : x - 1] for y, x, _, _ in common])
    by_mantissas = bounds(patches, pair.parameters)
    # where the bound says something
    assert np.isfinite(by_mantissas).mean() > 0.95
    for (y, x, g, f), limit in zip(common, by_mantissas, strict=True):
        assert -2 <= pair.golden.response[g] - pair.floating.response[f] < 3
        bound = limit + offset_bound(pair.exact[y - 1 : y + 2, x - 1 : x + 2])
        assert abs(pair.golden.x[g] - pair.floating.x[f]) <= bound
        assert abs(pair.golden.y[g] - pair.floating.y[f]) <= bound


@pytest.mark.parametrize("profile_name", ["paper", "robust"])
def test_nearly_all_corners_of_all_photographs_agree(profile_name: str) -> None:
    pairs = [both_models(name, profile_name) for name in PHOTOGRAPHS]
    common = sum(int((pair.found & pair.expected).sum()) for pair in pairs)
    assert common >= 0.98 * max(
        sum(len(pair.golden) for pair in pairs), sum(len(pair.floating) for pair in pairs)
    )
    errors = [
        max(abs(pair.golden.x[g] - pair.floating.x[f]), abs(pair.golden.y[g] - pair.floating.y[f]))
        for pair in pairs
        for _, _, g, f in pair.both()
    ]
    assert np.median(errors) <= 1 / 128
    assert np.quantile(errors, 0.9) <= 2 / 128


@pytest.mark.parametrize("patches", ["regions", "pixels"])
def test_texturization_is_within_rounding(camera: NDArray[np.uint8], patches: Any) -> None:
    parameters = Parameters.profile("paper", patches=patches)
    exact = float_model.response_map(camera, parameters.algorithm)
    golden_map = response_map(camera, parameters)
    for y, x in np.argwhere(float_model.corner_map(exact, 500.0, ABSOLUTE)).tolist():
        window = golden_map[y - 7 : y + 2, x - 7 : x + 2]
        tau = int(texturization(window, patches)) / parameters.pixels_per_region
        # eight differences of regions, each off by less than the spread
        assert abs(tau - float_model.texturization(exact, x, y, patches)) < 8 * SPREAD


@pytest.mark.parametrize("fit", ["nine", "six"])
@pytest.mark.parametrize("name", ["camera", "text"])
def test_offsets_differ_by_mantissas_alone_on_the_same_responses(name: str, fit: Any) -> None:
    parameters = Parameters.profile("paper", fit=fit)
    responses = response_map(photograph(name), parameters)
    rows, columns = np.nonzero(corner_detection(responses, 100, "strict"))
    patches = np.stack([responses[y : y + 3, x : x + 3] for y, x in zip(rows, columns, strict=True)])
    offset, limits = subpixel(patches, parameters), bounds(patches, parameters) + 1e-6
    scale = {"nine": 12, "six": 2}[fit]
    fitted = np.stack({"nine": fit_nine, "six": fit_six}[fit](patches), axis=-1)
    for k, patch in enumerate(patches.astype(np.float64)):
        coefficients = float_model.surface(patch, fit)
        assert np.allclose(fitted[k], scale * coefficients[:5], rtol=0, atol=1e-6)
        dx, dy, flag = float_model.peak(coefficients)
        if np.isfinite(limits[k]):
            assert bool(flag & 2) == offset.not_maximum[k]
        assert abs(offset.dx[k] / 128 - dx) <= limits[k]
        assert abs(offset.dy[k] / 128 - dy) <= limits[k]
