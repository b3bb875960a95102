"""Rooms of textured planes, seen by two known cameras, so that the depth of every pixel is known.

A room has a back wall, a floor and two panels, which photographs cover. Points are (x, y, z) in
metres, x to the right, y down, z along the first camera's axis, which is at the origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from evaluation.inputs.packages import opencv
from evaluation.inputs.sources import Image, photographs
from evaluation.inputs.views import SENSOR_NOISE

Floats = NDArray[np.float64]

SEED = 2017
COUNT = 8
SIZE = (640, 480)
"""Width and height of a view."""
FOCAL = 600.0
"""Pixels."""
INNER = np.array([[FOCAL, 0, (SIZE[0] - 1) / 2], [0, FOCAL, (SIZE[1] - 1) / 2], [0, 0, 1]])
"""Both cameras' matrix: pixels from directions."""
SAMPLES = 3
"""A pixel is the mean of 3x3 samples."""
BACKGROUND = 90.0
"""Grey level where there is no plane."""
WALL, FLOOR = 8.0, 1.3
"""z of the back wall, and y of the floor."""


@dataclass(frozen=True)
class Plane:
    """A rectangle from ``origin`` along ``across`` and ``down``, which a photograph covers."""

    origin: Floats
    across: Floats
    down: Floats
    texture: Image

    def depths(self, directions: Floats) -> Floats:
        """z at which rays (n, 3) with z = 1 from the first camera meet the rectangle; else inf."""
        axes = np.column_stack([self.across, self.down])
        with np.errstate(divide="ignore", invalid="ignore"):
            normal = np.cross(self.across, self.down)
            depths = (self.origin @ normal) / (directions @ normal)
            places = (directions * depths[:, None] - self.origin) @ np.linalg.pinv(axes).T
            hit = (depths > 0) & (places >= 0).all(axis=1) & (places <= 1).all(axis=1)
        return np.where(hit, depths, np.inf)


@dataclass(frozen=True)
class Room:
    """Two views of one room.

    Attributes
    ----------
    first, second
        (height, width) uint8.
    rotation, translation
        From the first camera's coordinates to the second's: X2 = R X1 + t.
    planes
        What is there.
    """

    name: str
    first: Image
    second: Image
    rotation: Floats
    translation: Floats
    planes: tuple[Plane, ...]

    @property
    def cameras(self) -> tuple[Floats, Floats]:
        """Both (3, 4) projections, from points to pixels."""
        return _cameras(self.rotation, self.translation)

    def depths(self, points: Floats, around: float) -> Floats:
        """True z at pixels (n, 2) of the first view.

        NaN where there is no plane, and where another one begins within so many pixels.
        """
        nearest = [self._nearest(points + shift) for shift in around * _AROUND]
        which = np.array([plane for _, plane in nearest])
        depths = nearest[0][0]
        return np.where((which == which[0]).all(axis=0) & np.isfinite(depths), depths, np.nan)

    def _nearest(self, points: Floats) -> tuple[Floats, NDArray[np.intp]]:
        directions = np.column_stack([points, np.ones(len(points))]) @ np.linalg.inv(INNER).T
        depths = np.array([plane.depths(directions) for plane in self.planes])
        return depths.min(axis=0), depths.argmin(axis=0)


def _cameras(rotation: Floats, translation: Floats) -> tuple[Floats, Floats]:
    return INNER @ np.eye(3, 4), INNER @ np.column_stack([rotation, translation])


_AROUND = np.array([(0, 0), *((x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if x or y)], np.float64)


def _turned(degrees: float) -> Floats:
    """Rotation about y, which points down."""
    sine, cosine = np.sin(np.deg2rad(degrees)), np.cos(np.deg2rad(degrees))
    return np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]])


def _panel(random: np.random.Generator, x: float, z: float, texture: Image) -> Plane:
    across = _turned(random.uniform(-35, 35)) @ np.array([1.7, 0, 0])
    down = np.array([0, 1.5, 0])
    middle = np.array([x, 0, z]) + random.uniform(-0.3, 0.3, 3)
    return Plane(middle - (across + down) / 2, across, down, texture)


