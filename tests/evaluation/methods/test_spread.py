"""Detectors whose corners are spread over the image."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs.packages import opencv
from evaluation.methods.detectors import USUAL, Detector, Fast, GoodFeaturesToTrack
from evaluation.methods.spread import FastByGrid, in_turns


def test_in_turns() -> None:
    points = np.array([(0, 0), (1, 1), (30, 0), (2, 2), (29.4, 29.4), (29.5, 0), (0, 65)], np.float64)
    assert in_turns(points, 30).tolist() == points[[0, 2, 6, 1, 5, 3, 4]].tolist()
    assert in_turns(points, 1000).tolist() == points.tolist()
    assert in_turns(np.empty((0, 2)), 30).shape == (0, 2)


def test_points_of_a_distance(camera: NDArray[np.uint8]) -> None:
    spread, dense = GoodFeaturesToTrack(10), GoodFeaturesToTrack()
    assert spread.name == "goodFeaturesToTrack, 10 px apart" and dense.name == "goodFeaturesToTrack"
    points = spread.ranked(camera, USUAL)
    apart = np.hypot(*(points[:, None] - points).transpose(2, 0, 1))
    np.fill_diagonal(apart, np.inf)
    assert apart.min() >= 10
    everything = {tuple(point) for point in dense.ranked(camera, USUAL)}
    assert {tuple(point) for point in points} < everything


def found_in_squares(squares: dict[tuple[int, int], int]) -> list[int]:
    """Corners of squares of 6 px, of these greys on 100, found by the grid."""
    image = np.full((120, 120), 100, np.uint8)
    for (x, y), grey in squares.items():
        image[y : y + 6, x : x + 6] = grey
    # without blur neighbours score alike, and suppress each other
    found = FastByGrid().ranked(opencv().GaussianBlur(image, (0, 0), 0.6), USUAL)
    return [int((np.abs(found - np.array(place) - 2.5).max(axis=1) < 5).sum()) for place in squares]


def test_low_threshold_counts_where_a_cell_has_nothing_else() -> None:
    squares = {(20, 20): 200, (42, 20): 112, (50, 80): 112, (80, 80): 104}
    assert found_in_squares(squares) == [4, 4, 4, 0]
    assert found_in_squares(squares | {(32, 50): 200, (42, 42): 112}) == [4, 4, 4, 0, 4, 0]


@pytest.mark.parametrize("detector", [FastByGrid(), GoodFeaturesToTrack(10)], ids=lambda each: each.name)
def test_a_flat_image_has_none(detector: Detector) -> None:
    assert detector.ranked(np.full((60, 80), 120, np.uint8), USUAL).shape == (0, 2)


def test_the_first_of_the_grid_are_spread(camera: NDArray[np.uint8]) -> None:
    def cells(points: NDArray[np.float64]) -> int:
        return len({tuple(cell) for cell in points // 30})

    spread, strongest = FastByGrid().ranked(camera, USUAL)[:150], Fast().ranked(camera, USUAL)[:150]
    assert cells(spread) == 150 > 1.5 * cells(strongest)
