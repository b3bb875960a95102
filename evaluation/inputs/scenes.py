"""Rendered corners whose position is known exactly.

A scene is sampled 8x8 times per pixel, blurred by a Gaussian there and averaged over the pixels'
squares: what a lens and a sensor do. The random generator is seeded by the scene's own parameters,
so a scene does not depend on which others are rendered.
"""

from __future__ import annotations

import io
from dataclasses import dataclass
from itertools import product
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pictures

from evaluation.inputs.packages import opencv

Image = NDArray[np.uint8]
Samples = NDArray[np.float32]
Kind = Literal["L", "saddle", "T", "X"]

KINDS: tuple[Kind, ...] = get_args(Kind)
SEED = 2017
SUPERSAMPLING = 8
SIDE = 45
"""Pixels of a scene's side: corner in the middle, its support and a tracker's window around it."""
ORIENTATIONS = tuple(range(0, 360, 15))
"""Degrees."""
OPENINGS = (60, 90, 120)
"""Degrees between the two edges that meet."""
NOISES = (0.0, 3.0, 6.0)
"""Standard deviations in grey levels."""
BLURS = (0.5, 1.0)
"""Least and largest standard deviation of the blur in pixels, beside the pixel's own square."""
CONTRASTS = (80, 180)
"""Least and largest difference of the darkest and the brightest grey of a scene."""


@dataclass(frozen=True)
class Scene:
    """An image with one corner.

    Attributes
    ----------
    image
        (height, width) uint8.
    x, y
        The true corner, the first pixel's centre at (0, 0).
    inwards
        Direction from the corner into an L's wedge, in radians from x towards y; NaN for the other
        kinds.
    """

    image: Image
    x: float
    y: float
    kind: str
    noise: float = 0.0
    inwards: float = float("nan")


def plane(
    width: int, height: int, x: float, y: float, samples: int = SUPERSAMPLING
) -> tuple[Samples, Samples]:
    """Coordinates of all samples relative to (x, y), as a row and a column.

    There are ``samples`` along a pixel's side.
    """
    across = (np.arange(width * samples) + 0.5) / samples - 0.5 - x
    down = (np.arange(height * samples) + 0.5) / samples - 0.5 - y
    return across[None, :].astype(np.float32), down[:, None].astype(np.float32)


def _covered(distance: Samples) -> Samples:
    """About how much of a sample's square lies on the positive side of an edge at this distance.

    Without it an edge along x or y would be rounded to a sample, up to 1/16 pixel away from where
    it should be.
    """
    return np.clip(distance * SUPERSAMPLING + np.float32(0.5), 0, 1)


def left_of(u: Samples, v: Samples, angle: float) -> Samples:
    """1 on one side of a line through the origin, 0 on the other.

    For a line along x, it is 1 where y is positive.
    """
    return _covered(np.float32(np.cos(angle)) * v - np.float32(np.sin(angle)) * u)


def wedge(u: Samples, v: Samples, axis: float, opening: float) -> Samples:
    """1 between two rays from the origin, 0 elsewhere; angles in radians, the opening up to pi."""
    return left_of(u, v, axis - opening / 2) * (1 - left_of(u, v, axis + opening / 2))


def stroke(u: Samples, v: Samples, angle: float, width: float) -> Samples:
    """1 on a ray from the origin drawn with a round pen, 0 elsewhere."""
    cosine, sine = np.float32(np.cos(angle)), np.float32(np.sin(angle))
    along, across = cosine * u + sine * v, cosine * v - sine * u
    return _covered(np.float32(width / 2) - np.hypot(np.minimum(along, 0), across))


def greys(u: Samples, v: Samples, kind: Kind, angle: float, opening: float) -> Samples:
    """Relative grey, 0 to 1, of each sample.

    L: a wedge. T: an edge, on one side of which another ends. X: two edges cross, four greys (a
    shadow's edge over an object's). Saddle: the same with opposite greys alike, as on a chessboard.
    The first edge points to ``angle``.
    """
    if kind == "L":
        return wedge(u, v, angle + opening / 2, opening)
    first, second = left_of(u, v, angle), left_of(u, v, angle + opening)
    if kind == "T":
        return first * (1 - np.float32(0.55) * second)
    if kind == "X":
        return np.float32(0.6) * first + np.float32(0.4) * second
    return first + second - 2 * first * second


