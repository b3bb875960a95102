"""Detectors that are compared: each gives the corners of an image, the strongest first.

All of them give only corners that are as far inside the image as the largest margin there is.
"""

from __future__ import annotations

import zlib
from abc import ABC, abstractmethod
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from evaluation.inputs.packages import opencv
from golden import Parameters, Settings, detect
from golden.algorithm import Algorithm
from golden.formats import MAX_SIDE, SIGMA2_INTEGER_BITS

Image = NDArray[np.uint8]
Points = NDArray[np.float64]
"""(n, 2): x and y of corners in pixels, the first pixel's centre at (0, 0), strongest first."""

MARGIN = Algorithm(pixel_filter="twice").margin
"""Pixels at each edge of an image in which no detector's corners count: no algorithm has more."""
LOWEST_SIGMA1 = 0.002
"""sigma1 for the best N corners: low enough that thousands remain on a photograph."""
NO_FILTER = float(1 << SIGMA2_INTEGER_BITS) - 1
"""sigma2 at which nothing is rejected: tau is at most 8 times the largest D."""
MOST = 20_000


@dataclass(frozen=True)
class Thresholds:
    """A pair of thresholds as ``Settings`` has them; sigma1 is also OpenCV's ``qualityLevel``."""

    sigma1: float
    sigma2: float

    @property
    def name(self) -> str:
        return f"{self.sigma1:g}/{self.sigma2:g}"


USUAL = Thresholds(Settings().sigma1, Settings().sigma2)
PAPER = Thresholds(0.1, 0.1)
PAPER_LOW = Thresholds(0.01, 0.1)
"""With the least sigma1 that the paper recommends."""


class Detector(ABC):
    """One way to find corners."""

    name: str

    @abstractmethod
    def ranked(self, image: Image, thresholds: Thresholds) -> Points:
        """All corners, also weak ones, strongest first.

        Only sigma2 counts, and only where there is a filter.
        """

    @abstractmethod
    def at(self, image: Image, thresholds: Thresholds) -> Points:
        """Corners at these thresholds, strongest first."""


class Ours(Detector):
    """The golden model.

    Parameters
    ----------
    name
        For tables.
    parameters
        The detector.
    filtered
        With its texture filter, or without.
    """

    def __init__(self, name: str, parameters: Parameters, *, filtered: bool = True) -> None:
        self.name = name
        # what is built limits the size of a frame, and nothing else: images of every size are
        # measured
        self.parameters = replace(parameters, max_width=MAX_SIDE, max_height=MAX_SIDE)
        self.filtered = filtered

    def ranked(self, image: Image, thresholds: Thresholds) -> Points:
        return self.at(image, replace(thresholds, sigma1=LOWEST_SIGMA1))

    def at(self, image: Image, thresholds: Thresholds) -> Points:
        corners = detect(image, self.parameters, self.settings(thresholds))
        order = np.argsort(-corners.response, kind="stable")
        points = np.column_stack([corners.x, corners.y])[order]
        if self.parameters.algorithm.margin == MARGIN:
            return points
        last = np.array(image.shape[::-1]) - 1 - MARGIN
        return points[((points >= MARGIN) & (points <= last)).all(axis=1)]

    def settings(self, thresholds: Thresholds) -> Settings:
        """What the golden model is run with."""
        sigma2 = self._sigma2(thresholds)
        return Settings.default(self.parameters, sigma1=thresholds.sigma1, sigma2=sigma2)

    def _sigma2(self, thresholds: Thresholds) -> float:
        if self.parameters.algorithm.texture != "mean":
            return thresholds.sigma2 if self.filtered else NO_FILTER
        # the adaptive threshold's weight is another thing than the paper's sigma2
        return USUAL.sigma2 if self.filtered else 0.0


class GoodFeaturesToTrack(Detector):
    """OpenCV's Shi-Tomasi detector: whole pixels, maxima of 3x3, block of 5x5 as our smoothing.

    Parameters
    ----------
    distance
        Corners that are nearer than so many pixels to a stronger one are left out.
    """

    def __init__(self, distance: int = 0) -> None:
        self.name = "goodFeaturesToTrack" + (f", {distance} px apart" if distance else "")
        self.distance = distance

    def ranked(self, image: Image, thresholds: Thresholds) -> Points:
        return self.at(image, replace(thresholds, sigma1=LOWEST_SIGMA1))

    def at(self, image: Image, thresholds: Thresholds) -> Points:
        inside = np.zeros(image.shape, np.uint8)
        inside[MARGIN:-MARGIN, MARGIN:-MARGIN] = 1
        found = opencv().goodFeaturesToTrack(
            image, MOST, max(thresholds.sigma1, 1e-6), self.distance, mask=inside, blockSize=5
        )
        return np.empty((0, 2)) if found is None else found.reshape(-1, 2).astype(np.float64)


