"""What corners are for: the homography between two views, from nothing but their corners.

Corners of both views are matched by the pixels around them, and OpenCV's RANSAC finds the
homography that most matches agree with and refines it on those. Nothing of the true homography is
used but to judge the result.
"""

from __future__ import annotations

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from evaluation.inputs.packages import opencv
from evaluation.inputs.sources import Image, Pair
from evaluation.methods.detectors import Points
from evaluation.methods.matching import inside, known, project

WINDOW = 11
"""Side of the patch that is compared, in pixels."""
LEAST_CORRELATION = 0.8
AGREEMENT = 2.0
"""Pixels from where the homography takes a corner, within which its partner agrees with it."""
SEED = 2017
GRID = 10
"""Points along a side of the grid at which a homography is judged."""
FAILED = 10.0
"""Pixels: the error of a pair without a homography, and the most that any pair counts for."""
_FEWEST = 4
_FLAT = 1e-3


def correspondences(pair: Pair, first: Points, second: Points) -> NDArray[np.intp]:
    """(n, 2) indices of corners of both views that correlate best with each other.

    Patches lie at the nearest whole pixels, so that rounding leaves the partners as they are.
    """
    if not len(first) or not len(second):
        return np.empty((0, 2), np.intp)
    correlation = _patches(pair.first, first) @ _patches(pair.second, second).T
    forwards, backwards = correlation.argmax(axis=1), correlation.argmax(axis=0)
    rows = np.arange(len(first))
    kept = (backwards[forwards] == rows) & (correlation[rows, forwards] >= LEAST_CORRELATION)
    return np.column_stack([rows, forwards])[kept]


def _patches(image: Image, points: Points) -> NDArray[np.float32]:
    """(n, pixels) of mean 0 and length 1, or all 0 where nothing can be seen."""
    half = WINDOW // 2
    padded = np.pad(image.astype(np.float32), half, mode="reflect")
    height, width = image.shape
    columns, rows = np.clip(np.rint(points).astype(np.intp), 0, (width - 1, height - 1)).T
    patches = sliding_window_view(padded, (WINDOW, WINDOW))[rows, columns].reshape(len(points), -1)
    patches = patches - patches.mean(axis=1, keepdims=True)
    lengths = np.linalg.norm(patches, axis=1, keepdims=True)
    return np.where(lengths > _FLAT, patches / np.maximum(lengths, _FLAT), 0).astype(np.float32)


def homography(first: Points, second: Points) -> NDArray[np.float64] | None:
    """From the points of the first view to their partners of the second; None if there is none."""
    if len(first) < _FEWEST:
        return None
    cv2 = opencv()
    cv2.setRNGSeed(SEED)
    found, _ = cv2.findHomography(first, second, cv2.RANSAC, AGREEMENT, maxIters=2000, confidence=0.999)
    return None if found is None else np.asarray(found, np.float64)


def grid_error(pair: Pair, estimated: NDArray[np.float64] | None) -> float:
    """Mean distance between where this and the true homography take a grid of the first view.

    In pixels of the second view, over the points that it shows; at most :data:`FAILED`.
    """
    if estimated is None:
        return FAILED
    height, width = pair.first.shape
    across, down = (np.linspace(0, side - 1, GRID) for side in (width, height))
    grid = np.column_stack([axis.ravel() for axis in np.meshgrid(across, down)])
    truth = project(grid, known(pair))
    shown = inside(truth, pair.second, 0)
    distances = np.hypot(*(project(grid[shown], estimated) - truth[shown]).T)
    return float(min(distances.mean(), FAILED))


def matched_error(pair: Pair, first: Points, second: Points) -> float:
    """:func:`grid_error` of the homography that these corners of both views give."""
    partners = correspondences(pair, first, second)
    return grid_error(pair, homography(first[partners[:, 0]], second[partners[:, 1]]))