def expose(
    levels: Samples, blur: float, noise: float, random: np.random.Generator, samples: int = SUPERSAMPLING
) -> Image:
    """Grey levels of all samples into pixels: blur, average over each pixel, noise, rounding.

    ``noise`` is a standard deviation in grey levels.
    """
    if blur:
        levels = opencv().GaussianBlur(levels, (0, 0), blur * samples, borderType=1)
    height, width = (side // samples for side in levels.shape)
    pixels = levels.reshape(height, samples, width, samples).mean(axis=(1, 3), dtype=np.float64)
    if noise:
        pixels = pixels + random.normal(0, noise, pixels.shape)
    return np.clip(np.rint(pixels), 0, 255).astype(np.uint8)


def scene(kind: Kind, orientation: int, opening: int, *, inverted: bool, noise: float) -> Scene:
    """One scene of the wide set.

    Position, blur and contrast are random, but always the same for these arguments.
    """
    random = np.random.default_rng(
        [SEED, KINDS.index(kind), orientation, opening, inverted, round(10 * noise)]
    )
    x, y = SIDE // 2 + random.uniform(-0.5, 0.5, 2)
    blur, contrast = random.uniform(*BLURS), random.uniform(*CONTRASTS)
    angle, between = np.deg2rad(orientation), np.deg2rad(opening)
    levels = greys(*plane(SIDE, SIDE, x, y), kind, angle, between)
    levels = (1 - levels if inverted else levels) - 0.5
    image = expose(128 + contrast * levels, blur, noise, random)
    inwards = angle + between / 2 if kind == "L" else float("nan")
    return Scene(image, x, y, kind, noise, float(inwards))


def wide_set(kind: Kind, *, quick: bool = False) -> list[Scene]:
    """All scenes of a kind; ``quick``: right angles with middle noise only."""
    openings = OPENINGS[1:2] if quick else OPENINGS
    noises = NOISES[1:2] if quick else NOISES
    return [
        scene(kind, orientation, opening, inverted=inverted, noise=noise)
        for orientation, opening, inverted, noise in product(ORIENTATIONS, openings, (False, True), noises)
    ]


PAPER_SIZE = (166, 150)
"""Width and height of the paper's eight images."""
PAPER_CORNER = (16.6, 128.4)
"""Where their corner is: (17.60, 129.40) counts the first pixel as 1, as Matlab does."""
PAPER_LINES = (0, 30, 45, 60)
PAPER_SOLIDS = (30, 45, 60, 90)
"""Degrees between the two edges."""
PEN = 1.0
JPEG_QUALITY = 75
"""Matlab's defaults: lines of about a pixel, JPEG of this quality."""
Reading = Literal["opening", "rotation"]


def paper_scene(
    degrees: int,
    *,
    solid: bool,
    reading: Reading = "opening",
    corner: tuple[float, float] = PAPER_CORNER,
    size: tuple[int, int] = PAPER_SIZE,
    pen: float = PEN,
) -> Scene:
    """One of the paper's eight images: black on white, antialiased, through JPEG.

    Parameters
    ----------
    degrees
        Angle between the horizontal edge and the other one, anticlockwise in the picture.
    solid
        The area between two edges, or the two lines only. "0°" is then the end of a line.
    reading
        What the lines' degrees mean: ``"opening"``, as for the solid ones, or ``"rotation"`` of a
        right angle. The paper's figure is not public.
    """
    u, v = plane(*size, *corner)
    turn = np.deg2rad(degrees)
    if solid:
        black = wedge(u, v, -turn / 2, turn)
    else:
        first, second = (0.0, -turn) if reading == "opening" else (-turn, -turn - np.pi / 2)
        black = np.maximum(stroke(u, v, first, pen), stroke(u, v, second, pen))
    levels = 255 * (1 - black)
    image = expose(levels, 0, 0, np.random.default_rng(SEED))
    kind = f"{degrees}° {'solid ' if solid else ''}corner"
    return Scene(through_jpeg(image), *corner, kind)


def through_jpeg(image: Image, quality: int = JPEG_QUALITY) -> Image:
    """The image after it was saved as JPEG."""
    file = io.BytesIO()
    Pictures.fromarray(image).save(file, format="JPEG", quality=quality)
    return np.asarray(Pictures.open(file), dtype=np.uint8)
