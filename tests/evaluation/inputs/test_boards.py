"""Rendered boards against another library's board detector, and what the study says of boards."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.inputs import boards
from evaluation.inputs.boards import Board, reference_corners, rendered_board
from evaluation.sections.chessboards import chessboards, nearest_errors
from golden import Parameters


@pytest.mark.parametrize("number", [0, 3])
def test_the_board_detector_finds_the_corners_where_they_are_rendered(number: int) -> None:
    board = rendered_board(number)
    assert board.truth is not None
    found = reference_corners(board)
    assert found is not None and len(found) == len(board.truth) == boards.COLUMNS * boards.ROWS
    errors = nearest_errors(found, board.truth)
    assert np.median(np.hypot(*errors.T)) < 0.12
    assert np.abs(errors.mean(0)).max() < 0.05, "a bias: coordinates are shifted"


def test_the_way_back_undoes_the_projection() -> None:
    camera = boards._camera(np.random.default_rng(5))
    points = np.random.default_rng(6).uniform((0, 0), (8, 5), (50, 2))
    pixels = camera.project(points)
    assert np.column_stack(camera.back(*pixels.T)) == pytest.approx(points, abs=1e-3)


def test_boards_differ_and_stay_the_same() -> None:
    again = boards.rendered_board.__wrapped__(0)
    assert np.array_equal(rendered_board(0).image, again.image)
    assert not np.array_equal(rendered_board(0).image, rendered_board(3).image)


def test_study_of_boards() -> None:
    rendered = rendered_board(0)
    photographed = Board("as if photographed", rendered.image)
    empty = Board("no board", np.full((120, 160), 90, np.uint8))
    steps: list[int] = []
    known = chessboards([rendered], {"robust": Parameters.profile("robust")})
    guessed = chessboards(
        [photographed, empty], {"robust": Parameters.profile("robust")}, notify=steps.append
    )
    assert steps == [1, 2]
    assert (known["boards"], known["corners"], known["not_found"]) == (1, 54, 0)
    assert (guessed["boards"], guessed["corners"], guessed["not_found"]) == (1, 54, 1)
    assert known["reference"]["median"] < 0.12 and guessed["reference"] is None
    for found in (known, guessed):
        each = found["profiles"]["robust"]
        assert each["detected"]["value"] > 0.95
        assert each["methods"]["cornerSubPix"]["median"] < 0.25 < each["methods"]["integer"]["median"]


def test_without_any_board() -> None:
    found = chessboards([Board("none", np.zeros((60, 80), np.uint8))], {"paper": Parameters.profile("paper")})
    assert found["boards"] == 0 and found["profiles"]["paper"]["methods"]["nine"]["median"] is None
