"""Views of a photograph by known homographies, with changes of light and noise."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from evaluation.inputs.packages import opencv
from evaluation.inputs.sources import NamedImage, Pair

Image = NDArray[np.uint8]
Matrix = NDArray[np.float64]

SEED = 2017
SAMPLES = 4
"""A pixel is the mean of 4x4 samples."""
SCALE = 0.7
"""Pixels of the first view per pixel of the photograph, so that views are as sharp as a photograph.
"""
SENSOR_NOISE = 1.5
"""Standard deviation of the noise that every view has, in grey levels."""


@dataclass(frozen=True)
class View:
    """How another view differs from the first."""

    name: str
    scale: float = 1.0
    degrees: float = 0.0
    shift: tuple[float, float] = (0.0, 0.0)
    perspective: tuple[float, float] = (0.0, 0.0)
    gain: float = 1.0
    bias: float = 0.0
    blur: float = 0.0
    noise: float = SENSOR_NOISE

    def homography(self, width: int, height: int) -> Matrix:
        """From the first view to this one: about the centre, then shifted.

        Perspective is per half a side.
        """
        centre = np.array([[1, 0, (width - 1) / 2], [0, 1, (height - 1) / 2], [0, 0, 1.0]])
        turn = np.deg2rad(self.degrees)
        across, down = self.perspective
        about = np.array(
            [
                [self.scale * np.cos(turn), -self.scale * np.sin(turn), self.shift[0]],
                [self.scale * np.sin(turn), self.scale * np.cos(turn), self.shift[1]],
                [2 * across / width, 2 * down / height, 1.0],
            ]
        )
        return centre @ about @ np.linalg.inv(centre)


FIRST = View("first")
VIEWS = (
    View("shift", shift=(3.37, -2.61)),
    View("rotation 8°", degrees=8),
    View("rotation 20°, smaller, blurred", degrees=20, scale=0.85, blur=0.8),
    View("larger, brighter", scale=1.2, gain=1.2, bias=10),
    View("perspective, darker", perspective=(0.12, -0.08), gain=0.7, noise=3),
    View("blurred", blur=1.2),
    View("noisy", noise=8),
    View("half as bright", gain=0.5),
)
QUICK_VIEWS = 4


def render(photograph: Image, to_view: Matrix, size: tuple[int, int], view: View, seed: list[int]) -> Image:
    """A view of a photograph.

    Parameters
    ----------
    to_view
        Homography from the photograph's pixels to the view's.
    size
        Width and height of the view.
    seed
        Seed of its noise.
    """
    cv2 = opencv()
    width, height = size
    # samples lie at (k + 0.5) / SAMPLES - 0.5 in the view
    fine = np.array([[SAMPLES, 0, (SAMPLES - 1) / 2], [0, SAMPLES, (SAMPLES - 1) / 2], [0, 0, 1]])
    samples = cv2.warpPerspective(
        photograph.astype(np.float32),
        fine @ to_view,
        (width * SAMPLES, height * SAMPLES),
        flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_REFLECT_101,
    )
    pixels = samples.reshape(height, SAMPLES, width, SAMPLES).mean(axis=(1, 3), dtype=np.float64)
    if view.blur:
        pixels = cv2.GaussianBlur(pixels, (0, 0), view.blur)
    noise = np.random.default_rng([SEED, *seed]).normal(0, view.noise, pixels.shape)
    return np.clip(np.rint(view.gain * pixels + view.bias + noise), 0, 255).astype(np.uint8)


def rendered_pairs(
    photographs: list[NamedImage],
    views: tuple[View, ...] = VIEWS,
    notify: Callable[[int], None] | None = None,
) -> list[Pair]:
    """The first view of each photograph with each of its other views."""
    pairs = []
    for number, photograph in enumerate(photographs):
        height, width = (round(side * SCALE) for side in photograph.pixels.shape)
        shrunk = np.array([[SCALE, 0, (SCALE - 1) / 2], [0, SCALE, (SCALE - 1) / 2], [0, 0, 1.0]])
        first = render(photograph.pixels, shrunk, (width, height), FIRST, [number, 0])
        for index, view in enumerate(views, start=1):
            homography = view.homography(width, height)
            second = render(photograph.pixels, homography @ shrunk, (width, height), view, [number, index])
            pairs.append(Pair(view.name, photograph.name, photograph.group, first, second, homography))
        if notify:
            notify(number + 1)
    return pairs
