"""Non-maximum suppression by boxes, as it was done for the published figures on HPatches."""

from __future__ import annotations

import numpy as np

from evaluation.methods.detectors import Points

SIDE = 4.0
"""Side of the box around each point, in pixels."""
OVERLAP = 0.1
"""Largest intersection over union of the boxes of two points that are both kept."""


def suppressed(points: Points, most: int) -> Points:
    """The first ``most`` points whose boxes do not overlap one of an earlier, stronger point.

    ``points`` are (n, 2), strongest first.
    """
    if not len(points):
        return points
    # not at the top: the other commands do without it
    from scipy.spatial import cKDTree

    tree = cKDTree(points)
    alive = np.ones(len(points), bool)
    kept: list[int] = []
    for index in range(len(points)):
        if alive[index] and len(kept) < most:
            kept.append(index)
            near = np.array(tree.query_ball_point(points[index], SIDE, p=np.inf), np.intp)
            shared = (SIDE - np.abs(points[near] - points[index])).prod(axis=1)
            alive[near[shared > OVERLAP * (2 * SIDE**2 - shared)]] = False
    return points[kept]
