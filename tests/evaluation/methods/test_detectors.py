"""Every detector answers the same questions the same way."""

from __future__ import annotations

import itertools
from typing import get_args

import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.methods.detectors import (
    MARGIN,
    MODES,
    PAPER,
    USUAL,
    WITHOUT,
    Chance,
    DetectionCache,
    Detector,
    Mode,
    Ours,
    budget,
    detectors,
    modes_of,
)
from golden import PROFILES, Corners, Parameters, Settings, detect
from golden.algorithm import Algorithm, Fit, PixelFilter, ResponseFilter, Texture
from tests.support import profiles

ALL = detectors(profiles.ALL)


def test_names_differ() -> None:
    names = [detector.name for detector in ALL]
    assert len(set(names)) == len(names)
    for name, algorithm in PROFILES.items():
        assert name in names and (name + WITHOUT in names) == (algorithm.texture != "none")


@pytest.mark.parametrize("detector", ALL, ids=lambda detector: detector.name)
def test_corners_are_inside_and_of_no_number(detector: Detector, camera: NDArray[np.uint8]) -> None:
    for points in (detector.ranked(camera, USUAL), detector.at(camera, USUAL)):
        assert points.ndim == 2 and points.shape[1] == 2 and len(points) > 20
        # a refined position may leave the pixel
        assert points.min() > MARGIN - 4 and points.max() < 512 - MARGIN + 3
    assert len(detector.ranked(camera, USUAL)) >= len(detector.at(camera, USUAL))


@pytest.mark.parametrize("detector", [each for each in ALL if not isinstance(each, Chance)])
def test_nothing_in_a_flat_image(detector: Detector) -> None:
    flat = np.full((60, 80), 120, np.uint8)
    assert detector.ranked(flat, USUAL).shape == detector.at(flat, USUAL).shape == (0, 2)


@pytest.mark.parametrize("name", PROFILES)
def test_the_strongest_are_those_that_a_higher_threshold_leaves(name: str, camera: NDArray[np.uint8]) -> None:
    """In the hardware one raises sigma1 until so many are left; here one cuts the ranking."""
    detector = Ours(name, Parameters.profile(name))
    settings = Settings.default(detector.parameters, sigma1=0.12, sigma2=USUAL.sigma2)
    left = counting(detect(camera, detector.parameters, settings), camera)
    ranked = detector.ranked(camera, USUAL)[: len(left)]
    assert len(left) > 20
    assert {tuple(point) for point in ranked} == left


def counting(corners: Corners, image: NDArray[np.uint8]) -> set[tuple[float, float]]:
    """Positions that are no nearer to an edge than any algorithm's corners."""
    height, width = image.shape
    return {
        (x, y)
        for x, y in zip(corners.x, corners.y, strict=True)
        if MARGIN <= x <= width - 1 - MARGIN and MARGIN <= y <= height - 1 - MARGIN
    }


def test_no_algorithm_has_a_wider_margin() -> None:
    kinds = itertools.product(*(get_args(kind) for kind in (PixelFilter, ResponseFilter, Texture, Fit)))
    names = ("pixel_filter", "response_filter", "texture", "fit")
    assert MARGIN == max(Algorithm(**dict(zip(names, each, strict=True))).margin for each in kinds)


def test_a_number_that_a_mode_gives() -> None:
    image = np.zeros((480, 640), np.uint8)
    assert Mode("some", USUAL, equal=True, number=100).wanted(image) == 100
    assert Mode("some", USUAL, equal=True, pixels_per_corner=300).wanted(image) == 1024


@pytest.mark.parametrize("name", [name for name, each in PROFILES.items() if each.texture != "none"])
def test_without_filter_nothing_is_rejected(name: str, camera: NDArray[np.uint8]) -> None:
    parameters = Parameters.profile(name)
    plain = Ours(name, parameters, filtered=False).at(camera, USUAL)
    everything = detect(camera, parameters, Settings(sigma1=USUAL.sigma1, report_rejected=True))
    assert len(plain) == len(counting(everything, camera))
    assert len(plain) > len(Ours(name, parameters).at(camera, USUAL))


def test_chance_is_not_the_same_in_two_views(camera: NDArray[np.uint8]) -> None:
    chance = Chance()
    first, again = chance.ranked(camera, USUAL), chance.ranked(camera, PAPER)
    assert np.array_equal(first, again)
    assert not np.array_equal(first, chance.ranked(camera[::-1].copy(), USUAL))


def test_cache_asks_once(camera: NDArray[np.uint8]) -> None:
    class Counting(Chance):
        asked = 0

        def ranked(self, image: NDArray[np.uint8], thresholds: object) -> NDArray[np.float64]:
            Counting.asked += 1
            return np.empty((0, 2))

    memory, detector = DetectionCache(), Counting()
    for _ in range(3):
        memory.corners(detector, camera, USUAL, True)
    assert Counting.asked == 1
    memory.corners(detector, camera.copy(), USUAL, True)
    memory.corners(detector, camera, PAPER, True)
    assert Counting.asked == 3


def test_modes() -> None:
    assert MODES[0].equal and MODES[0].like is None
    assert all(mode.equal for mode in MODES if mode.like)
    assert len({mode.name for mode in MODES}) == len(MODES)
    assert budget(np.zeros((480, 640), np.uint8)) == 512
    assert budget(np.zeros((15, 15), np.uint8)) == 10


def test_modes_need_the_detector_whose_numbers_they_take() -> None:
    alone = detectors({"robust": Parameters.profile("robust")})
    assert modes_of(alone) == [mode for mode in MODES if mode.like is None]
    assert modes_of(ALL) == list(MODES) and any(mode.like for mode in MODES)
