"""Depth from exact points is exact; wrong partners are told from small errors."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.inputs.rooms import INNER, room
from evaluation.methods.detectors import USUAL, Ours
from evaluation.sections.reconstruction import Cloud, off_line, reconstruct, summary, tables
from golden import Parameters


def partners(first: np.ndarray) -> np.ndarray:
    """Where points of the first view of room 0 are in the second, at their true depths."""
    scene = room(0)
    directions = np.column_stack([first, np.ones(len(first))]) @ np.linalg.inv(INNER).T
    points = directions * scene.depths(first, 8)[:, None]
    seen = np.column_stack([points, np.ones(len(points))]) @ scene.cameras[1].T
    return seen[:, :2] / seen[:, 2:]


@pytest.fixture
def corners() -> np.ndarray:
    found = Ours("robust", Parameters.profile("robust")).ranked(room(0).first, USUAL)[:400]
    return found[np.isfinite(room(0).depths(found, 8))]


def test_exact_partners_give_the_exact_depth(corners: np.ndarray) -> None:
    scene, second = room(0), partners(corners)
    assert off_line(scene, corners, second).max() < 1e-6
    assert off_line(scene, corners, second + np.array([0, 1.5])) == pytest.approx(1.5, abs=0.2)
    inside = (second > 0).all(axis=1) & (second < (640, 480)).all(axis=1)
    cloud = reconstruct(scene, corners, second[inside])
    assert len(cloud.points) > 60 and np.percentile(np.abs(cloud.errors), 90) < 1e-4


def test_partners_off_their_line_are_left_out(corners: np.ndarray) -> None:
    scene, second = room(0), partners(corners)
    moved = second + np.where(np.arange(len(second)) % 2, 0.0, 2.6)[:, None] * (0, 1)
    cloud = reconstruct(scene, corners, moved)
    assert 10 < len(cloud.points) < len(reconstruct(scene, corners, second).points) - 10
    assert np.percentile(np.abs(cloud.errors), 80) < 2


def test_without_corners() -> None:
    none = np.empty((0, 2))
    cloud = reconstruct(room(0), none, none)
    assert cloud.points.shape == (0, 3) and len(cloud.errors) == 0
    assert summary([cloud])["median"]["value"] is None


def test_wrong_points_are_counted_and_do_not_count() -> None:
    depths = np.full(4, 2.0)
    points = np.column_stack([np.zeros((4, 2)), 2 * np.array([1.01, 0.98, 1.03, 1.5])])
    found = summary([Cloud(np.zeros((4, 2)), points, depths)])
    assert found["points"] == 4 and found["wrong"]["value"] == 25
    assert found["median"]["value"] == pytest.approx(2)
    (row,) = tables({"detectors": {"robust": found}})["depth"].rows
    assert list(row) == ["robust", "4", "2.00", "2.90", "25.0"]
