"""Smoothed pixels by hand, and that every block sees them: the detector is that of other pixels."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden import Parameters, Settings, detect
from golden.algorithm import PixelFilter
from golden.frame import response_map
from golden.pixel_filter import pixel_filter
from tests.support.strategies import Image, detectors, images

PASSES: dict[PixelFilter, int] = {"none": 0, "binomial": 1, "twice": 2}
EVERYTHING = Settings(sigma1=0.0, sigma2=0.2, floor=1, reference="constant", report_rejected=True)


def test_one_pixel_spreads() -> None:
    frame = np.zeros((5, 5), np.uint8)
    frame[2, 2] = 160
    assert pixel_filter(frame, 1).tolist() == [[10, 20, 10], [20, 40, 20], [10, 20, 10]]


def test_each_pass_is_rounded() -> None:
    """A pixel of 40 is 2.5, 5 and 10 in the first sums; not rounded, 40 · 36/256 would be 5.6."""
    frame = np.zeros((7, 7), np.uint8)
    frame[3, 3] = 40
    assert pixel_filter(frame, 1)[1:4, 1:4].tolist() == [[3, 5, 3], [5, 10, 5], [3, 5, 3]]
    assert pixel_filter(frame, 2)[1, 1] == (4 * 3 + 2 * 4 * 5 + 4 * 10 + 8) // 16 == 6


def test_rounds_to_nearest_halves_up() -> None:
    for value, rounded in ((0, 0), (7, 0), (8, 1), (23, 1), (24, 2)):
        frame = np.zeros((3, 3), np.uint8)
        frame[0, 0] = value
        assert pixel_filter(frame, 1).item() == rounded


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 15, 255, 1023]))
def test_is_the_rounded_mean_by_loops_and_no_larger(seed: int, top: int) -> None:
    dtype = np.uint8 if top < 256 else np.uint16
    frame = np.random.default_rng(seed).integers(0, top, (3, 3), dtype, endpoint=True)
    weights = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]])
    filtered = pixel_filter(frame, 1)
    assert filtered.item() == int(np.floor((weights * frame).sum() / 16 + 0.5))
    assert filtered.dtype == dtype and frame.min() <= filtered.item() <= frame.max()
    assert pixel_filter(np.full((3, 3), top, dtype), 1).item() == top


SURFACES = detectors(pixel_filter="none", fit="nine") | detectors(pixel_filter="none", fit="six")


@given(images(), st.sampled_from(sorted(PASSES)), SURFACES)
def test_all_but_gradient_steps_see_smoothed_pixels(
    image: Image, name: PixelFilter, parameters: Parameters
) -> None:
    """So the corners are those of the smoothed image, which is smaller by a pixel at each edge."""
    passes, chosen = PASSES[name], parameters.changed(pixel_filter=name)
    smoothed = np.ascontiguousarray(pixel_filter(image, passes))
    assert smoothed.shape == tuple(side - 2 * passes for side in image.shape)
    assert np.array_equal(response_map(image, chosen), response_map(smoothed, parameters))
    corners, same = detect(image, chosen, EVERYTHING), detect(smoothed, parameters, EVERYTHING)
    assert np.array_equal(corners.x, same.x + passes) and np.array_equal(corners.y, same.y + passes)
    assert np.array_equal(corners.response, same.response) and np.array_equal(corners.flags, same.flags)


@pytest.mark.parametrize(
    ("changes", "window", "margin"),
    [
        ({}, 9, 7),
        ({"pixel_filter": "binomial"}, 9, 8),
        ({"pixel_filter": "twice"}, 9, 9),
        ({"texture": "mean", "suppression": 4}, 9, 7),
        ({"texture": "none"}, 3, 4),
        ({"texture": "none", "pixel_filter": "binomial"}, 3, 5),
        ({"texture": "none", "pixel_filter": "twice", "response_filter": "binomial"}, 5, 7),
        ({"texture": "none", "suppression": 4}, 9, 7),
        ({"texture": "none", "suppression": 2}, 5, 5),
        ({"texture": "none", "fit": "gradient"}, 9, 7),
    ],
    ids=str,
)
def test_margin_is_what_is_read_around_a_corner(changes: dict[str, object], window: int, margin: int) -> None:
    algorithm = Parameters.profile("paper", **changes).algorithm
    assert (algorithm.window_size, algorithm.margin, algorithm.support) == (window, margin, 2 * margin + 1)


def test_without_texture_filter_every_peak_is_a_corner_and_sigma2_changes_nothing() -> None:
    image = np.random.default_rng(3).integers(0, 256, (60, 60), np.uint8)
    without = Parameters.profile("paper", texture="none")
    few, many = (detect(image, without, Settings(sigma2=sigma2)) for sigma2 in (0.0, 15.9))
    assert few == many and few.accepted.all()
    filtered = detect(image, Parameters.profile("paper"), Settings(sigma2=15.9))
    inner = few[(np.abs(few.x - 29.5) < 21.5) & (np.abs(few.y - 29.5) < 21.5)]
    assert set(zip(inner.x, inner.y, strict=True)) <= set(zip(filtered.x, filtered.y, strict=True))
    assert len(few) > len(filtered) > 50
