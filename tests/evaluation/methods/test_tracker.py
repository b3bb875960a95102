"""The tracker finds what moved by a known shift, and nothing else; rho says so."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs.sources import Pair
from evaluation.methods.detectors import MODES, DetectionCache, detectors
from evaluation.methods.tracker import LEAST_CORRELATION, WINDOW, TrackCache, track
from evaluation.sections.robustness import Score, corners_of, farthest, robustness, score, trackable
from tests.support import profiles

HALF = WINDOW // 2
ALL = detectors(profiles.ALL)


@pytest.fixture
def grass() -> NDArray[np.uint8]:
    """Texture everywhere."""
    from skimage import data

    return np.asarray(data.grass())[:140, :170].copy()


def moved(
    image: NDArray[np.uint8], dx: int, dy: int, height: int = 100, width: int = 120
) -> NDArray[np.uint8]:
    return image[20 - dy : 20 - dy + height, 25 - dx : 25 - dx + width]


@pytest.mark.parametrize(("dx", "dy"), [(0, 0), (5, -3), (-8, 8), (-1, 0)])
def test_a_known_shift_is_found(grass: NDArray[np.uint8], dx: int, dy: int) -> None:
    tracks = track(moved(grass, 0, 0), moved(grass, dx, dy), reach=8)
    middle = np.s_[HALF + 8 : -HALF - 8, HALF + 8 : -HALF - 8]
    assert tracks.tracked[middle].all()
    assert (tracks.dx[middle] == dx).all() and (tracks.dy[middle] == dy).all()


def test_what_moves_further_than_the_reach_is_lost(grass: NDArray[np.uint8]) -> None:
    assert track(moved(grass, 0, 0), moved(grass, 15, 0), reach=8).tracked.mean() < 0.02


def test_gain_and_bias_do_not_matter(grass: NDArray[np.uint8]) -> None:
    first = moved(grass, 0, 0)
    darker = np.rint(0.5 * moved(grass, 2, 1).astype(float) + 20).astype(np.uint8)
    tracks = track(first, darker, reach=4)
    middle = np.s_[HALF + 4 : -HALF - 4, HALF + 4 : -HALF - 4]
    assert tracks.tracked[middle].mean() > 0.99 and (tracks.dx[middle] == 2).mean() > 0.99


def test_unrelated_noise_and_flat_images_are_not_tracked() -> None:
    first, second = np.random.default_rng(0).integers(0, 256, (2, 80, 90), np.uint8)
    assert track(first, second, reach=6).tracked.mean() < 0.001
    flat = np.full((80, 90), 100, np.uint8)
    assert not track(flat, flat, reach=6).tracked.any()
    assert not track(flat, second, reach=6).tracked.any()


def test_where_the_patch_would_leave_the_image_nothing_is_tracked(grass: NDArray[np.uint8]) -> None:
    tracked = track(grass, grass, reach=3).tracked
    tracked[HALF:-HALF, HALF:-HALF] = False
    assert not tracked.any()


def test_agrees_with_template_matching(grass: NDArray[np.uint8]) -> None:
    """Point by point, with OpenCV's normalised correlation, forwards."""
    reach = 6
    random = np.random.default_rng(1)
    first = moved(grass, 0, 0)
    second = np.clip(moved(grass, 3, -2) + random.normal(0, 12, first.shape), 0, 255).astype(np.uint8)
    tracks = track(first, second, reach=reach)
    for x, y in random.integers(HALF + reach, (120 - HALF - reach, 100 - HALF - reach), (40, 2)):
        patch = first[y - HALF : y + HALF + 1, x - HALF : x + HALF + 1]
        area = second[y - HALF - reach : y + HALF + reach + 1, x - HALF - reach : x + HALF + reach + 1]
        correlations = cv2.matchTemplate(area, patch, cv2.TM_CCOEFF_NORMED)
        dy, dx = np.unravel_index(correlations.argmax(), correlations.shape)
        assert (tracks.dx[y, x], tracks.dy[y, x]) == (dx - reach, dy - reach)
        assert tracks.correlation[y, x] == pytest.approx(correlations.max(), abs=2e-3)


