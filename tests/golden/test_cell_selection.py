"""The strongest corners of each cell: by hand, for any corners, in whole frames and in cut ones."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden import Parameters, Settings, StreamModel, decode_frame_end, detect, reference_detect
from golden.cell_selection import last_row, strongest
from golden.frame import Frame
from golden.video import Event, VideoModel, VideoSettings, framed
from tests.support.photographs import photograph

ROBUST = Parameters.profile("robust", max_per_cell=16)
MARGIN = ROBUST.algorithm.margin
BOTH = Parameters.profile("robust", max_per_cell=8, budget=True)


def chosen(corners: list[tuple[int, int, int]], width: int, height: int, most: int) -> list[int]:
    """Indices of the chosen ones of these (x, y, response)."""
    x, y, response = np.array(corners, np.int64).reshape(-1, 3).T
    settings = Settings(cell_width=width, cell_height=height, per_cell=most)
    return strongest(x, y, response, settings).tolist()


def test_by_hand() -> None:
    """Cells of 10x8: a tie, an empty cell, surplus, and a corner on each side of two borders."""
    corners = [
        *((3, 0, 5), (9, 0, 7), (10, 0, 1)),
        *((2, 4, 7), (5, 4, 9), (31, 4, 2)),
        *((0, 7, 7), (9, 7, 8)),
        *((0, 8, 3), (39, 8, 4)),
    ]
    assert chosen(corners, 10, 8, 1) == [4, 2, 5, 8, 9]
    # of the equal 7s the first in raster order comes first, and the last is surplus
    assert chosen(corners, 10, 8, 3) == [4, 7, 1, 2, 5, 8, 9]
    assert chosen(corners, 10, 8, 4) == [4, 7, 1, 3, 2, 5, 8, 9]
    assert chosen(corners, 10, 8, 16) == [4, 7, 1, 3, 6, 0, 2, 5, 8, 9]
    assert chosen([], 10, 8, 2) == []


def test_last_rows_by_hand() -> None:
    rows = last_row(np.array([0, 7, 8, 15, 16, 100]), Settings(cell_height=8))
    assert rows.tolist() == [7, 7, 15, 15, 23, 103]


@given(st.data())
def test_any_corners(data: st.DataObject) -> None:
    """Every cell has its strongest, in order, and nothing else."""
    places = data.draw(st.sets(st.tuples(st.integers(0, 60), st.integers(0, 60)), max_size=40))
    responses = st.sampled_from([1, 2, 3, 1 << 20])
    corners = [(x, y, data.draw(responses)) for y, x in sorted(places)]
    width, height, most = (data.draw(st.integers(*bounds)) for bounds in ((8, 128), (8, 128), (1, 16)))
    found = [corners[k] for k in chosen(corners, width, height, most)]
    cells: dict[tuple[int, int], list[tuple[int, int, int]]] = {}
    for x, y, response in corners:
        cells.setdefault((y // height, x // width), []).append((x, y, response))
    expected = []
    for _, inside in sorted(cells.items()):
        # Python's sort is stable, too
        expected += sorted(inside, key=lambda corner: -corner[2])[:most]
    assert found == expected


def test_float_model_agrees() -> None:
    """It has an implementation of its own; positions are within the rounding of gradients."""
    settings = Settings.default(ROBUST, sigma1=0.02, cell_width=40, cell_height=24, per_cell=2)
    ours, exact = (each(photograph("coins"), ROBUST, settings) for each in (detect, reference_detect))
    pixels = [set(zip(c.x.round().tolist(), c.y.round().tolist(), strict=True)) for c in (ours, exact)]
    assert len(ours) > 100 and len(pixels[0] & pixels[1]) > 0.9 * len(ours)


@pytest.mark.parametrize("name", ["camera", "coins"])
def test_a_whole_frame(name: str) -> None:
    """The corners are those without cells, less the surplus, which is counted."""
    image = photograph(name)
    plain = Settings.default(ROBUST, sigma1=0.005)
    settings = replace(plain, cell_width=32, cell_height=48, per_cell=4)
    model = StreamModel(ROBUST)
    every, frame = (model.process(image, each) for each in (plain, plain))
    cells = model.process(image, settings)
    assert cells.found == frame.found == len(frame.corners) > 2 * len(cells.corners) > 200
    assert decode_frame_end(int(cells.records[-1])).records == len(cells.corners)
    assert cells.maximum == every.maximum
    assert set(cells.records[:-1].tolist()) < set(frame.records[:-1].tolist())
    assert cells.corners.accepted.all()


def test_rejected_corners_are_not_reported() -> None:
    paper = Parameters.profile("paper", max_per_cell=4)
    settings = Settings.default(paper, sigma1=0.01, per_cell=4, report_rejected=True)
    corners = detect(photograph("camera"), paper, settings)
    assert corners == detect(photograph("camera"), paper, replace(settings, report_rejected=False))
    assert not detect(photograph("camera"), paper, replace(settings, per_cell=0)).accepted.all()


def test_the_refined_position_decides_nothing() -> None:
    """Some corners are refined into a neighbouring cell, and still are those of their own."""
    settings = Settings.default(ROBUST, sigma1=0.005, cell_width=8, cell_height=8, per_cell=16)
    frame = Frame(photograph("camera"), ROBUST, settings)
    corners = frame.chosen(frame.corners(frame.own_thresholds()[1]))
    refined = detect(photograph("camera"), ROBUST, settings)
    moved = (refined.x + 0.5) // 8 != corners.x // 8
    assert moved.any() and np.abs(refined.x - corners.x).max() <= 4


def test_target_then_cells_then_limit() -> None:
    image = photograph("camera")
    aimed = Settings.default(BOTH, target_corners=400)
    without, cells, limited = (
        StreamModel(BOTH),
        StreamModel(BOTH),
        StreamModel(BOTH),
    )
    of_cells = replace(aimed, cell_width=80, cell_height=60, per_cell=2)
    for _ in range(3):
        plain = without.process(image, aimed)
        some = cells.process(image, of_cells)
        first = limited.process(image, replace(of_cells, max_corners=30))
    assert plain.t1 == some.t1 == first.t1
    assert plain.found == some.found == first.found > len(some.corners) > 60
    assert first.corners == some.corners[:30]


@pytest.mark.parametrize("height", [8, 13, 64])
def test_a_cut_frame_has_whole_rows_of_cells(height: int) -> None:
    """A row of cells is reported when nothing that follows can change it, and no later."""
    image = photograph("camera")[100:170, 200:260]
    settings = Settings.default(ROBUST, sigma1=0.002, cell_width=16, cell_height=height, per_cell=2)
    frame = Frame(image, ROBUST, settings)
    _, limits = frame.own_thresholds()
    every = frame.chosen(frame.corners(limits))
    white = image.copy()
    for row in range(image.shape[0]):
        for pixels in (60 * row + 59, 60 * row + 60):
            white[:] = 255
            white.ravel()[:pixels] = image.ravel()[:pixels]
            cut = Frame(white, ROBUST, settings).records(limits, pixels=pixels)
            # rows of pixels at which a corner can be
            decided = (pixels - 60 * MARGIN) // 60 if row >= MARGIN else 0
            whole = decided // height * height if decided < 70 - MARGIN else 70
            count = int((every.y < whole).sum())
            assert np.array_equal(cut, frame.records(limits)[:count])
    assert len(every.x) >= 8


def test_surplus_is_dropped_and_counted() -> None:
    p = Parameters.profile("robust", max_width=64, max_height=64, max_per_cell=2)
    image = photograph("grass")[:64, :64]
    settings = Settings.default(p, sigma1=0.01, cell_width=32, cell_height=32, per_cell=1)
    model = VideoModel(p)
    (packet,) = model.feed(framed(image), VideoSettings(64, 64, settings))
    assert len(packet.records) == 5 and packet.found > 10
    assert model.dropped_records == packet.found - 4 and model.events & Event.RECORDS_DROPPED


@pytest.mark.parametrize(
    ("built", "asked", "message"),
    [
        ({}, {"per_cell": 1}, "per_cell is 1; allowed: 0, since the detector is built without max_per_cell"),
        ({"max_per_cell": 4}, {"per_cell": 5}, "per_cell is 5; allowed: whole numbers from 0 to 4"),
        (
            {"max_per_cell": 4, "min_cell_width": 32},
            {"per_cell": 4, "cell_width": 31},
            "cell_width is 31; allowed: whole numbers from 32 to 128",
        ),
    ],
)
def test_what_is_not_built(built: dict[str, Any], asked: dict[str, int], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Settings(**asked).check(Parameters.profile("robust", **built))


@pytest.mark.parametrize(
    ("field", "value", "allowed"),
    [("cell_width", 7, "8 to 128"), ("cell_height", 129, "8 to 128"), ("per_cell", 17, "0 to 16")],
)
def test_what_no_detector_has(field: str, value: int, allowed: str) -> None:
    with pytest.raises(ValueError, match=f"{field} is {value}; allowed: whole numbers from {allowed}"):
        Settings(**{field: value})


def test_cells_that_choose_nothing_need_not_be_built() -> None:
    Settings(cell_width=8).check(Parameters.profile("robust", min_cell_width=64))
