"""Limits of the detector: boards too fine for its kernel, corners too soft for its gradient step.

``python -m evaluation.sections.limits`` draws the picture of docs/reference/limits.md again;
tests/evaluation/sections/test_limits.py measures the page's figures.
"""

from __future__ import annotations

from math import sqrt
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pictures
from PIL import ImageDraw

from evaluation.figures import Figures
from evaluation.presentation.numbers import number
from evaluation.presentation.table import Table
from evaluation.sections.section import Material, Section
from golden import Corners, detect
from golden.algorithm import Fit
from golden.frame import response_map
from golden.parameters import Parameters
from golden.preprocessing import Image

PICTURE = Path(__file__).parents[2] / "docs" / "reference" / "limits" / "boards.png"
SIDES = (3, 4, 5, 6)
"""Pixels of the squares' sides that are drawn, from left to right."""
BOARD_SIDE = 96
_SHOWN = 30
"""Side of the part that is drawn, and how much it is enlarged."""
_SCALE = 7
_GAP = 10
_MARK = (213, 94, 0)

SADDLE_SIDE = 48
_SAMPLES = 4
STEPS = 16


def board(square: int) -> Image:
    """Sharp squares along the pixels, 40 and 200 grey, (96, 96)."""
    return (np.indices((BOARD_SIDE, BOARD_SIDE)) // square).sum(0).astype(np.uint8) % 2 * 160 + 40


class Found(NamedTuple):
    """Numbers of corners on a board and of those found, and the largest error in pixels."""

    there: int
    found: int
    farthest: float


def on_board(square: int, parameters: Parameters) -> Found:
    """Corners found with the usual settings.

    They are compared with the corners of which a peak can be the first of the four pixels around,
    which is the one that ``ties="first"`` takes.
    """
    found = detect(board(square), parameters)
    edges = np.arange(square, BOARD_SIDE, square) - 0.5
    margin = parameters.algorithm.margin
    first = np.floor(edges)
    edges = edges[(first >= margin) & (first < BOARD_SIDE - margin)]
    off = [np.abs(axis[:, None] - edges).min(axis=1) for axis in (found.x, found.y)]
    return Found(len(edges) ** 2, len(found), float(np.hypot(*off).max(initial=0)))


def saddle(x: float, y: float, blur: float, degrees: float) -> Image:
    """Two crossing edges, 30 and 220 grey, turned and blurred by a Gaussian, (48, 48).

    It is exact except for the average over a pixel's square, which is that of 4x4 samples.
    """
    from scipy.special import erf

    places = (np.arange(SADDLE_SIDE * _SAMPLES) + 0.5) / _SAMPLES - 0.5
    across, down = places[None, :] - x, places[:, None] - y
    cosine, sine = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    first = erf((cosine * across + sine * down) / (blur * sqrt(2)))
    second = erf((cosine * down - sine * across) / (blur * sqrt(2)))
    samples = (first * second).reshape(SADDLE_SIDE, _SAMPLES, SADDLE_SIDE, _SAMPLES)
    return np.rint(125 + 95 * samples.mean((1, 3))).astype(np.uint8)


def wander(blur: float, degrees: float, fit: Fit) -> float:
    """Largest less smallest error in x, in pixels, of a saddle that moves in 16 steps of 1/16."""
    middle, y = SADDLE_SIDE / 2, SADDLE_SIDE / 2 + 0.3
    errors = []
    for x in middle + np.arange(STEPS) / STEPS:
        found = detect(saddle(x, y, blur, degrees), Parameters.profile("robust", fit=fit))
        errors.append(found.x[np.hypot(found.x - x, found.y - y).argmin()] - x)
    return float(np.ptp(errors))


def picture() -> Pictures.Image:
    """Boards above, their D below, white the largest of all; crosses are corners of ``robust``."""
    parameters = Parameters.profile("robust")
    side = _SHOWN * _SCALE
    drawn = Pictures.new("RGB", (len(SIDES) * (side + _GAP) - _GAP, 2 * side + _GAP), "white")
    responses = {square: response_map(board(square), parameters) for square in SIDES}
    largest = max(int(each.max()) for each in responses.values())
    for column, (square, response) in enumerate(responses.items()):
        shown = board(square)
        inside = slice(parameters.algorithm.response_margin, -parameters.algorithm.response_margin)
        level = np.zeros_like(shown)
        level[inside, inside] = np.rint(response * (255 / largest))
        corners = detect(shown, parameters)
        for row, greys in enumerate((shown, level)):
            drawn.paste(_enlarged(greys, corners), (column * (side + _GAP), row * (side + _GAP)))
    return drawn


def _enlarged(greys: NDArray[np.uint8], corners: Corners) -> Pictures.Image:
    """From the board's 12th pixel on, that is away from its edges, with crosses."""
    first = 12
    part = Pictures.fromarray(greys[first : first + _SHOWN, first : first + _SHOWN])
    drawn = part.resize((_SHOWN * _SCALE,) * 2, Pictures.Resampling.NEAREST).convert("RGB")
    pen = ImageDraw.Draw(drawn)
    for x, y in zip(corners.x - first, corners.y - first, strict=True):
        u, v = (round((place + 0.5) * _SCALE) for place in (x, y))
        pen.line((u - 3, v, u + 3, v), _MARK)
        pen.line((u, v - 3, u, v + 3), _MARK)
    return drawn


SQUARES = (2, 3, 4, 5, 6, 8)
"""Sides of squares, in pixels, whose boards are measured."""
SOFT = (0.5, 1.0, 1.5, 2.0, 2.5, 3.0)
"""Blurs of crossings, in pixels."""
DEGREES = (0, 22, 45)
FITS: tuple[Fit, ...] = ("gradient", "nine")


def measure(material: Material) -> Figures:
    """Both tables of docs/reference/limits.md, for ``robust``; quick: every other row."""
    every = 2 if material.quick else 1
    squares, blurs = SQUARES[::every], SOFT[::every]
    boards: list[Figures] = []
    soft: list[Figures] = []
    with material.progress("limits", len(squares) + len(blurs)) as advance:
        for square in squares:
            found = on_board(square, Parameters.profile("robust"))
            responses = response_map(board(square), Parameters.profile("robust"))
            levels: Figures = {"least": int(responses.min()), "largest": int(responses.max())}
            boards.append({"square": square} | found._asdict() | levels)
            advance(len(boards))
        for blur in blurs:
            errors: Figures = {
                fit: [round(wander(blur, degrees, fit), 4) for degrees in DEGREES] for fit in FITS
            }
            soft.append({"blur": blur} | errors)
            advance(len(boards) + len(soft))
    return {"boards": boards, "soft": soft, "degrees": list(DEGREES)}


def tables(found: Figures) -> dict[str, Table]:
    """``boards`` and ``soft``."""
    boards = [
        [
            *(number(each["square"]), number(each["there"]), number(each["found"])),
            *(number(each["farthest"], 2), number(each["least"]), number(each["largest"])),
        ]
        for each in found["boards"]
    ]
    soft = [
        [number(each["blur"], 1), *(number(error, 2) for fit in FITS for error in each[fit])]
        for each in found["soft"]
    ]
    headings = [
        "side of a square, px",
        "corners there",
        "found",
        "farthest off, px",
        "D, least",
        "D, largest",
    ]
    return {
        "boards": Table("Sharp boards along the pixels", headings, boards),
        "soft": Table(
            "Soft crossings moved over a pixel: largest less smallest error in x, px",
            ["blur, px", *(f"{fit}, {degrees}°" for fit in FITS for degrees in found["degrees"])],
            soft,
        ),
    }


SECTION = Section(name="limits", title="Limits", measure=measure, tables=tables)


if __name__ == "__main__":
    PICTURE.parent.mkdir(exist_ok=True)
    picture().quantize(64).save(PICTURE, optimize=True)
