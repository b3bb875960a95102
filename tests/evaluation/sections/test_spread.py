"""An even spread: squares that are covered, corners by cells, and what is found on one pair."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs.sources import STRUCTURE, NamedImage, Pair
from evaluation.inputs.views import VIEWS, rendered_pairs
from evaluation.methods.detectors import MARGIN, USUAL, Ours
from evaluation.methods.spread import OursByCells, covered
from evaluation.sections.spread import CELLS, detectors, spread, tables
from golden import Parameters

ROBUST = Parameters.profile("robust")


def test_covered_squares_by_hand() -> None:
    """3x2 whole squares of 20 pixels inside the margins; what lies beyond them counts nothing."""
    image = np.zeros((2 * MARGIN + 45, 2 * MARGIN + 70), np.uint8)
    points = np.array([[0, 0], [19, 0], [20, 0], [19.4, 19.4], [59, 39], [61, 0], [0, 41], [-1, 5]]) + MARGIN
    assert covered(image, points, 20) == 3 / 6
    assert covered(image, points[:0], 20) == 0 and covered(image, points[5:], 20) == 0


def test_corners_by_cells_come_in_turns(camera: NDArray[np.uint8]) -> None:
    """All are among those of the detector without cells; the first lie in cells of their own."""
    cells, plain = OursByCells("robust", ROBUST, 64), Ours("robust", ROBUST)
    found, every = (each.ranked(camera, USUAL) for each in (cells, plain))
    assert cells.name == "robust, cells of 64 px" and 200 < len(found) < len(every)
    assert set(map(tuple, found.tolist())) < set(map(tuple, every.tolist()))
    squares = np.floor((found[:30] + 0.5) / 64).tolist()
    assert len(set(map(tuple, squares))) == 30


@pytest.fixture
def pair(camera: NDArray[np.uint8]) -> Pair:
    named = NamedImage("camera", camera[60:380, 60:420], STRUCTURE)
    return rendered_pairs([named], VIEWS[1:2])[0]


def test_cells_cover_more_and_corners_are_found_again_less(pair: Pair) -> None:
    steps: list[int] = []
    some = detectors({"robust": ROBUST})
    found = spread([pair], some, (100,), steps.append)["100"]
    assert steps == [1] and set(found) == {each.name for each in some}
    plain, *cells = (found[name]["all"] for name in ("robust", *(f"robust, cells of {n} px" for n in CELLS)))
    for each in cells:
        assert each["covered"]["value"] > plain["covered"]["value"] + 0.1
        assert 0.3 < each["repeatability"]["value"] < plain["repeatability"]["value"]
        assert 0 < each["error"]["value"] < 1
    (table,) = tables({"numbers": {"100": found}}).values()
    assert len(table.rows) == len(found) and table.headings[:2] == ["detector", "covered"]