def test_return_error(grass: NDArray[np.uint8]) -> None:
    """Only one of two places that look alike is another's partner."""
    first = moved(grass, 0, 0).copy()
    first[40:60, 60:80] = first[40:60, 40:60] // 2 + 60 + np.arange(20) % 3
    second = moved(grass, 0, 0)
    tracks = track(first, second, reach=24)
    assert tracks.correlation[50, 70] > LEAST_CORRELATION and tracks.dx[50, 70] == -20
    assert tracks.return_error[50, 70] == 20 and not tracks.tracked[50, 70]
    assert tracks.tracked[50, 50]


def test_score(grass: NDArray[np.uint8]) -> None:
    shifted = np.array([[1, 0, 3], [0, 1, 2], [0, 0, 1.0]])
    pair = Pair("view", "grass", "texture", moved(grass, 0, 0), moved(grass, 3, 2), shifted)
    tracks = track(pair.first, pair.second, reach=4)
    points = np.array([[50.3, 40.1], [60.0, 55.6], [1.0, 1.0]])
    assert score(pair, points, tracks) == Score(3, 2, 2)
    # where the true motion is another, what was tracked is tracked wrongly
    assert score(replace(pair, homography=np.eye(3)), points, tracks) == Score(3, 2, 0)
    unknown = score(replace(pair, homography=None), points, tracks)
    assert (unknown.given, unknown.tracked) == (3, 2) and np.isnan(unknown.right)
    nothing = score(pair, np.empty((0, 2)), tracks)
    assert nothing.given == 0 and np.isnan(nothing.rho)


def test_pairs_out_of_reach_are_left_out(grass: NDArray[np.uint8]) -> None:
    far = np.array([[1, 0, 17], [0, 1, 0], [0, 0, 1.0]])
    near = Pair("near", "s", "g", grass, grass, np.eye(3))
    pairs = [
        near,
        replace(near, homography=far),
        replace(near, homography=None),
        replace(near, second=grass[:50]),
    ]
    assert trackable(pairs) == [pairs[0], pairs[2]]
    assert farthest(pairs[1]) == 17


def test_rho_of_the_same_image_and_of_another(grass: NDArray[np.uint8]) -> None:
    noise = np.random.default_rng(0).integers(0, 256, grass.shape, np.uint8)
    same = Pair("same", "grass", "texture", grass, grass.copy())
    other = Pair("other", "noise", "texture", grass, noise)
    found = robustness([same, other], ALL, TrackCache())
    assert found["pairs"] == 2 and found["left_out"] == 0 and found["videos"] == ["other", "same"]
    equal = found["modes"][MODES[0].name]
    for name, parts in equal.items():
        assert parts["same"]["rho"]["value"] == 1, name
        assert parts["other"]["rho"]["value"] < 0.05, name
        assert parts["same"]["tracked"] == parts["same"]["given"] > 10
    numbers = {parts["same"]["given"] for parts in equal.values()}
    assert len(numbers) == 1, "not as many for each"


def test_as_many_as_paper(grass: NDArray[np.uint8]) -> None:
    pair = Pair("same", "grass", "texture", grass, grass)
    free, same = MODES[1], MODES[2]
    wanted = len(corners_of(pair, ALL, free, DetectionCache())["paper"])
    found = corners_of(pair, ALL, same, DetectionCache())
    fewest = min(len(detector.ranked(grass, same.thresholds)) for detector in ALL)
    assert wanted > 10 and {len(points) for points in found.values()} == {min(wanted, fewest)}


def test_a_pair_is_tracked_once(grass: NDArray[np.uint8]) -> None:
    first, second = grass[:60, :70].copy(), grass[1:61, 2:72].copy()
    cache = TrackCache()
    tracks = cache.tracks(first, second)
    assert cache.tracks(first, second) is tracks and cache.tracks(first, second.copy()) is not tracks
    assert tracks.dx[30, 30] == -2 and tracks.dy[30, 30] == -1
