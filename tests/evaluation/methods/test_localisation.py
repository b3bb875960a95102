"""All methods place the same corners, and begin where the response has its maxima."""

from __future__ import annotations

from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs.scenes import scene
from evaluation.methods.localisation import INTEGER, OPENCV, corner_sub_pix, methods, place, whole_pixels
from golden import PROFILES, Parameters, Settings, detect
from golden.algorithm import Fit
from golden.frame import response_map

SETTINGS = Settings(sigma1=0.02)


@pytest.mark.parametrize("profile", PROFILES)
def test_every_corner_by_every_method(profile: str, camera: NDArray[np.uint8]) -> None:
    parameters = Parameters.profile(profile)
    found = place(camera[:200, :200], parameters, SETTINGS)
    assert set(found.positions) == set(methods(parameters)) == {INTEGER, OPENCV, *get_args(Fit)}
    own = detect(camera[:200, :200], parameters, Settings(sigma1=0.02, report_rejected=True))
    # a method that reads pixels cannot place all of them
    pixels = whole_pixels(camera[:200, :200], parameters, SETTINGS)
    margin = parameters.changed(fit="gradient").algorithm.margin
    inside = ((pixels >= margin) & (pixels < 200 - margin)).all(axis=1)
    assert inside.sum() > 30 and np.array_equal(found.positions[INTEGER], pixels[inside])
    places = np.column_stack([own.x, own.y])[inside]
    assert np.array_equal(found.positions[parameters.algorithm.fit], places)
    assert np.array_equal(found.accepted, own.accepted[inside])


@pytest.mark.parametrize("profile", PROFILES)
def test_a_mark_where_no_corner_can_be_changes_nothing(profile: str, camera: NDArray[np.uint8]) -> None:
    """Whole pixels have the thresholds of the records beside them."""
    plain = camera[100:300, 200:400].copy()
    marked = plain.copy()
    plain[:9, :9] = 0
    marked[:9, :9] = 0
    marked[:3, :3] = 255
    found, same = (place(image, Parameters.profile(profile), SETTINGS) for image in (marked, plain))
    assert len(found.accepted) > 40
    assert all(np.array_equal(found.positions[name], same.positions[name]) for name in same.positions)


def test_whole_pixels_are_local_maxima(camera: NDArray[np.uint8]) -> None:
    """A plain search: the largest of nine, in raster order, at most half a pixel from the fit."""
    parameters = Parameters.profile("paper")
    found = place(camera, parameters, SETTINGS)
    pixels = found.positions[INTEGER]
    assert np.array_equal(pixels, np.rint(pixels))
    responses = response_map(camera, parameters)
    for x, y in pixels.astype(int) - parameters.algorithm.response_margin:
        patch = responses[y - 1 : y + 2, x - 1 : x + 2].copy()
        centre, patch[1, 1] = patch[1, 1], -1
        assert centre > patch.max()
    assert np.abs(found.positions["nine"] - pixels).max() <= 0.5
    order = pixels[:, 1] * 1000 + pixels[:, 0]
    assert (np.diff(order) > 0).all(), "a pixel is wrong, or there twice"


def test_nearest() -> None:
    each = scene("saddle", 0, 90, inverted=False, noise=0)
    found = place(each.image, Parameters.profile("robust"), SETTINGS)
    corner = found.nearest(each.x, each.y, 4)
    assert corner is not None
    assert found.nearest(each.x + 30, each.y, 4) is None
    flat = place(np.full((40, 40), 9, np.uint8), Parameters.profile("robust"), SETTINGS)
    assert flat.nearest(20, 20, 100) is None
    assert all(positions.shape == (0, 2) for positions in flat.positions.values())


def test_opencv_finds_a_saddle_from_a_pixel_beside_it() -> None:
    each = scene("saddle", 30, 90, inverted=False, noise=0)
    start = np.array([[round(each.x) + 1, round(each.y) - 1]])
    assert corner_sub_pix(each.image, start) == pytest.approx(np.array([[each.x, each.y]]), abs=0.1)
