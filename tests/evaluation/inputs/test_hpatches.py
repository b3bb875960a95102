"""Images at the size at which they are compared, and the homographies that lead there."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.inputs.hpatches import prepared
from evaluation.inputs.sources import STRUCTURE, Pair
from evaluation.methods.matching import known, project


def spot(height: int, width: int, x: float, y: float) -> np.ndarray:
    """A soft round spot about (x, y)."""
    rows, columns = np.indices((height, width))
    return np.rint(220 * np.exp(-((rows - y) ** 2 + (columns - x) ** 2) / 200)).astype(np.uint8)


def centre(image: np.ndarray) -> tuple[float, float]:
    rows, columns = np.indices(image.shape)
    weights = np.where(image > 40, image, 0) / image[image > 40].sum()
    return float((columns * weights).sum()), float((rows * weights).sum())


@pytest.mark.parametrize(
    "shapes", [((480, 640), (700, 500)), ((240, 320), (300, 900)), ((77, 91), (600, 641))]
)
def test_points_go_where_the_homography_says(shapes: tuple[tuple[int, int], tuple[int, int]]) -> None:
    (height, width), (other_height, other_width) = shapes
    places = (width * 0.52, height * 0.45), (other_width * 0.47, other_height * 0.53)
    homography = np.eye(3)
    homography[:2, 2] = np.subtract(places[1], places[0])
    pair = Pair(
        "a", "b", STRUCTURE, spot(height, width, *places[0]), spot(*shapes[1], *places[1]), homography
    )
    (ready,) = prepared([pair])
    assert ready.first.shape == ready.second.shape == (240, 320)
    first, second = (np.array([centre(image)]) for image in (ready.first, ready.second))
    assert project(first, known(ready)) == pytest.approx(second, abs=0.3)


def test_an_image_of_the_size_stays_and_a_shared_one_is_shared() -> None:
    image = np.random.default_rng(0).integers(0, 256, (240, 320), np.uint8)
    pair = Pair("a", "b", STRUCTURE, image, image[::-1].copy(), np.eye(3))
    one, two = prepared([pair, pair])
    assert np.array_equal(one.first, image) and one.first is two.first
    assert np.array_equal(known(one), np.eye(3))
