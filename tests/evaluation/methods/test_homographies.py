"""Homographies from matched corners, on points whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs.sources import STRUCTURE, NamedImage, Pair
from evaluation.inputs.views import VIEWS, rendered_pairs
from evaluation.methods.detectors import USUAL, Ours
from evaluation.methods.homographies import (
    FAILED,
    correspondences,
    grid_error,
    homography,
    matched_error,
)
from evaluation.methods.matching import known, project
from golden import Parameters

TURNED = np.array([[0.99, -0.1, 12], [0.1, 0.99, -7], [1e-5, -2e-5, 1]])


@pytest.fixture
def pair(camera: NDArray[np.uint8]) -> Pair:
    named = NamedImage("camera", camera[100:330, 150:450], STRUCTURE)
    return rendered_pairs([named], VIEWS[1:2])[0]


def test_homography_of_points_and_some_wrong_partners() -> None:
    random = np.random.default_rng(0)
    first = random.uniform(0, 300, (60, 2))
    second = project(first, TURNED)
    second[:20] += random.uniform(20, 60, (20, 2))
    found = homography(first, second)
    assert found is not None
    assert found / found[2, 2] == pytest.approx(TURNED, abs=1e-4)
    assert homography(first[:3], second[:3]) is None


def test_grid_error(pair: Pair) -> None:
    assert grid_error(pair, known(pair)) < 1e-9
    shifted = np.array([[1, 0, 0.3], [0, 1, -0.4], [0, 0, 1]]) @ known(pair)
    assert grid_error(pair, shifted) == pytest.approx(0.5)
    assert grid_error(pair, np.diag([1, 1, 1e-3])) == grid_error(pair, None) == FAILED


def test_partners_are_the_same_corners(pair: Pair) -> None:
    robust = Ours("robust", Parameters.profile("robust"))
    first, second = (robust.ranked(image, USUAL)[:100] for image in (pair.first, pair.second))
    partners = correspondences(pair, first, second)
    distances = np.hypot(*(project(first[partners[:, 0]], known(pair)) - second[partners[:, 1]]).T)
    assert len(partners) > 40 and np.mean(distances < 1.5) > 0.9
    assert all(len(set(column)) == len(partners) for column in partners.T)
    assert matched_error(pair, first, second) < 0.5


def test_without_corners_or_anything_to_see(pair: Pair) -> None:
    none, some = np.empty((0, 2)), np.array([(20.0, 20.0), (40.0, 30.0)])
    assert correspondences(pair, none, some).shape == (0, 2)
    blank = replace(pair, first=np.full_like(pair.first, 100))
    assert len(correspondences(blank, some, some)) == 0
    assert matched_error(pair, some, none) == FAILED
