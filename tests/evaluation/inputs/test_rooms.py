"""Rendered rooms: what both cameras see at the true depth is the same."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.inputs import rooms
from evaluation.inputs.packages import opencv
from evaluation.inputs.rooms import INNER, Plane, Room, room


def lifted(scene: Room, pixels: np.ndarray) -> np.ndarray:
    """(n, 4) homogeneous points at the true depth of pixels (n, 2) of the first view."""
    depths = scene.depths(pixels, 0)
    directions = np.column_stack([pixels, np.ones(len(pixels))]) @ np.linalg.inv(INNER).T
    return np.column_stack([directions * depths[:, None], np.ones(len(pixels))])


def test_depth_of_a_plane_by_hand() -> None:
    plane = Plane(
        np.array([-1.0, -1, 4]), np.array([2.0, 0, 2]), np.array([0.0, 2, 0]), np.zeros((2, 2), np.uint8)
    )
    # the ray along the axis meets the middle, at z = 5; the others meet the left end, or nothing
    rays = np.array([(0, 0, 1), (-0.25, 0, 1), (-0.3, 0, 1), (0, 0.3, 1), (-1, 0, -1)], np.float64)
    assert plane.depths(rays).tolist() == pytest.approx([5, 4, np.inf, np.inf, np.inf])


@pytest.mark.parametrize("number", [0, 3])
def test_both_views_agree_at_the_true_depth(number: int) -> None:
    scene = room(number)
    x, y = np.meshgrid(np.arange(30, 610, 3.0), np.arange(30, 450, 3.0))
    pixels = np.column_stack([x.ravel(), y.ravel()])
    there = np.isfinite(scene.depths(pixels, 8))
    pixels = pixels[there]
    assert 0.4 < there.mean() < 0.95
    ahead, across = (lifted(scene, pixels) @ camera.T for camera in scene.cameras)
    assert ahead[:, :2] / ahead[:, 2:] == pytest.approx(pixels)
    seen = (across[:, :2] / across[:, 2:]).astype(np.float32)
    other = opencv().remap(scene.second.astype(np.float32), seen[None], None, 1)[0]
    # a panel may hide in one view what the other one shows
    shown = (seen > 5).all(axis=1) & (seen[:, 0] < 634) & (seen[:, 1] < 474)
    one = scene.first[pixels[:, 1].astype(int), pixels[:, 0].astype(int)][shown] * 0.85
    errors = np.abs(one - other[shown])
    assert np.median(errors) < 3 and np.corrcoef(one, other[shown])[0, 1] > 0.9


def test_places_where_planes_end_have_no_depth() -> None:
    scene = room(0)
    panel = scene.planes[-1]
    corner = INNER @ panel.origin
    beside = (corner[:2] / corner[2] + (2.0, 3.0))[None]
    assert scene.depths(beside, 0) == pytest.approx(panel.origin[2], abs=0.05)
    assert np.isnan(scene.depths(beside, 8)).all()


def test_rooms_differ_and_stay_the_same() -> None:
    assert np.array_equal(room(0).first, rooms.room.__wrapped__(0).first)
    assert not np.array_equal(room(0).first, room(3).first)
    assert [each.name for each in rooms.rooms(quick=True)] == ["room 0"]
