"""Errors of known corners by method, and what ``precise`` is for."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from evaluation.inputs.small_boards import ACROSS, small_board
from evaluation.report.page import FIGURES_NAME
from evaluation.sections.calibration import Seen, locking, methods, place, scene, summary, tables
from golden import Parameters

DOCS = Path(__file__).parents[3] / "docs"
PAGE = (DOCS / "howto" / "measurement.md").read_text(encoding="utf-8")
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


# -- docs/howto/measurement.md


def committed() -> Any:
    """The figures of the committed study."""
    study = json.loads((DOCS / "results" / FIGURES_NAME).read_text(encoding="utf-8"))
    return study["calibration"]


def table(heading: str) -> dict[str, list[str]]:
    """Cells of the first table below this heading, by its first column, which is left out."""
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    rows = [line.strip("|").split("|") for line in re.findall(r"^\|.*\|$", section, re.MULTILINE)]
    return {row[0].strip(): [cell.strip() for cell in row[1:]] for row in rows[2:]}


METHODS = ["robust", "precise", *methods({})]


def test_squares_of_the_page() -> None:
    found = committed()["conditions"]["squares, px"]
    assert table("How large squares should be") == {
        size: [
            *(f"{figures[name]['median']['value']:.3f}" for name in METHODS),
            f"{100 * figures['precise']['flagged']:.0f} %",
        ]
        for size, figures in found.items()
    }


def test_locking_of_the_page() -> None:
    assert table("How soft images may be") == {
        blur: [f"{figures[name]:.2f}" for name in METHODS] for blur, figures in committed()["locking"].items()
    }


def test_noise_and_jpeg_of_the_page() -> None:
    conditions = committed()["conditions"]
    for shown, kind in (("wedges", "L"), ("crossings", "saddle")):
        values = [conditions[f"{kind}, {what}"] for what in ("noise, grey levels", "JPEG quality")]
        for told, name in (("`precise`", "precise"), ("`cornerSubPix` 7×7", "cornerSubPix 7x7")):
            cells = [f"{each[name]['median']['value']:.3f}" for some in values for each in some.values()]
            assert table("Noise and JPEG")[f"{shown}, {told}"] == cells


def test_what_the_page_recommends() -> None:
    conditions = committed()["conditions"]
    for size, figures in conditions["squares, px"].items():
        best = min(figures[name]["median"]["value"] for name in methods({}))
        ratio = figures["precise"]["median"]["value"] / best
        assert ratio < 1.1 if int(size) >= 7 else ratio > 1.1
    slanted = conditions["saddle, blur, px"]
    for blur, ours, theirs in (("1", "0.05", "0.04"), ("1.5", "0.21", "0.05")):
        for name, told in (("precise", ours), ("cornerSubPix 11x11", theirs)):
            assert f"{slanted[blur][name]['median']['value']:.2f}" == told
