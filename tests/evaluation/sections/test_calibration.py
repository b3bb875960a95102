"""Errors of known corners by method, and what ``precise`` is for."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.inputs.small_boards import ACROSS, small_board
from evaluation.sections.calibration import Seen, locking, methods, place, scene, summary, tables
from golden import Parameters

PROFILES = {name: Parameters.profile("robust", fit=name) for name in ("nine", "gradient")}


def test_a_corner_that_is_found_and_one_that_is_not() -> None:
    seen = scene("saddle", 0.8, 0, 3)
    x, y = seen.corners[0]
    two = Seen(seen.image, np.array([[x, y], [x - 12, y]]))
    found = place(two, PROFILES)
    assert (
        list(found)
        == methods(PROFILES)
        == [
            *PROFILES,
            *(f"cornerSubPix {side}x{side}" for side in (5, 7, 11)),
        ]
    )
    for name, (errors, flagged) in found.items():
        assert np.isnan(errors[1]).all() and np.isnan(flagged[1]), name
    assert np.hypot(*found["gradient"][0][0]) < 0.05 and found["gradient"][1][0] == 0
    assert np.hypot(*found["cornerSubPix 11x11"][0][0]) < 0.05
    # cornerSubPix knows no flags
    assert np.isnan(found["cornerSubPix 7x7"][1]).all()


def test_an_image_without_corners() -> None:
    seen = Seen(np.full((45, 45), 90, np.uint8), np.array([[20.0, 20.0]]))
    for errors, flagged in place(seen, PROFILES).values():
        assert np.isnan(errors).all() and np.isnan(flagged).all()
    (nothing, *_) = summary([seen, seen], PROFILES).values()
    assert nothing["found"] == 0 and nothing["median"]["value"] is nothing["flagged"] is None


def test_corners_of_a_small_board_are_where_its_squares_meet() -> None:
    board = small_board(8, 0)
    assert board.truth is not None and board.truth.shape == ((ACROSS - 1) ** 2, 2)
    assert np.array_equal(board.image, small_board(8, 0).image)
    neighbours = np.linalg.norm(np.diff(board.truth.reshape(ACROSS - 1, ACROSS - 1, 2), axis=1), axis=2)
    assert 6.5 < neighbours.min() < neighbours.max() < 9.5
    found = summary([Seen(board.image, board.truth, 3.0)], PROFILES)
    assert found["gradient"]["found"] == 1 and found["gradient"]["flagged"] < 0.05
    assert found["gradient"]["median"]["value"] < 0.1


def test_steps_follow_soft_corners_that_one_window_of_opencv_does_not() -> None:
    found = locking(2.0, PROFILES, angles=(22,))
    assert found["gradient"] is not None and found["nine"] is not None
    assert found["gradient"] < 0.1 < found["nine"] < 0.3
    # with the smallest window it stays where it was
    assert found["cornerSubPix 5x5"] is not None and found["cornerSubPix 5x5"] > 0.5


def test_where_no_corner_is_found_there_is_no_figure() -> None:
    assert locking(9.0, PROFILES, angles=(22,)) == dict.fromkeys(methods(PROFILES))


@pytest.mark.parametrize("kind", ["L", "saddle", "X"])
def test_scenes_are_always_the_same_and_corners_where_they_say(kind: str) -> None:
    one, other = (scene(kind, 0.8, 2, 5, quality) for quality in (None, 50))
    assert np.array_equal(one.image, scene(kind, 0.8, 2, 5).image)
    assert np.array_equal(one.corners, other.corners) and not np.array_equal(one.image, other.image)
    assert np.hypot(*place(one, PROFILES)["gradient"][0][0]) < 0.7


def test_tables_say_how_many_are_found() -> None:
    estimate = {"value": 0.1234, "interval": None}
    figures = {"median": estimate, "p95": estimate, "found": 0.5, "flagged": 0.25}
    nothing = {"median": {"value": None}, "p95": {"value": None}, "found": 0.0, "flagged": None}
    found = {
        "conditions": {
            "L, blur, px": {"1": {"robust": figures, "cornerSubPix 7x7": nothing}},
            "squares, px": {"6": {"robust": figures | {"found": 1}, "cornerSubPix 7x7": nothing}},
        },
        "locking": {"2": {"robust": 0.125, "cornerSubPix 7x7": None}},
    }
    rows = {name: list(map(list, table.rows)) for name, table in tables(found).items()}
    assert rows == {
        "scenes": [["L, blur, px", "1", "0.123, 0.12 (50 %)", "–"]],
        "squares": [["6", "0.123, 0.12", "–", "25 %"]],
        "locking": [["2", "0.12", "–"]],
    }
