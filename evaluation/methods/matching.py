"""Points of one view in another: where a homography takes them, and which are the same."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from evaluation.inputs.sources import Pair
from evaluation.methods.bootstrap import Values
from evaluation.methods.detectors import MARGIN, Points

TOLERANCE = 1.5
"""Pixels of the second view."""


def project(points: Points, homography: NDArray[np.floating[Any]]) -> Points:
    """(n, 2) points through a homography."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return mapped[:, :2] / mapped[:, 2:]


def inside(points: Points, image: NDArray[np.uint8], margin: float = MARGIN) -> NDArray[np.bool_]:
    """Which points have so many pixels around them in the image."""
    height, width = image.shape
    x, y = points.T
    return (x >= margin) & (y >= margin) & (x <= width - 1 - margin) & (y <= height - 1 - margin)


def match(first: Points, second: Points, tolerance: float = TOLERANCE) -> tuple[NDArray[np.intp], Values]:
    """Mutual nearest neighbours within the tolerance: (n, 2) indices, and their distances."""
    if not len(first) or not len(second):
        return np.empty((0, 2), np.intp), np.empty(0)
    # not at the top: the other commands do without it
    from scipy.spatial import cKDTree

    distances, forwards = cKDTree(second).query(first)
    _, backwards = cKDTree(first).query(second)
    rows = np.arange(len(first))
    mutual = (backwards[forwards] == rows) & (distances <= tolerance)
    return np.column_stack([rows, forwards])[mutual], distances[mutual]


def known(pair: Pair) -> NDArray[np.float64]:
    """The homography of a pair that has one."""
    assert pair.homography is not None, f"{pair.scene}, {pair.name} has no homography"
    return pair.homography


def visible(pair: Pair, first: Points, second: Points) -> tuple[Points, Points]:
    """The corners that both views can show with their whole support, in their order."""
    homography = known(pair)
    ahead = inside(project(first, homography), pair.second)
    back = inside(project(second, np.linalg.inv(homography)), pair.first)
    return first[ahead], second[back]
