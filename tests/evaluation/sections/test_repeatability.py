"""Repeatability of pairs whose repeatability is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs.sources import Pair
from evaluation.methods.detectors import MODES, WITHOUT, DetectionCache, detectors
from evaluation.methods.grouping import by_scene
from evaluation.methods.matching import inside, match, project
from evaluation.sections.repeatability import (
    Score,
    Visible,
    by_fit,
    corners_of,
    mode_figures,
    repeatability,
    scores,
)
from tests.support import profiles

ALL = detectors(profiles.ALL)
EQUAL = MODES[0]
SHIFT = np.array([[1, 0, -20], [0, 1, -12], [0, 0, 1.0]])


def pair(first: NDArray[np.uint8], second: NDArray[np.uint8], homography: NDArray[np.float64]) -> Pair:
    return Pair("a view", "a scene", "a class", first, second, homography)


def test_identical_images(camera: NDArray[np.uint8]) -> None:
    same = pair(camera, camera.copy(), np.eye(3))
    for name, (score,) in scores([same], ALL[:-1], EQUAL, DetectionCache()).items():
        assert score.first == score.second > 100, name
        assert score.repeatability == 1 and score.distance == 0


def test_a_shift_by_whole_pixels_loses_nothing_that_both_can_show(camera: NDArray[np.uint8]) -> None:
    """The crop has the image's largest D, so thresholds are equal; positions follow exactly."""
    shifted = pair(camera[:300, :300], camera[12:312, 20:320], SHIFT)
    ours = [each for each in ALL if each.name == "paper" + WITHOUT]
    (score,) = scores([shifted], ours, EQUAL, DetectionCache())["paper" + WITHOUT]
    assert score.repeatability > 0.97 and score.distance < 1e-6


def test_unrelated_noise_is_near_chance() -> None:
    random = np.random.default_rng(0)
    first, second = random.integers(0, 256, (2, 300, 300), np.uint8)
    found = scores([pair(first, second, np.eye(3))], ALL, EQUAL, DetectionCache())
    for name, (score,) in found.items():
        # a corner for every 600 pixels: a disc of 1.5 pixels holds 0.012 of them
        assert score.repeatability < 0.06, name


def test_numbers_are_equal(camera: NDArray[np.uint8]) -> None:
    shifted = pair(camera[:300, :300], camera[12:312, 20:320], SHIFT)
    for mode in (each for each in MODES if each.equal):
        both = corners_of(Visible(shifted, DetectionCache()), ALL, mode)
        for view in (0, 1):
            assert len({len(points[view]) for points in both.values()}) == 1


def test_numbers_are_those_of_the_detector_that_finds_fewest(camera: NDArray[np.uint8]) -> None:
    empty = pair(camera, np.full_like(camera, 7), np.eye(3))
    found = scores([empty], ALL, EQUAL, DetectionCache())
    for (score,) in found.values():
        assert score.second == 0 and np.isnan(score.repeatability)
    figures = mode_figures([empty], found, views=True)["paper"]
    assert figures["all"]["repeatability"]["value"] is None and figures["views"] == {"a view": None}


def test_match_is_mutual_and_within_the_tolerance() -> None:
    first = np.array([[10.0, 10], [11.0, 10], [50, 50], [90, 90]])
    second = np.array([[10.2, 10.0], [52.0, 50.0], [90.0, 91.4]])
    pairs, distances = match(first, second, tolerance=1.5)
    # (11, 10) has the same nearest neighbour, which has another; (50, 50) is 2 away
    assert pairs.tolist() == [[0, 0], [3, 2]]
    assert distances == pytest.approx([0.2, 1.4])
    nothing = match(first, np.empty((0, 2)))
    assert len(nothing[0]) == len(nothing[1]) == 0


def test_match_agrees_with_a_search_through_all_pairs() -> None:
    random = np.random.default_rng(1)
    first, second = random.uniform(0, 60, (150, 2)), random.uniform(0, 60, (140, 2))
    all_distances = np.linalg.norm(first[:, None] - second[None], axis=2)
    expected = {
        (row, column)
        for row, column in np.ndindex(all_distances.shape)
        if all_distances[row, column] <= 1.5
        and all_distances[row].argmin() == column
        and all_distances[:, column].argmin() == row
    }
    assert {tuple(indices) for indices in match(first, second)[0].tolist()} == expected


def test_projection() -> None:
    homography = np.array([[1.1, 0.1, 3], [-0.2, 0.9, 5], [1e-3, -2e-3, 1]])
    (point,) = project(np.array([[10.0, 20.0]]), homography)
    weight = 1 + 0.01 - 0.04
    assert point == pytest.approx([(11 + 2 + 3) / weight, (-2 + 18 + 5) / weight])
    assert project(project(np.array([[10.0, 20.0]]), homography), np.linalg.inv(homography)) == pytest.approx(
        np.array([[10, 20]])
    )


def test_inside_keeps_the_support() -> None:
    image = np.zeros((40, 50), np.uint8)
    points = np.array([[9, 9], [8.9, 20], [40, 30], [40.1, 20], [20, 30.1]], dtype=float)
    assert inside(points, image).tolist() == [True, False, True, False, False]


def test_pairs_of_one_scene_are_one_group(camera: NDArray[np.uint8]) -> None:
    one = pair(camera, camera, np.eye(3))
    pairs = [one, replace(one, scene="other"), one]
    groups = by_scene(pairs, [(1.0,), (2.0,), (float("nan"),)])
    assert [group.tolist() for group in groups] == [[[1.0]], [[2.0]]]
    assert Score(0, 5, 0, float("nan")).repeatability != Score(0, 5, 0, float("nan")).repeatability


def test_study(camera: NDArray[np.uint8]) -> None:
    crop = camera[100:260, 150:330]
    pairs = [
        pair(crop, crop, np.eye(3)),
        replace(pair(crop, crop, np.eye(3)), scene="2", group="other class"),
    ]
    steps: list[int] = []
    found = repeatability(pairs, ALL, quick=True, notify=steps.append)
    assert steps == list(range(1, len(MODES) + 1))
    assert list(found["modes"]) == [mode.name for mode in MODES]
    assert list(found["fits"]) == [detector.name for detector in by_fit()]
    equal = found["modes"][EQUAL.name]
    assert equal["robust"]["all"]["repeatability"] == {"value": 1, "interval": [1, 1]}
    assert equal["paper"]["all"]["gain"]["paper" + WITHOUT]["value"] == 0
    assert set(equal["FAST"]) == {"all", "a class", "other class", "views"}
