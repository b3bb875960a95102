"""One frame, an image in and records out, by the blocks of Fig. 9 in their order.

1. Response map: D of every pixel, from the pixels, smoothed or not, by their gradients, products,
   smoothing and the square root (Eqs. 1, 2).
2. Peaks: the responses whose maxima are corners, D or a smoothed D.
3. Reference: Dref, the largest response of the frame before, or what the settings ask for.
4. Thresholds: T1 and T2, fractions of Dref.
5. Corners: the maxima above T1 (Eqs. 3-5), and which of them the texture filter accepts (Eqs. 6-9).
6. Cells: the strongest corners of each, where the settings ask for that.
7. Subpixel: the offset of each corner from its pixel (Eqs. 10-13).
8. Records: 64 bits for each corner (Eqs. 14-17), no more than the budget allows.
9. History: what the reference and the thresholds of the next frame depend on.

``golden.detector`` takes these steps for a single image and for a stream of frames;
``golden.video`` builds on that stream.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden.adaptation import adapted_threshold, histogram, smoothed
from golden.algorithm import FIT_REACH, RESPONSE_FILTER_REACH
from golden.cell_selection import last_row, strongest
from golden.convolution import smooth
from golden.corner_detection import corner_detection
from golden.output_constructor import Records, decode, encode
from golden.parameters import Parameters
from golden.pixel_filter import pixel_filter
from golden.preprocessing import Image, IntArray, gradients, products
from golden.response import response
from golden.response_filter import RESPONSE_FILTERS
from golden.settings import Settings
from golden.subpixel import subpixel
from golden.textures import TEXTURES
from golden.thresholds import Thresholds, choose_reference, thresholds

_STRIP_ROWS = 32


class History(NamedTuple):
    """What a frame takes from the last complete frame before it."""

    maximum: int | None = None
    """The largest response of that frame; None: there is no such frame."""
    adapted: int | None = None
    """The D that its target or rank asks for; None: it has neither."""


class Candidates(NamedTuple):
    """The maxima above T1 in raster order, as arrays of one length, (n,)."""

    x: NDArray[np.int64]
    """Column of the pixel, from 0."""
    y: NDArray[np.int64]
    """Row of the pixel, from 0."""
    response: IntArray
    """The response that is reported."""
    accepted: NDArray[np.bool_]
    """True where the texture filter accepts the corner."""

    def where(self, which: NDArray[np.bool_] | NDArray[np.intp]) -> Candidates:
        """The candidates at which the (n,) mask is true, or those with these indices."""
        return Candidates(self.x[which], self.y[which], self.response[which], self.accepted[which])


class Frame:
    """One frame on its way through the steps; the first two are taken when it is made.

    Parameters
    ----------
    image
        (height, width) pixels, which ``golden.check_image`` has accepted.
    parameters, settings
        The detector, and its settings in this frame.
    responses
        D, if it is not :func:`response_map` of the image, in the same shape; None: it is.

    Attributes
    ----------
    responses
        D of every pixel that has one.
    peaks
        See :func:`peak_responses`.
    """

    def __init__(
        self, image: Image, parameters: Parameters, settings: Settings, responses: IntArray | None = None
    ) -> None:
        self.image, self.parameters, self.settings = image, parameters, settings
        self.responses = response_map(image, parameters) if responses is None else responses
        self.peaks = peak_responses(self.responses, parameters)

    @cached_property
    def maximum(self) -> int:
        """The largest response of the pixels at which a corner may be."""
        radius = self.parameters.algorithm.suppression
        return int(self.peaks[radius:-radius, radius:-radius].max())

    def thresholds(self, history: History, reference: int | None = None) -> tuple[int, Thresholds]:
        """Dref and the thresholds; if ``reference`` is given, it is Dref."""
        if reference is None:
            reference = choose_reference(self.settings, *history)
        return reference, thresholds(self.settings, reference, self.parameters, history.adapted)

    def own_thresholds(self, reference: int | None = None) -> tuple[int, Thresholds]:
        """The same as :meth:`thresholds`, for an image that is its own history."""
        itself = History(self.maximum)
        _, limits = self.thresholds(itself, reference)
        return self.thresholds(self.next_history(limits, itself), reference)

    def maxima(self, t1: int) -> NDArray[np.bool_]:
        """E (Eqs. 3-5) of the pixels at which a corner may be: all but ``Algorithm.margin``."""
        algorithm = self.parameters.algorithm
        return corner_detection(self.peaks, t1, algorithm.ties, algorithm.suppression)

    def candidates(self, limits: Thresholds) -> Candidates:
        """The maxima above T1, and which of them the texture filter accepts."""
        algorithm = self.parameters.algorithm
        rows, columns = np.nonzero(self.maxima(limits.t1))
        at = algorithm.margin - algorithm.response_margin
        windows = _around(self.responses, algorithm.window_size, rows + at, columns + at)
        values = self.peaks[rows + algorithm.suppression, columns + algorithm.suppression]
        judge = TEXTURES[algorithm.texture].judge
        accepted, values = judge(values, windows, limits, algorithm.patches)
        return Candidates(columns + algorithm.margin, rows + algorithm.margin, values, accepted)

    def corners(self, limits: Thresholds, *, pixels: int | None = None) -> Candidates:
        """The candidates that are reported, unless cells or the budget leave them out.

        Parameters
        ----------
        pixels
            Number of pixels of the frame that have come, in raster order: only the corners that
            these decide. A corner is decided by its support or, where cells choose, by that of the
            last corner that its row of cells could have. None: all pixels.
        """
        corners = self.candidates(limits)
        if pixels is not None:
            corners = corners.where(self._last_pixel(corners) < pixels)
        return corners if self.settings.rejected_too else corners.where(corners.accepted)

    def _last_pixel(self, corners: Candidates) -> NDArray[np.int64]:
        """Number of the pixel that decides about each corner."""
        margin = self.parameters.algorithm.margin
        height, width = self.image.shape
        if not self.settings.per_cell:
            return (corners.y + margin) * width + corners.x + margin
        last = np.minimum(last_row(corners.y, self.settings), height - 1 - margin)
        return (last + margin) * width + width - 1

    def chosen(self, corners: Candidates) -> Candidates:
        """The corners that the cells choose, cell by cell; all of them where cells do not."""
        if not self.settings.per_cell:
            return corners
        return corners.where(strongest(corners.x, corners.y, corners.response, self.settings))

    def encoded(self, corners: Candidates) -> Records:
        """(n,) records of these corners, in their order."""
        samples, pixels = self.surroundings(corners)
        offset = subpixel(samples, self.parameters, pixels)
        return encode(corners.x, corners.y, corners.response, offset, ~corners.accepted)

    def records(self, limits: Thresholds, *, pixels: int | None = None) -> Records:
        """(n,) records of the chosen :meth:`corners`, before :meth:`within_budget`.

        They are in raster order; where cells choose, in the order of ``golden.cell_selection``.
        """
        return self.encoded(self.chosen(self.corners(limits, pixels=pixels)))

    def surroundings(self, corners: Candidates) -> tuple[IntArray, Image]:
        """What ``golden.subpixel`` reads: (n, 3, 3) of the peaks, and pixels as far as it needs."""
        algorithm = self.parameters.algorithm
        before = algorithm.margin - algorithm.suppression
        samples = _around(self.peaks, 3, corners.y - before, corners.x - before)
        return samples, _around(self.image, 2 * FIT_REACH[algorithm.fit] + 1, corners.y, corners.x)

    def within_budget(self, records: Records) -> Records:
        """The records up to the last accepted corner that ``max_corners`` allows."""
        limit = self.settings.max_corners
        if not limit:
            return records
        accepted = np.flatnonzero(decode(records).accepted)
        return records if len(accepted) < limit else records[: accepted[limit - 1] + 1]

    def next_history(self, limits: Thresholds, history: History) -> History:
        """The history of the next frame; ``history`` is that of this frame, for ``smoothing``.

        A target or a rank counts the corners that the texture filter accepts, whatever
        ``report_rejected`` and ``max_corners`` are. A rank counts rejected corners, too, where T2
        is a fraction of Dref: Dref would depend on itself.
        """
        if not self.settings.wanted_corners:
            return History(self.maximum)
        corners = self.candidates(limits._replace(t1=0))
        if not (self.settings.by_rank and TEXTURES[self.parameters.algorithm.texture].by_reference):
            corners = corners.where(corners.accepted)
        counts = histogram(corners.response, self.parameters)
        adapted = adapted_threshold(counts, self.settings.wanted_corners, self.parameters)
        if history.adapted is not None:
            adapted = smoothed(history.adapted, adapted, self.settings.smoothing)
        return History(self.maximum, adapted)


def _around(
    values: NDArray[Any], size: int, rows: NDArray[np.int64], columns: NDArray[np.int64]
) -> NDArray[Any]:
    """Windows (n, size, size) whose centres are at (n,) rows and columns of ``values``."""
    reach = size // 2
    return sliding_window_view(values, (size, size))[rows - reach, columns - reach]


def response_map(image: Image, parameters: Parameters) -> IntArray:
    """D of every pixel that has one: ``Algorithm.response_margin`` is taken away; int32.

    The image is worked off in strips of rows, so that the intermediate arrays stay in the
    processor's cache.
    """
    algorithm, lost = parameters.algorithm, 2 * parameters.algorithm.response_margin
    height, width = image.shape
    result = np.empty((height - lost, width - lost), dtype=np.int32)
    for top in range(0, len(result), _STRIP_ROWS):
        strip = pixel_filter(image[top : top + _STRIP_ROWS + lost], algorithm.pixel_passes)
        gx, gy = gradients(strip, algorithm.derivative)
        a, b, c = (smooth(product) for product in products(gx, gy, algorithm.gradient))
        result[top : top + _STRIP_ROWS] = response(a, b, c, parameters)
    return result


def peak_responses(responses: IntArray, parameters: Parameters) -> IntArray:
    """The responses whose maxima are corners: D, or D after the response filter.

    They reach ``suppression`` pixels further than the pixels at which a corner may be.
    """
    algorithm = parameters.algorithm
    needed = algorithm.suppression + RESPONSE_FILTER_REACH[algorithm.response_filter]
    edge = algorithm.margin - algorithm.response_margin - needed
    height, width = responses.shape
    return RESPONSE_FILTERS[algorithm.response_filter](responses[edge : height - edge, edge : width - edge])