class Fast(Detector):
    """OpenCV's FAST-9 of 16, with non-maximum suppression and its own threshold; whole pixels."""

    name = "FAST"
    threshold = 10
    """OpenCV's default."""
    lowest = 2

    @staticmethod
    def scored(image: Image, threshold: int) -> tuple[Points, NDArray[np.float64]]:
        """Corners, strongest first, and the largest threshold at which each is a corner."""
        height, width = image.shape
        keypoints = opencv().FastFeatureDetector_create(threshold=threshold).detect(image)
        values = np.array([(*keypoint.pt, keypoint.response) for keypoint in keypoints]).reshape(-1, 3)
        x, y = values[:, 0], values[:, 1]
        inside = (x >= MARGIN) & (y >= MARGIN) & (x < width - MARGIN) & (y < height - MARGIN)
        values = values[inside]
        values = values[np.argsort(-values[:, 2], kind="stable")]
        return values[:, :2], values[:, 2]

    def ranked(self, image: Image, thresholds: Thresholds) -> Points:
        return self.scored(image, self.lowest)[0]

    def at(self, image: Image, thresholds: Thresholds) -> Points:
        return self.scored(image, self.threshold)[0]


class Chance(Detector):
    """Random points, for comparison: the repeatability that chance gives."""

    name = "chance"
    density = 1 / 400
    """Points per pixel where no number is given."""

    def ranked(self, image: Image, thresholds: Thresholds) -> Points:
        height, width = image.shape
        # a view of the same scene is to get other points
        random = np.random.default_rng(zlib.crc32(image.tobytes()))
        size = (MOST // 4, 2)
        return random.uniform((MARGIN, MARGIN), (width - 1 - MARGIN, height - 1 - MARGIN), size)

    def at(self, image: Image, thresholds: Thresholds) -> Points:
        return self.ranked(image, thresholds)[: round(image.size * self.density)]


WITHOUT = " without filter"
PLAIN = "ranking by D"
PLAIN_PARAMETERS = Parameters.profile("paper", gradient="signed", ties="first", divider="serial")


def detectors(profiles: dict[str, Parameters]) -> list[Detector]:
    """Plain ranking by D, each profile with and without its filter, then OpenCV's, then chance.

    Ranking by D is the paper's detector without a filter, but with signed gradients: everything
    else in a profile has to be better than this.
    """
    ours: list[Detector] = [Ours(PLAIN, PLAIN_PARAMETERS, filtered=False)]
    for name, parameters in profiles.items():
        ours.append(Ours(name, parameters))
        if parameters.algorithm.texture != "none":
            ours.append(Ours(name + WITHOUT, parameters, filtered=False))
    return [*ours, GoodFeaturesToTrack(), Fast(), Chance()]


class DetectionCache:
    """Corners that were asked for before, by detector, image and thresholds."""

    def __init__(self) -> None:
        # an image is known by its identity, which is its own only as long as it is kept
        self._kept: dict[tuple[str, int, Thresholds, bool], tuple[Image, Points]] = {}

    def corners(self, detector: Detector, image: Image, at: Thresholds, ranked: bool) -> Points:
        """``detector.ranked`` or ``.at`` of this very array."""
        key = (detector.name, id(image), at, ranked)
        if key not in self._kept:
            self._kept[key] = image, detector.ranked(image, at) if ranked else detector.at(image, at)
        return self._kept[key][1]


PIXELS_PER_CORNER = 600


@dataclass(frozen=True)
class Mode:
    """How many corners each detector may report.

    Attributes
    ----------
    name
        Name in the results.
    thresholds
        Thresholds of our detectors; sigma1 counts only where the number is free.
    equal
        Every detector reports its strongest N. Otherwise each reports what its thresholds let pass.
    like
        The detector whose number of corners at its thresholds is N; None: N is :meth:`wanted`.
    pixels_per_corner
        N is that of an image with a corner for so many pixels, where ``number`` is None.
    number
        N of every image.
    """

    name: str
    thresholds: Thresholds
    equal: bool
    like: str | None = None
    pixels_per_corner: int = PIXELS_PER_CORNER
    number: int | None = None

    def wanted(self, image: Image) -> int:
        """N for an image where no other detector says so."""
        return self.number or budget(image, self.pixels_per_corner)


MODES = (
    Mode("equal numbers", USUAL, equal=True),
    Mode(f"thresholds {USUAL.name}", USUAL, equal=False),
    Mode(f"as many as paper at {USUAL.name}", USUAL, equal=True, like="paper"),
    Mode(f"thresholds {PAPER.name}", PAPER, equal=False),
    Mode(f"thresholds {PAPER_LOW.name}", PAPER_LOW, equal=False),
    Mode(f"as many as paper at {PAPER_LOW.name}", PAPER_LOW, equal=True, like="paper"),
)


def modes_of(detectors: list[Detector]) -> list[Mode]:
    """The modes that these detectors allow: ``like`` is None, or one of the detectors."""
    names = {detector.name for detector in detectors}
    return [mode for mode in MODES if mode.like is None or mode.like in names]


def budget(image: Image, pixels_per_corner: int = PIXELS_PER_CORNER) -> int:
    """N for an image where nothing else says so: 512 corners in 640x480."""
    return max(round(image.size / pixels_per_corner), 10)