def _planes(random: np.random.Generator) -> tuple[Plane, ...]:
    named = {each.name: each.pixels for each in photographs()}
    wall = named[str(random.choice(("china", "flower", "rocket")))]
    floor = named[str(random.choice(("grass", "gravel", "brick")))]
    # mirrored, so that it goes on without an edge
    floor = np.block([[floor, floor[:, ::-1]], [floor[::-1], floor[::-1, ::-1]]])
    chosen = random.choice(("camera", "astronaut", "coffee", "chelsea", "coins"), 2, replace=False)
    left, right = (named[str(name)] for name in chosen)
    width, height = 7.6, 5.0
    back = np.array([-width / 2, FLOOR - height, WALL])
    front = np.array([-3.0, FLOOR, 3.0])
    return (
        Plane(back, np.array([width, 0, 0]), np.array([0, height, 0]), wall),
        Plane(front, np.array([6.0, 0, 0]), np.array([0, 0, WALL - 3.0]), floor),
        _panel(random, 1.1, 5.2, right),
        _panel(random, -1.0, 4.2, left),
    )


def _view(planes: tuple[Plane, ...], camera: Floats, gain: float, random: np.random.Generator) -> Image:
    """Planes from back to front: none of them reaches through another one."""
    cv2 = opencv()
    width, height = SIZE
    fine = np.array([[SAMPLES, 0, (SAMPLES - 1) / 2], [0, SAMPLES, (SAMPLES - 1) / 2], [0, 0, 1]])
    samples = np.full((height * SAMPLES, width * SAMPLES), BACKGROUND, np.float32)
    for plane in planes:
        rows, columns = plane.texture.shape
        axes = np.column_stack([plane.across / columns, plane.down / rows, plane.origin])
        # a texel's centre is half a texel from its edge
        to_view = camera @ np.vstack([axes, [0, 0, 1]]) @ np.array([[1, 0, 0.5], [0, 1, 0.5], [0, 0, 1]])
        texture = cv2.copyMakeBorder(plane.texture, 1, 1, 1, 1, cv2.BORDER_REPLICATE).astype(np.float32)
        # the border of one texel keeps interpolation away from the outside
        to_view = fine @ to_view @ np.array([[1, 0, -1], [0, 1, -1], [0, 0, 1]])
        size = samples.shape[::-1]
        covered = cv2.warpPerspective(np.ones((rows, columns), np.float32), to_view @ _INSIDE, size)
        drawn = cv2.warpPerspective(texture, to_view, size, flags=cv2.INTER_CUBIC)
        np.copyto(samples, drawn, where=covered > 0.5)
    pixels = samples.reshape(height, SAMPLES, width, SAMPLES).mean(axis=(1, 3), dtype=np.float64)
    noise = random.normal(0, SENSOR_NOISE, pixels.shape)
    return np.clip(np.rint(gain * pixels + noise), 0, 255).astype(np.uint8)


_INSIDE = np.array([[1.0, 0, 1], [0, 1, 1], [0, 0, 1]])
"""From a texture's pixels to those of the texture with its border."""


@cache
def room(number: int) -> Room:
    """One of the rooms, always the same for its number.

    The second camera is half a metre to the right, turned back a little, and its view is darker.
    """
    random = np.random.default_rng([SEED, number])
    planes = _planes(random)
    rotation = _turned(random.uniform(2, 5))
    translation = -rotation @ np.array([0.5, *random.uniform(-0.06, 0.06, 2)])
    first, second = (
        _view(planes, camera, gain, random)
        for camera, gain in zip(_cameras(rotation, translation), (1.0, 0.85), strict=True)
    )
    return Room(f"room {number}", first, second, rotation, translation, planes)


def rooms(*, quick: bool = False) -> list[Room]:
    """All rooms."""
    return [room(number) for number in range(1 if quick else COUNT)]
