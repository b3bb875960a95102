"""Detectors whose corners are spread over the image: the best of every cell come first."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from evaluation.methods.detectors import MARGIN, Detector, Fast, Image, Ours, Points, Thresholds
from golden import Parameters, Settings


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


class OursByCells(Ours):
    """The golden model, which reports the strongest corners of each cell.

    The best of every cell come first, as a driver may take them from the records.

    Parameters
    ----------
    name, parameters, filtered
        As for :class:`Ours`.
    cell
        Side of a cell in pixels.
    """

    per_cell = 16

    def __init__(self, name: str, parameters: Parameters, cell: int, *, filtered: bool = True) -> None:
        built = replace(parameters, max_per_cell=self.per_cell)
        super().__init__(f"{name}, cells of {cell} px", built, filtered=filtered)
        self.cell = cell

    def at(self, image: Image, thresholds: Thresholds) -> Points:
        return in_turns(super().at(image, thresholds), self.cell)

    def settings(self, thresholds: Thresholds) -> Settings:
        usual = super().settings(thresholds)
        return replace(usual, cell_width=self.cell, cell_height=self.cell, per_cell=self.per_cell)


def covered(image: Image, points: Points, side: int) -> float:
    """Share of the squares of so many pixels a side that have a point; the margins belong to none.

    Squares at the right and lower edge that are no whole ones do not count.
    """
    inside = np.array(image.shape[::-1]) - 2 * MARGIN
    across, down = inside // side
    squares = np.unique(np.floor((points + 0.5 - MARGIN) / side), axis=0)
    whole = ((squares >= 0) & (squares < (across, down))).all(axis=1)
    return float(whole.sum() / (across * down))
