"""Boards of small squares, a little in perspective, blurred, with noise; corners are exact."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from evaluation.inputs.boards import Board
from evaluation.inputs.scenes import expose, plane

SEED = 2018
ACROSS = 12
"""Squares along a side."""
SAMPLES = 4
"""Samples along a pixel's side."""
BLURS = (0.5, 1.3)
NOISES = (1.0, 5.0)
"""Grey levels."""
_TILT = 0.012
"""How much smaller squares become from one to the next along an axis, at most."""


def small_board(square: int, number: int) -> Board:
    """A board with squares about so many pixels wide, always the same for these arguments."""
    random = np.random.default_rng([SEED, square, number])
    side = round(1.3 * (ACROSS + 1) * square) + 30
    x, y = side / 2 + random.uniform(-0.5, 0.5, 2)
    u, v = plane(side, side, x, y, SAMPLES)
    to_board = _homography(square, random)
    weight = to_board[2, 0] * u + to_board[2, 1] * v + 1
    across, down = ((row[0] * u + row[1] * v) / weight + ACROSS / 2 for row in to_board[:2])
    dark = (np.floor(across) + np.floor(down)) % 2 == 0
    inside = (np.abs(across - ACROSS / 2) < ACROSS / 2) & (np.abs(down - ACROSS / 2) < ACROSS / 2)
    levels = np.where(inside & dark, 0, 1).astype(np.float32)
    black, contrast = random.uniform(20, 60), random.uniform(100, 170)
    image = expose(
        black + contrast * levels, random.uniform(*BLURS), random.uniform(*NOISES), random, SAMPLES
    )
    places = np.arange(1, ACROSS) - ACROSS / 2
    corners = np.array([(x, y, 1) for y in places for x in places]) @ np.linalg.inv(to_board).T
    return Board(f"{square} px, {number}", image, corners[:, :2] / corners[:, 2:] + (x, y))


def _homography(square: int, random: np.random.Generator) -> NDArray[np.float64]:
    """From pixels around the board's middle to its squares."""
    angle = random.uniform(0, np.pi)
    cosine, sine = np.cos(angle) / square, np.sin(angle) / square
    tilt = random.uniform(-_TILT, _TILT, 2) / square
    return np.array([[cosine, sine, 0], [-sine, cosine, 0], [*tilt, 1]])
