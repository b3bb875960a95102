"""What docs/reference/limits.md says is recomputed here."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from evaluation.sections.limits import PICTURE, board, on_board, picture, wander
from golden import PROFILES, Parameters, Settings, detect
from golden.algorithm import Fit
from golden.frame import response_map
from golden.subpixel import FITS
from tests.support.photographs import PHOTOGRAPHS, photograph

STEP = Parameters.profile("precise")
PAGE = (Path(__file__).parents[3] / "docs" / "reference" / "limits.md").read_text(encoding="utf-8")
TEXT = " ".join(PAGE.split())
ROWS = {line.split(" | ")[0].strip("| "): line for line in PAGE.splitlines() if re.match(r"\| \d", line)}
"""Rows of both tables, by their first cells."""


def cells(first: str) -> list[float]:
    return [float(cell) for cell in ROWS[first].strip("|").split("|")]


@pytest.mark.parametrize("square", [2, 3, 4, 5, 6, 8])
def test_boards(square: int) -> None:
    found = on_board(square, Parameters.profile("robust"))
    responses = response_map(board(square), Parameters.profile("robust"))
    assert cells(str(square)) == [
        square,
        *found[:2],
        round(found.farthest, 2),
        responses.min(),
        responses.max(),
    ]
    assert found.found == (0 if square in (2, 4) else found.there) and found.farthest == 0
    placed = on_board(square, STEP)
    assert placed.found == (0 if square in (2, 4) else placed.there) and placed.farthest == 0


@pytest.mark.parametrize("square", [2, 3, 4, 5, 6, 8])
def test_boards_of_the_paper(square: int) -> None:
    assert on_board(square, Parameters.profile("paper")).found == 0
    assert on_board(square, Parameters.profile("paper", ties="first")).found == 0
    peaks = detect(board(square), Parameters.profile("paper", ties="first"), Settings(sigma2=15.9))
    there = on_board(square, Parameters.profile("paper")).there
    assert len(peaks) == there if square >= 5 else square == 3 or len(peaks) == 0


def test_picture_is_the_committed_one() -> None:
    with Image.open(PICTURE) as committed:
        assert np.array_equal(committed.convert("RGB"), picture())


@pytest.mark.parametrize("blur", [0.5, 1.0, 1.5, 2.0, 2.5, 3.0])
def test_soft_corners(blur: float) -> None:
    fits: tuple[Fit, ...] = ("gradient", "nine")
    measured = [wander(blur, degrees, fit) for fit in fits for degrees in (0, 22, 45)]
    # rendered in floating point: a grey level may be rounded otherwise elsewhere
    assert measured == pytest.approx(cells(str(blur))[1:], abs=0.02)


def test_soft_corners_are_better_placed_by_steps_up_to_the_blur_that_the_page_says() -> None:
    for blur in ("0.5", "1.0", "1.5", "2.0", "2.5"):
        _, *found = cells(blur)
        assert max(found[:3]) < max(found[3:]) / 2 and max(found[:3]) <= 0.12
    assert max(cells("3.0")[1:4]) > 0.3


@pytest.mark.parametrize(
    ("name", "text"),
    [("robust", "5.5 and W - 6.5 with `robust`"), ("paper", "6.5 and W - 7.5 with `paper`")],
)
def test_corners_of_a_surface_keep_their_distance_from_the_edges(name: str, text: str) -> None:
    noise = np.random.default_rng(0).integers(0, 256, (512, 512), np.uint8)
    found = detect(noise, Parameters.profile(name), Settings(sigma1=0.001))
    nearest = min(axis.min() for axis in (found.x, found.y, 511 - found.x, 511 - found.y))
    assert nearest == PROFILES[name].margin - FITS["nine"].limit / 128
    assert f"between {text}" in TEXT and text.startswith(f"{nearest} and W - {nearest + 1}")


@pytest.mark.parametrize(("begins", "there"), [(5, False), (6, True), (7, True)])
def test_corners_of_the_gradient_step_may_be_nearer_than_the_margin(begins: int, there: bool) -> None:
    image = np.full((60, 60), 60, np.uint8)
    image[begins:30, begins:30] = 200
    found = detect(image, STEP)
    off = np.hypot(found.x - begins + 0.5, found.y - begins + 0.5).min()
    assert (off < 0.1) == there
    assert STEP.algorithm.margin - FITS["gradient"].limit / 128 == 3
    assert "between 3 and W - 4 with `precise`" in TEXT


def test_refined_corners_of_photographs_and_how_near_they_are() -> None:
    parameters = Parameters.profile("robust", suppression=3, response_filter="none")
    corners = near = left = 0
    nearest = np.inf
    for image in map(photograph, PHOTOGRAPHS):
        found = detect(image, parameters, Settings(reference="constant"))
        apart = np.hypot(found.x[:, None] - found.x, found.y[:, None] - found.y)
        np.fill_diagonal(apart, np.inf)
        corners += len(found)
        near += np.count_nonzero(apart.min(axis=1, initial=np.inf) < 4)
        nearest = min(nearest, apart.min(initial=np.inf))
        left += len(found.apart(4))
    assert f"Ten photographs have {corners:,} corners with `robust`" in TEXT
    assert f"{near} of them are nearer than 4 pixels to another corner" in TEXT
    assert f"the two nearest are {nearest:.2f} pixels from each other" in TEXT
    assert f"here {left:,} remain." in TEXT
