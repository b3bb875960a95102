"""Rendered corners are at their places, by methods that are independent of rendering."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs import scenes
from evaluation.inputs.scenes import (
    KINDS,
    ORIENTATIONS,
    PAPER_CORNER,
    PAPER_LINES,
    PAPER_SIZE,
    PAPER_SOLIDS,
    SIDE,
    Kind,
    Scene,
    paper_scene,
    scene,
    wide_set,
)

POSITION_ERROR = {"L": 0.02, "saddle": 0.02, "T": 0.05, "X": 0.05}
"""Pixels by which the positions below may be wrong: grey levels are whole numbers, and some edges
have half the contrast.
"""


def edge(profile: NDArray[np.float64]) -> float:
    """Where a line of pixels changes from its first grey to its last: what both areas say."""
    first, last = profile[:3].mean(), profile[-3:].mean()
    return float((profile - last).sum() / (first - last)) - 0.5


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("inverted", [False, True])
def test_upright_edges_cross_at_the_corner(kind: Kind, inverted: bool) -> None:
    each = scene(kind, 0, 90, inverted=inverted, noise=0)
    pixels = each.image.astype(np.float64)
    # below the corner, right of it: far enough for blur
    right = edge(pixels[-6])
    down = edge(pixels[:, -6]) if kind != "T" else edge(pixels[:, 5])
    assert right == pytest.approx(each.x, abs=POSITION_ERROR[kind])
    assert down == pytest.approx(each.y, abs=POSITION_ERROR[kind])


@pytest.mark.parametrize("orientation", ORIENTATIONS)
@pytest.mark.parametrize("opening", [60, 90, 120])
def test_saddles_of_any_orientation_agree_with_an_iterative_method(orientation: int, opening: int) -> None:
    each = scene("saddle", orientation, opening, inverted=False, noise=0)
    start = np.array([[[round(each.x), round(each.y)]]], np.float32)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    x, y = cv2.cornerSubPix(each.image, start, (7, 7), (-1, -1), stop).ravel()
    assert np.hypot(x - each.x, y - each.y) < 0.1


def test_a_wedge_lies_in_its_direction() -> None:
    for orientation in ORIENTATIONS:
        each = scene("L", orientation, 60, inverted=False, noise=0)
        inside = each.x + 8 * np.cos(each.inwards), each.y + 8 * np.sin(each.inwards)
        outside = each.x - 8 * np.cos(each.inwards), each.y - 8 * np.sin(each.inwards)
        bright, dark = (each.image[round(y), round(x)] for x, y in (inside, outside))
        assert int(bright) - int(dark) >= scenes.CONTRASTS[0] - 2


@pytest.mark.parametrize("kind", KINDS)
def test_noise_is_as_strong_as_it_is_said_to_be(kind: Kind) -> None:
    values = [scene(kind, 0, 90, inverted=False, noise=6).image[2:8, 2:8] for _ in range(1)]
    assert 4 < np.std(values) < 8
    assert np.std(scene(kind, 0, 90, inverted=False, noise=0).image[2:8, 2:8]) < 1


def test_a_scene_depends_on_nothing_but_what_it_is() -> None:
    arguments = {"orientation": 45, "opening": 60, "inverted": True, "noise": 3.0}
    first, second = scene("T", **arguments), scene("T", **arguments)
    assert np.array_equal(first.image, second.image) and (first.x, first.y) == (second.x, second.y)
    other = scene("T", **arguments | {"orientation": 60})
    assert (other.x, other.y) != (first.x, first.y)


def test_the_wide_set_has_every_angle_both_polarities_and_all_noises() -> None:
    found = wide_set("saddle")
    assert len(found) == 24 * 3 * 2 * 3
    assert {each.noise for each in found} == set(scenes.NOISES)
    offsets = np.array([(each.x - SIDE // 2, each.y - SIDE // 2) for each in found])
    assert np.abs(offsets).max() <= 0.5
    # anywhere within the pixel, alike: the standard deviation of that is 0.289
    assert np.allclose(offsets.mean(0), 0, atol=0.05) and np.allclose(offsets.std(0), 0.289, atol=0.03)
    assert len(wide_set("saddle", quick=True)) == 24 * 2


@pytest.mark.parametrize("degrees", PAPER_SOLIDS)
def test_solid_corners_of_the_paper(degrees: int) -> None:
    each = paper_scene(degrees, solid=True)
    assert each.image.shape == PAPER_SIZE[::-1]
    assert (each.x, each.y) == PAPER_CORNER
    black = 1 - each.image.astype(np.float64) / 255
    # the lower edge: how much of a column far to the right lies above it, and below the upper edge
    column = 100
    height = black[:, column].sum()
    expected = min((column - each.x) * np.tan(np.deg2rad(degrees)), each.y + 0.5)
    assert height == pytest.approx(expected, abs=0.5)
    assert edge(each.image[:, column][100:].astype(np.float64)) + 100 == pytest.approx(each.y, abs=0.25)
    if degrees == 90:
        assert edge(each.image[60].astype(np.float64)) == pytest.approx(each.x, abs=0.1)


def _turned_right(each: Scene) -> float:
    darkness = 255 - each.image.astype(np.float64)
    return float(darkness[:, : int(each.x) - 4].sum() / darkness.sum())


@pytest.mark.parametrize("degrees", PAPER_LINES)
def test_lines_of_the_paper_begin_at_the_corner(degrees: int) -> None:
    each = paper_scene(degrees, solid=False)
    darkness = 255 - each.image.astype(np.float64)
    rows = np.arange(len(darkness))
    centre = (darkness[:, 100][120:] * rows[120:]).sum() / darkness[:, 100][120:].sum()
    assert centre == pytest.approx(each.y, abs=0.25)
    assert _turned_right(each) < 0.05, "there is something left of the corner"


def test_the_other_reading_is_a_right_angle() -> None:
    upright = paper_scene(0, solid=False, reading="rotation").image
    assert upright[60, 15:19].min() < 160 and upright[126:131, 100].min() < 160
