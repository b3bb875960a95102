# amaranth: UnusedElaboratable=no
"""Cell selection: equals the golden model's choice, under stalls, in as many clocks as it says."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import pytest
from numpy.typing import NDArray

from golden.cell_selection import strongest
from golden.output_constructor import RESPONSE_SHIFT, FrameEnd, encode_frame_end
from golden.parameters import Parameters
from golden.settings import Settings
from hdl.build import Build
from hdl.cell_selection import CellSelection
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import ENGINES, NO_STALLS, RUN_IDS, RUNS, run_block

SIDE = 8
"""Side of all cells here: the grid is another block."""
PLAIN = Build.profile("robust", max_width=96, max_per_cell=4)
BUILDS = {
    "up to 4": PLAIN,
    "1, with budget": Build.profile("robust", max_width=96, max_per_cell=1, budget=True),
    "up to 5, with budget": Build.profile("robust", max_width=40, max_per_cell=5, budget=True),
    "up to 16": Build.profile("paper", max_width=96, max_per_cell=16),
}


class Frame(NamedTuple):
    """Corners at whole pixels in raster order, and what is set for them."""

    x: NDArray[np.int64]
    y: NDArray[np.int64]
    response: NDArray[np.int64]
    per_cell: int = 0
    max_corners: int = 0
    height: int = 64


def corners(
    seed: int, parameters: Parameters, count: int, *, per_cell: int, max_corners: int = 0, responses: int = 0
) -> Frame:
    """Random corners; with ``responses`` only so many different ones, so that many are equal."""
    rng = np.random.default_rng(seed)
    place = np.sort(rng.choice(parameters.max_width * 64, count, replace=False))
    y, x = np.divmod(place, parameters.max_width)
    response = rng.integers(1, responses or parameters.response_max, count, endpoint=True)
    return Frame(x, y, response, per_cell, max_corners)


def words(frame: Frame) -> NDArray[np.uint64]:
    """Records whose other bits tell them apart."""
    low = frame.x + (frame.y << 20)
    return (low | frame.response << RESPONSE_SHIFT).astype(np.uint64)


def beats(parameters: Parameters, frames: Sequence[Frame]) -> tuple[dict[str, Any], list[list[int]]]:
    """What goes in, and the beats that come out: record and `last`."""
    rows: dict[str, list[int]] = {
        name: [] for name in ("record", "last", "column", "per_cell", "row_end", "max_corners")
    }

    def add(frame: Frame, **values: int) -> None:
        values |= {"per_cell": frame.per_cell, "max_corners": frame.max_corners}
        for name, column in rows.items():
            column.append(values.get(name, 0))

    expected = []
    for number, frame in enumerate(frames):
        records = words(frame).tolist()
        for row in range(0, frame.height, SIDE):
            for k in np.flatnonzero(frame.y // SIDE == row // SIDE).tolist():
                add(frame, record=records[k], column=int(frame.x[k]) // SIDE)
            if frame.per_cell and row + SIDE < frame.height:
                add(frame, row_end=1)
        chosen = list(range(len(records)))
        if frame.per_cell:
            settings = Settings(cell_width=SIDE, cell_height=SIDE, per_cell=frame.per_cell)
            chosen = strongest(frame.x, frame.y, frame.response, settings).tolist()
            chosen = chosen[: frame.max_corners or None]
        end = FrameEnd(len(records), number, 77)
        add(frame, record=encode_frame_end(end), last=1, row_end=int(frame.per_cell > 0))
        expected += [[records[k], 0] for k in chosen]
        expected.append([encode_frame_end(end._replace(records=len(chosen))), 1])
    cell = {name: np.array(rows[name]) for name in ("column", "per_cell", "row_end")}
    if parameters.budget:
        cell["max_corners"] = np.array(rows["max_corners"])
    record = np.array(rows["record"], np.uint64)
    return {"record": record, "last": np.array(rows["last"]), "cell": cell}, expected


def check(
    parameters: Parameters, frames: Sequence[Frame], name: EngineName = "compiled", stalls: Stalls = NO_STALLS
) -> Capture:
    given, expected = beats(parameters, frames)
    block = CellSelection, parameters
    out = np.array(expected, dtype=np.uint64)
    return run_block(block, {"i": given}, {"o": out}, name, stalls, clocks=40)


def many(parameters: Parameters, count: int = 12) -> list[Frame]:
    """Frames from empty to full, in which cells choose or not; some with equal responses."""
    rng = np.random.default_rng(parameters.max_per_cell)
    frames = []
    for seed in range(count):
        most = int(rng.choice([0, 3, 20])) if parameters.budget else 0
        chosen = int(rng.integers(0, parameters.max_per_cell, endpoint=True))
        amount = int(rng.choice([0, 1, 40, 400]))
        frames.append(
            corners(
                seed,
                parameters,
                amount,
                per_cell=chosen,
                max_corners=most * (chosen > 0),
                responses=3 * (seed % 2),
            )
        )
    return frames


@pytest.mark.parametrize("parameters", BUILDS.values(), ids=BUILDS)
@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_frames(parameters: Parameters, name: EngineName, stalls: Stalls) -> None:
    check(parameters, many(parameters) if name == "compiled" else many(parameters)[3:5], name, stalls)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """One cell of two: 5, 9, 5, 7, 9 come; the 9s stay, and the first of them comes first."""
    frame = Frame(np.arange(5), np.zeros(5, np.int64), np.array([5, 9, 5, 7, 9]), per_cell=2, height=8)
    capture = check(PLAIN, [frame], name)
    assert [int(word) & 7 for word in capture.outputs["o"][:-1, 0]] == [1, 4]


@pytest.mark.parametrize("name", ENGINES)
def test_a_full_cell_by_hand(name: EngineName) -> None:
    """6, 9, 6, 7 fill the cell; 9 and 8 come among them, and push each a 6 out; 1 is surplus."""
    response = np.array([6, 9, 6, 7, 9, 8, 1])
    frame = Frame(np.arange(7), np.zeros(7, np.int64), response, per_cell=4, height=8)
    capture = check(PLAIN, [frame], name)
    assert [int(word) & 7 for word in capture.outputs["o"][:-1, 0]] == [1, 4, 5, 3]


@pytest.mark.parametrize("name", ENGINES)
def test_rows_of_cells_leave_nothing_to_those_after_them(name: EngineName) -> None:
    """The last cell of a row is asked for at once, and had records two rows before."""
    y = np.repeat(np.arange(0, 48, 8), 2)
    frame = Frame(np.tile([95, 95], 6), y + np.tile([0, 1], 6), np.arange(12) + 1, per_cell=4, height=48)
    few = Frame(np.array([3, 90]), np.array([2, 2]), np.array([7, 8]), per_cell=1, height=8)
    check(PLAIN, [frame, few, few, few], name)


@pytest.mark.parametrize("order", [1, -1])
def test_clocks_of_a_corner(order: int) -> None:
    """In ascending order each one moves all before it; in descending order none moves any."""
    parameters = Build.profile("robust", max_width=96, max_per_cell=8)
    insertion = CellSelection(parameters).insertion
    response = np.arange(1, 41)[::order]
    at = np.arange(40)
    frame = Frame(at % 8, at // 8, response, per_cell=8, height=8)
    clocks = np.diff(check(parameters, [frame]).input_clocks["i"])[:39]
    assert insertion.clocks == 13 and clocks.max() == (13 if order > 0 else 6)
    assert clocks.tolist() == ([5 + min(k, 8) for k in range(1, 40)] if order > 0 else [6] * 39)


def test_clocks_of_a_row_of_cells() -> None:
    """All its records come out within the time that the block says, where nothing holds them up."""
    selection = CellSelection(PLAIN)
    y, x = np.divmod(np.arange(8 * 96), 96)
    full = Frame(x, y, np.random.default_rng(0).permutation(8 * 96) + 1, per_cell=4, height=8)
    out = check(PLAIN, [full]).output_clocks["o"]
    assert len(out) == 12 * 4 + 1
    longest = out[-1] - out[0]
    assert longest <= selection.readout.clocks <= longest + 6


def test_a_row_of_cells_fills_while_another_waits_at_the_output() -> None:
    """No corner of two rows of cells waits for the output; the end of the second one does."""
    frame = corners(1, PLAIN, 100, per_cell=4)
    frame = frame._replace(y=frame.y // 4, height=16)
    order = np.lexsort((frame.x, frame.y))
    frame = frame._replace(x=frame.x[order], y=frame.y[order])
    given, expected = beats(PLAIN, [frame])
    capture = run_block(
        (CellSelection, PLAIN),
        {"i": given},
        {"o": np.array(expected, np.uint64)},
        stalls=Stalls(outputs=0.999, seed=1),
    )
    taken, out = capture.input_clocks["i"], capture.output_clocks["o"]
    assert (np.diff(taken[:-1]) < 12 + 2).all() and taken[-2] < out[1]


def test_memory() -> None:
    """Twice the records of a row of cells, and the numbers of them."""
    assert CellSelection(PLAIN).memory_bits == 2 * 12 * (4 * 64 + 3)
    build = Build.profile("robust", max_width=1200, min_cell_width=32, max_per_cell=5)
    assert CellSelection(build).memory_bits == 2 * 38 * (8 * 64 + 3)
