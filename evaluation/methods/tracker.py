"""The exhaustive correlation tracker: every pixel against every place within reach.

The paper's tracker correlates exhaustively, too, but its details are not in the paper; this one is
normalised cross-correlation, forwards and backwards.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from evaluation.inputs.packages import opencv

Image = NDArray[np.uint8]
Floats = NDArray[np.float32]

WINDOW = 11
"""Side of the patch that is compared, in pixels."""
REACH = 16
"""A corner is looked for so many pixels away in x and in y."""
LEAST_CORRELATION = 0.8
LARGEST_RETURN_ERROR = 1.0
"""Pixels between a corner and where its partner, tracked back, lands."""
_FLAT = 1.0
"""A patch of a smaller standard deviation, in grey levels, correlates with nothing."""


@dataclass(frozen=True)
class Tracks:
    """For each pixel of the first image, the best partner in the second.

    Attributes
    ----------
    correlation
        (height, width), -1 to 1; 0 where the patch would leave the image.
    dx, dy
        (height, width) int8, whole pixels from the pixel to its partner.
    return_error
        (height, width) pixels between it and its partner's own best partner.
    """

    correlation: Floats
    dx: NDArray[np.int8]
    dy: NDArray[np.int8]
    return_error: Floats

    @property
    def tracked(self) -> NDArray[np.bool_]:
        """Pixels that correlate well enough, and come back."""
        return (self.correlation >= LEAST_CORRELATION) & (self.return_error <= LARGEST_RETURN_ERROR)


class _Best:
    """The largest correlation seen so far at each pixel, and with which displacement."""

    def __init__(self, shape: tuple[int, ...]) -> None:
        self.correlation = np.zeros(shape, np.float32)
        self.which = np.zeros(shape, np.int32)

    def offer(self, region: tuple[slice, slice], correlation: Floats, which: int) -> None:
        better = correlation > self.correlation[region]
        np.copyto(self.correlation[region], correlation, where=better)
        np.copyto(self.which[region], which, where=better)


def _moments(image: Image, window: int) -> tuple[Floats, Floats, Floats]:
    """Grey levels minus 128, and the mean and 1 / standard deviation of each patch.

    The latter is 0 where there is no patch.
    """
    cv2 = opencv()
    grey = image.astype(np.float32) - 128
    mean = cv2.blur(grey, (window, window))
    deviation = np.sqrt(np.maximum(cv2.blur(grey * grey, (window, window)) - mean * mean, 0))
    weight = np.where(deviation >= _FLAT, 1 / np.maximum(deviation, _FLAT), 0).astype(np.float32)
    half = window // 2
    inside = np.zeros_like(weight)
    inside[half:-half, half:-half] = weight[half:-half, half:-half]
    return grey, mean, inside


def _overlap(length: int, shift: int) -> tuple[slice, slice]:
    return slice(max(0, -shift), length - max(0, shift)), slice(max(0, shift), length - max(0, -shift))


def track(first: Image, second: Image, *, reach: int = REACH, window: int = WINDOW) -> Tracks:
    """Track every pixel of ``first`` into ``second``, an image of the same size, and back."""
    cv2 = opencv()
    height, width = first.shape
    grey_1, mean_1, weight_1 = _moments(first, window)
    grey_2, mean_2, weight_2 = _moments(second, window)
    shifts = list(product(range(-reach, reach + 1), repeat=2))
    forwards, backwards = _Best(first.shape), _Best(first.shape)
    for which, (dy, dx) in enumerate(shifts):
        if abs(dy) >= height or abs(dx) >= width:
            continue
        (rows_1, rows_2), (columns_1, columns_2) = _overlap(height, dy), _overlap(width, dx)
        here, there = (rows_1, columns_1), (rows_2, columns_2)
        correlation = cv2.blur(grey_1[here] * grey_2[there], (window, window))
        correlation -= mean_1[here] * mean_2[there]
        correlation *= weight_1[here]
        correlation *= weight_2[there]
        forwards.offer(here, correlation, which)
        backwards.offer(there, correlation, which)
    return _joined(forwards, backwards, np.array(shifts, np.int8))


def _joined(forwards: _Best, backwards: _Best, shifts: NDArray[np.int8]) -> Tracks:
    dy, dx = np.moveaxis(shifts[forwards.which], -1, 0)
    y, x = np.indices(forwards.which.shape)
    # a pixel that correlates with nothing has the first shift, which may lead out of the image
    partner = (np.clip(y + dy, 0, y.max()), np.clip(x + dx, 0, x.max()))
    back_dy, back_dx = np.moveaxis(shifts[backwards.which[partner]], -1, 0)
    return_error = np.hypot(dx - back_dx, dy - back_dy, dtype=np.float32)
    return Tracks(forwards.correlation, dx, dy, return_error)


class TrackCache:
    """Tracks of pairs of images that were asked for before: two sections track the same pairs."""

    def __init__(self) -> None:
        # an image is known by its identity, which is its own only as long as it is kept
        self._kept: dict[tuple[int, int], tuple[Image, Image, Tracks]] = {}

    def tracks(self, first: Image, second: Image) -> Tracks:
        """:func:`track` of these very arrays."""
        key = (id(first), id(second))
        if key not in self._kept:
            self._kept[key] = first, second, track(first, second)
        return self._kept[key][2]
