# amaranth: UnusedElaboratable=no
"""The grid of cells: columns and ends of rows of cells, without a divider, equal a division."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.cell_grid import CellGrid, cell_settings_layout
from sim.stimulus import Stalls
from tests.support.blocks import RUN_IDS, RUNS, Size, run_block, tags

PARAMETERS = Parameters.profile("paper", max_width=300, max_per_cell=1)
WIDE_MARGIN = Parameters.profile("paper", max_width=300, max_per_cell=1, pixel_filter="twice")


class Followed(wiring.Component):
    """The grid, with a frame's settings beside each centre; three clocks pass between frames."""

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        super().__init__(
            {
                "i": In(
                    stream.Signature(
                        data.StructLayout({"eol": 1, "eof": 1, "settings": cell_settings_layout()})
                    )
                ),
                "o": Out(
                    stream.Signature(data.StructLayout({"column": range(parameters.max_cells), "row_end": 1}))
                ),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.grid = grid = CellGrid(self._parameters)
        pause = Signal(2, init=3)
        free = ~self.o.valid | self.o.ready
        step = self.i.valid & free & (pause == 0)
        m.d.comb += [
            self.i.ready.eq(step),
            grid.step.eq(step),
            grid.eol.eq(self.i.payload.eol),
            grid.eof.eq(self.i.payload.eof),
            grid.settings.eq(self.i.payload.settings),
        ]
        with m.If(free):
            m.d.sync += [
                self.o.valid.eq(step),
                self.o.payload.column.eq(grid.column),
                self.o.payload.row_end.eq(grid.row_end),
            ]
        with m.If(step & self.i.payload.eof):
            m.d.sync += pause.eq(3)
        with m.Elif((pause != 0) & self.i.valid):
            m.d.sync += pause.eq(pause - 1)
        return m


def beats(
    parameters: Parameters, sizes: list[Size], cells: list[Size]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """Centres of frames of these (height, width), with cells of these (height, width)."""
    margin = parameters.algorithm.margin
    columns, row_ends, settings = [], [], []
    for (height, width), (cell_height, cell_width) in zip(sizes, cells, strict=True):
        y, x = (at + margin for at in np.mgrid[:height, :width])
        column = x // cell_width - margin // cell_width
        row_end = (x == margin + width - 1) & (
            (y % cell_height == cell_height - 1) | (y == margin + height - 1)
        )
        columns.append(column.ravel())
        row_ends.append(row_end.ravel())
        settings.append(np.tile([cell_width, cell_height], (height * width, 1)))
    of_cells = np.concatenate(settings)
    fields = {"cell_width": of_cells[:, 0], "cell_height": of_cells[:, 1], "per_cell": 0 * of_cells[:, 0]}
    expected = {"column": np.concatenate(columns), "row_end": np.concatenate(row_ends)}
    return {**tags(sizes), "settings": fields}, expected


@pytest.mark.parametrize("parameters", [PARAMETERS, WIDE_MARGIN], ids=["margin 7", "margin 9"])
@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_frames(parameters: Parameters, name: Any, stalls: Stalls) -> None:
    """Cells from smaller than the margin to larger than the frame."""
    sizes = [(40, 60), (1, 1), (17, 100), (130, 9), (1, 280), (12, 12)]
    cells = [(9, 8), (8, 8), (16, 128), (13, 10), (64, 8), (128, 127)]
    if name == "amaranth":
        sizes, cells = [sizes[-1], (20, 20)], [cells[-1], (8, 9)]
    given, expected = beats(parameters, sizes, cells)
    run_block((Followed, parameters), {"i": given}, {"o": expected}, name, stalls)


@pytest.mark.parametrize("cell_width", [*range(8, 20), 126, 127, 128])
def test_widths(cell_width: int) -> None:
    sizes = [(3, 280), (2, 120)]
    given, expected = beats(PARAMETERS, sizes, [(8, cell_width)] * 2)
    assert expected["column"].max() == (PARAMETERS.algorithm.margin + 279) // cell_width
    run_block((Followed, PARAMETERS), {"i": given}, {"o": expected})
