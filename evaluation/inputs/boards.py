"""Chessboards, rendered with perspective, distortion, blur and noise; corners are known exactly."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from evaluation.inputs.packages import opencv
from evaluation.inputs.scenes import Image, expose, plane

SEED = 2017
SIZE = (640, 480)
"""Width and height of a rendered board's image."""
SAMPLES = 4
"""Samples along a pixel's side."""
COUNT = 12
COLUMNS, ROWS = 9, 6
"""Inner corners of a rendered board."""


@dataclass(frozen=True)
class Board:
    """An image of a chessboard.

    Attributes
    ----------
    truth
        (n, 2) inner corners, x and y; None for a photograph, whose corners are not known.
    size
        Inner corners along both sides; None if they must be guessed.
    """

    name: str
    image: Image
    truth: NDArray[np.float64] | None = None
    size: tuple[int, int] | None = None


@dataclass(frozen=True)
class _Camera:
    """A pinhole with radial distortion looking at the board's plane, one square being 1."""

    focal: float
    centre: tuple[float, float]
    distortion: tuple[float, float]
    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    def project(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """(n, 2) points of the board's plane to pixels."""
        placed = np.column_stack([points, np.zeros(len(points))]) @ self.rotation.T + self.translation
        flat = placed[:, :2] / placed[:, 2:]
        squared = (flat**2).sum(axis=1, keepdims=True)
        k1, k2 = self.distortion
        return self.focal * flat * (1 + k1 * squared + k2 * squared**2) + self.centre

    def back(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
        """Pixels to the board's plane; the distortion is undone by fixed-point iteration."""
        u, v = (x - self.centre[0]) / self.focal, (y - self.centre[1]) / self.focal
        flat_u, flat_v = u, v
        k1, k2 = self.distortion
        for _ in range(8):
            squared = flat_u**2 + flat_v**2
            stretch = 1 + k1 * squared + k2 * squared**2
            flat_u, flat_v = u / stretch, v / stretch
        # the plane z = 0 of the board is mapped by a homography
        plane_to_view = np.column_stack([self.rotation[:, :2], self.translation])
        to_plane = np.linalg.inv(plane_to_view)
        across, down, weight = (row[0] * flat_u + row[1] * flat_v + row[2] for row in to_plane)
        return across / weight, down / weight


def _camera(random: np.random.Generator) -> _Camera:
    tilt = np.deg2rad(random.uniform((-35, -35, -30), (35, 35, 30)))
    rotation = np.eye(3)
    for axis, angle in enumerate(tilt):
        one, other = (axis + 1) % 3, (axis + 2) % 3
        turn = np.eye(3)
        turn[one, one] = turn[other, other] = np.cos(angle)
        turn[one, other], turn[other, one] = -np.sin(angle), np.sin(angle)
        rotation = turn @ rotation
    distance = random.uniform(14, 22)
    middle = np.array([(COLUMNS - 1) / 2, (ROWS - 1) / 2, 0])
    aside = np.append(random.uniform((-1.0, -0.7), (1.0, 0.7)), distance)
    return _Camera(
        focal=700.0,
        centre=((SIZE[0] - 1) / 2 + 3.3, (SIZE[1] - 1) / 2 - 2.7),
        distortion=(random.uniform(-0.25, 0.05), random.uniform(0, 0.05)),
        rotation=rotation,
        translation=aside - rotation @ middle,
    )


def _greys(camera: _Camera) -> NDArray[np.float32]:
    width, height = SIZE
    # the way back is smooth: exact once a pixel, a pixel beyond the image, and linear between
    x, y = np.meshgrid(np.arange(-1.0, width + 1), np.arange(-1.0, height + 1))
    across, down = (_between(plane) for plane in camera.back(x, y))
    # squares begin at whole numbers; inner corners are (0, 0) to (COLUMNS - 1, ROWS - 1), in a
    # white margin
    dark = (np.floor(across) + np.floor(down)) % 2 == 0
    inside = (across > -1) & (across < COLUMNS) & (down > -1) & (down < ROWS)
    margin = (across > -1.6) & (across < COLUMNS + 0.6) & (down > -1.6) & (down < ROWS + 0.6)
    return np.where(inside & dark, 0.0, np.where(margin, 1.0, 0.55)).astype(np.float32)


def _between(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values once a pixel to values at every sample, without the outermost pixel."""
    height, width = values.shape
    fine = opencv().resize(values, (width * SAMPLES, height * SAMPLES), interpolation=1)
    return np.asarray(fine[SAMPLES:-SAMPLES, SAMPLES:-SAMPLES])


@cache
def rendered_board(number: int) -> Board:
    """One of the rendered boards, always the same for its number."""
    random = np.random.default_rng([SEED, number])
    camera = _camera(random)
    dark, contrast = random.uniform(20, 60), random.uniform(100, 170)
    light = _light(random)
    blur, noise = random.uniform(0.5, 1.3), random.uniform(1, 5)
    image = expose((dark + contrast * _greys(camera)) * light, blur, noise, random, SAMPLES)
    corners = np.array([(x, y) for y in range(ROWS) for x in range(COLUMNS)], dtype=np.float64)
    return Board(f"rendered {number}", image, camera.project(corners), (COLUMNS, ROWS))


def _light(random: np.random.Generator) -> NDArray[np.float32]:
    u, v = plane(*SIZE, SIZE[0] / 2, SIZE[1] / 2, SAMPLES)
    across, down = random.uniform(-0.25, 0.25, 2)
    return (1 + across * u / SIZE[0] + down * v / SIZE[1]).astype(np.float32)


def rendered_boards(*, quick: bool = False) -> list[Board]:
    """All rendered boards."""
    return [rendered_board(number) for number in range(2 if quick else COUNT)]


COMMON_SIZES = (
    (9, 6),
    (8, 6),
    (7, 6),
    (7, 5),
    (9, 7),
    (10, 7),
    (11, 8),
    (8, 5),
    (6, 5),
    (9, 5),
    (7, 7),
    (6, 4),
)
"""Inner corners of boards that people print; tried in turn where the size is not given."""


def reference_corners(board: Board) -> NDArray[np.float64] | None:
    """Inner corners by OpenCV's board detector, which does not use ``cornerSubPix``.

    None if it does not find them.
    """
    cv2 = opencv()
    for size in [board.size] if board.size else COMMON_SIZES:
        found, corners = cv2.findChessboardCornersSB(
            board.image, size, flags=cv2.CALIB_CB_ACCURACY | cv2.CALIB_CB_NORMALIZE_IMAGE
        )
        if found:
            return np.asarray(corners.reshape(-1, 2), dtype=np.float64)
    return None
