# amaranth: UnusedElaboratable=no
"""The grid of cells by beats: the cell of every lane equals a division."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.cell_beats import CellBeats
from hdl.cell_grid import cell_settings_layout
from sim.stimulus import Stalls
from tests.support.beats import in_beats
from tests.support.blocks import NO_STALLS, Array, Size, engine, pack, run, tags

BUILDS = {
    "margin 7": Build.profile("paper", max_width=300, max_per_cell=1),
    "margin 9": Build.profile("paper", max_width=300, max_per_cell=1, pixel_filter="twice"),
}


class Followed(wiring.Component):
    """The grid, with a frame's settings beside each beat; three clocks pass between frames."""

    def __init__(self, build: Build) -> None:
        self._build = build
        given = {"eol": 1, "eof": 1, "starts": 1, "settings": cell_settings_layout()}
        cells = data.ArrayLayout(range(build.max_cells), build.pixels_per_clock)
        super().__init__(
            {
                "i": In(stream.Signature(data.StructLayout(given))),
                "o": Out(stream.Signature(data.StructLayout({"cells": cells, "row_end": 1}))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.beats = beats = CellBeats(self._build)
        pause, free = Signal(2, init=3), Signal()
        step = self.i.valid & free & (pause == 0)
        m.d.comb += [
            free.eq(~self.o.valid | self.o.ready),
            self.i.ready.eq(step),
            beats.step.eq(step),
            *(getattr(beats, name).eq(self.i.payload[name]) for name in ("eol", "eof", "starts")),
            beats.settings.eq(self.i.payload.settings),
        ]
        with m.If(free):
            m.d.sync += [self.o.valid.eq(step), self.o.payload.row_end.eq(beats.row_end)]
            for lane, cell in enumerate(self.o.payload.cells):
                m.d.sync += cell.eq(beats.column + (lane > beats.last_lane))
        with m.If(step & self.i.payload.eof):
            m.d.sync += pause.eq(3)
        with m.Elif((pause != 0) & self.i.valid):
            m.d.sync += pause.eq(pause - 1)
        return m


def cells_of(size: Size, cell: Size, build: Build) -> tuple[Array, Array]:
    """The cell of each pixel that completes a window, 0 to the left of these; which rows end cells.

    By rows of windows.
    """
    margin = build.algorithm.margin
    (height, width), (cell_height, cell_width) = size, cell
    centres = np.arange(width) - margin
    columns = np.where(centres < margin, 0, centres // cell_width - margin // cell_width)
    rows = np.arange(margin, height - margin)
    ends = (rows % cell_height == cell_height - 1) | (rows == rows[-1])
    return np.tile(columns, (len(rows), 1)), ends


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.3, 0.4, 13)], ids=["unstalled", "both-stall"])
@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("kind", BUILDS)
def test_frames(kind: str, lanes: int, stalls: Stalls) -> None:
    """Cells as narrow as a beat, of every width up to two beats, and wider than the frame."""
    build = BUILDS[kind].changed(pixels_per_clock=lanes)
    margin, lost = build.algorithm.margin, 2 * build.algorithm.response_margin
    low = build.min_cell_width
    cells = [(8 + k, low + k) for k in range(9)] + [(64, 128), (8, 127)]
    sizes = [(2 * margin + 1 + 3 * k, 2 * margin + 30 + 5 * k) for k in range(len(cells))]
    given: dict[str, list[Array]] = {"eol": [], "eof": [], "starts": [], "settings": []}
    words, marks = [], []
    shape = Followed(build).o.payload.shape()
    for size, cell in zip(sizes, cells, strict=True):
        columns, row_ends = cells_of(size, cell, build)
        counts = np.arange(size[1]) >= 2 * margin
        first = lost // lanes
        by_beat = [frames[0] for frames in in_beats([columns[:, first * lanes :]], lanes, largest=0)]
        counting, _ = in_beats([np.tile(counts[first * lanes :], (len(columns), 1))], lanes, largest=0)
        ends = tags([by_beat[0].shape[:2]])
        number = len(ends["eol"])
        beat = first + np.arange(number) % by_beat[0].shape[1]
        row_end = (ends["eol"] == 1) & np.repeat(row_ends, by_beat[0].shape[1])
        for name, values in {**ends, "starts": beat <= 2 * margin // lanes}.items():
            given[name].append(values)
        given["settings"].append(np.tile([cell[1], cell[0]], (number, 1)))
        words.append(pack(shape, {"cells": by_beat[0].reshape(-1, lanes), "row_end": row_end}))
        mask = np.where(counting[0].reshape(-1, lanes) & by_beat[1].reshape(-1, lanes), -1, 0)
        marks.append(pack(shape, {"cells": mask, "row_end": 0 * row_end - 1}))
    settings = np.concatenate(given.pop("settings"))
    fields = {"cell_width": settings[:, 0], "cell_height": settings[:, 1], "per_cell": 0 * settings[:, 0]}
    beats = {name: np.concatenate(values) for name, values in given.items()}
    run(
        engine("amaranth", Followed, build),
        {"i": pack(Followed(build).i.payload.shape(), {**beats, "settings": fields})},
        {"o": np.concatenate(words)},
        stalls,
        counting={"o": np.concatenate(marks)},
    )
