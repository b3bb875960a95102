"""Ways to place a corner, from the same whole pixels: none, each fit of the model, OpenCV."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import get_args

import numpy as np
from numpy.typing import NDArray

from evaluation.figures import Figures
from evaluation.inputs.packages import opencv
from evaluation.inputs.scenes import Scene
from evaluation.methods.bootstrap import Values, estimate, mean, median, percentile_95
from golden import Parameters, Settings
from golden.algorithm import Fit
from golden.formats import OFFSET_BITS
from golden.frame import Frame
from golden.subpixel import subpixel

Positions = NDArray[np.float64]

INTEGER = "integer"
OPENCV = "cornerSubPix"
WITHIN = 4.0
"""Pixels: a corner further from the truth than this is another one.

The peak of D lies 2 to 3 pixels inside an L.
"""
SUBPIX_HALF_WINDOW = 3
"""7x7 pixels."""
SUBPIX_ITERATIONS = 30
SUBPIX_STEP = 0.01
"""OpenCV stops after so many iterations, or once a step is shorter than this many pixels."""


@dataclass(frozen=True)
class Localisation:
    """All corners of an image, by each method.

    Attributes
    ----------
    positions
        (n, 2) x and y in pixels, by the method's name. The same row is the same corner.
    accepted
        (n,) true where the texture filter accepts the corner.
    """

    positions: dict[str, Positions]
    accepted: NDArray[np.bool_]

    def nearest(self, x: float, y: float, within: float) -> int | None:
        """Row of the corner whose whole pixel is nearest to (x, y); None if none is near enough."""
        pixels = self.positions[INTEGER]
        distances = np.hypot(pixels[:, 0] - x, pixels[:, 1] - y)
        if not len(distances) or distances.min() > within:
            return None
        return int(distances.argmin())


def methods(parameters: Parameters) -> list[str]:
    """Names of the methods that such a detector allows, in the order in which they are shown."""
    return [INTEGER, *_variants(parameters), OPENCV]


def _variants(parameters: Parameters) -> dict[str, Parameters]:
    variants = {}
    for fit in get_args(Fit):
        try:
            variants[str(fit)] = parameters.changed(fit=fit)
        except ValueError:
            # not every fit is available with every gradient
            continue
    return variants


def place(image: NDArray[np.uint8], parameters: Parameters, settings: Settings) -> Localisation:
    """Find corners once, and place them by every method.

    Those that are too near to an edge for one of the methods are left out.
    """
    variants = _variants(parameters)
    margin = max(variant.algorithm.margin for variant in variants.values())
    frame = Frame(image, parameters, settings)
    _, limits = frame.own_thresholds()
    corners = frame.candidates(limits)
    height, width = image.shape
    from_edge = np.minimum.reduce([corners.x, corners.y, width - 1 - corners.x, height - 1 - corners.y])
    corners = corners.where(from_edge >= margin)
    pixels = np.column_stack([corners.x, corners.y])
    positions = {INTEGER: pixels.astype(np.float64)}
    for name, variant in variants.items():
        samples, around = Frame(image, variant, settings, frame.responses).surroundings(corners)
        offset = subpixel(samples, variant, around)
        positions[name] = pixels + np.column_stack([offset.dx, offset.dy]) / (1 << OFFSET_BITS)
    positions[OPENCV] = corner_sub_pix(image, pixels)
    return Localisation(positions, corners.accepted)


def whole_pixels(image: NDArray[np.uint8], parameters: Parameters, settings: Settings) -> NDArray[np.int64]:
    """(n, 2) pixels at which the response has its maxima, in the order of the records."""
    frame = Frame(image, parameters, settings)
    _, limits = frame.own_thresholds()
    corners = frame.candidates(limits)
    return np.column_stack([corners.x, corners.y])


def corner_sub_pix(
    image: NDArray[np.uint8], pixels: NDArray[np.int64], half_window: int = SUBPIX_HALF_WINDOW
) -> Positions:
    """``cv2.cornerSubPix`` from these pixels, (n, 2), windows 2·half_window + 1 pixels wide."""
    cv2 = opencv()
    if not len(pixels):
        return np.empty((0, 2))
    start = np.ascontiguousarray(pixels, dtype=np.float32).reshape(-1, 1, 2)
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, SUBPIX_ITERATIONS, SUBPIX_STEP)
    window = (half_window, half_window)
    return cv2.cornerSubPix(image, start, window, (-1, -1), stop).reshape(-1, 2).astype(np.float64)


@dataclass
class Outcome:
    """Results of the scenes of one kind, scene by scene.

    Attributes
    ----------
    found, accepted
        Whether D has a maximum above T1 near the truth, and whether the texture filter lets it
        pass.
    errors
        By method: (dx, dy) to the truth in pixels, for the corners that were found.
    scenes
        Scenes whose corners were found.
    """

    found: list[bool] = field(default_factory=list)
    accepted: list[bool] = field(default_factory=list)
    errors: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    scenes: list[Scene] = field(default_factory=list)

    def add(self, scene: Scene, parameters: Parameters, settings: Settings) -> None:
        """Detect the corner of a scene: the one whose whole pixel is nearest to the truth.

        It is the same for all methods.
        """
        localisation = place(scene.image, parameters, settings)
        corner = localisation.nearest(scene.x, scene.y, WITHIN)
        self.found.append(corner is not None)
        self.accepted.append(corner is not None and bool(localisation.accepted[corner]))
        if corner is None:
            return
        self.scenes.append(scene)
        for name, positions in localisation.positions.items():
            x, y = positions[corner]
            self.errors.setdefault(name, []).append((x - scene.x, y - scene.y))

    def offsets(self, method: str) -> Positions:
        """(n, 2) errors of the corners that were found."""
        return np.array(self.errors.get(method, []), dtype=np.float64).reshape(-1, 2)


def figures_of_images(offsets: Sequence[Values]) -> Figures:
    """Median and 95th percentile of the distance, and bias, with intervals.

    ``offsets`` are (n, 2) errors for each image.
    """
    distances = [np.hypot(*each.T)[:, None] for each in offsets]
    found: Figures = {}
    for name, values, statistic in (
        ("median", distances, median),
        ("p95", distances, percentile_95),
        ("bias_x", [each[:, :1] for each in offsets], mean),
        ("bias_y", [each[:, 1:] for each in offsets], mean),
    ):
        figure = estimate(values, statistic)
        found |= {name: figure["value"], f"{name}_interval": figure["interval"]}
    return found
