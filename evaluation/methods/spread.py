"""Detectors whose corners are spread over the image: the best of every cell come first."""

from __future__ import annotations

import numpy as np

from evaluation.methods.detectors import Detector, Fast, Image, Points, Thresholds


def in_turns(points: Points, cell: float) -> Points:
    """The strongest point of every cell, then every second, and so on; those of a turn by strength.

    Parameters
    ----------
    points
        (n, 2), strongest first.
    cell
        Side of a cell in pixels; the first cell begins half a pixel before the first pixel's
        centre.
    """
    if not len(points):
        return points
    _, which = np.unique(np.floor((points + 0.5) / cell), axis=0, return_inverse=True)
    which = which.reshape(-1)
    by_cell = np.argsort(which, kind="stable")
    sizes = np.bincount(which)
    turns = np.empty(len(points), np.intp)
    turns[by_cell] = np.arange(len(points)) - np.repeat(np.cumsum(sizes) - sizes, sizes)
    return points[np.argsort(turns, kind="stable")]


class FastByGrid(Detector):
    """FAST in cells, as ORB-SLAM asks for it, at one scale.

    In a cell without a corner at the usual threshold, a low one counts (Mur-Artal, Montiel, Tardos:
    ORB-SLAM, 2015; cells and thresholds are those of its second version). The best of every cell
    come first; ORB-SLAM halves cells instead until there are as many as it wants.
    """

    name = "FAST by grid"
    cell = 30
    """Side of a cell in pixels."""
    threshold = 20
    lowest = 7

    def ranked(self, image: Image, thresholds: Thresholds) -> Points:
        points, responses = Fast.scored(image, self.lowest)
        cells = np.floor((points + 0.5) / self.cell).astype(np.intp)
        rich = np.zeros(tuple(side // self.cell + 1 for side in reversed(image.shape)), bool)
        strong = responses >= self.threshold
        rich[tuple(cells[strong].T)] = True
        return in_turns(points[strong | ~rich[tuple(cells.T)]], self.cell)

    def at(self, image: Image, thresholds: Thresholds) -> Points:
        return self.ranked(image, thresholds)
