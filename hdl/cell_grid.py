"""The grid of cells (``golden.cell_selection``): where each window centre lies in it."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal, Value
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import BUDGET_BITS, CELL_SETTINGS, MAX_CELL
from golden.parameters import Parameters
from hdl.parts.optional import optional
from hdl.parts.probes import probe


def cell_settings_layout() -> data.StructLayout:
    """The settings of cells that one frame is processed with."""
    return data.StructLayout(CELL_SETTINGS)


def cell_layout(parameters: Parameters) -> data.StructLayout:
    """The cell of a corner.

    ``column`` is its place in the row of cells, ``per_cell`` how many corners the cell chooses; 0:
    cells do not. With ``row_end`` it is no corner, but the end of a row of cells; there
    ``max_corners`` is the limit of the frame, which exists with ``budget`` only.
    """
    return data.StructLayout(
        {
            "column": range(parameters.max_cells),
            "per_cell": CELL_SETTINGS["per_cell"],
            "row_end": 1,
            **optional(parameters.budget, max_corners=BUDGET_BITS),
        }
    )


class CellGrid(wiring.Component):
    """Follows the window centres of a frame through the grid of cells, without a divider.

    Members
    -------
    step, eol, eof
        A window centre is taken; it is the last of its row, of its frame.
    settings
        ``cell_settings_layout()``, steady from two clocks before a frame's first centre to its
        last.
    column
        Number of the centre's cell in its row, from 0 for the first cell that has centres.
    row_end
        The last centre of a row of cells is taken.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._margin = parameters.algorithm.margin
        super().__init__(
            {
                "step": In(1),
                "eol": In(1),
                "eof": In(1),
                "settings": In(cell_settings_layout()),
                "column": Out(range(parameters.max_cells)),
                "row_end": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        row_over, row_starts, frame_starts = Signal(), Signal(init=1), Signal(init=1)
        m.d.comb += row_over.eq(self.step & self.eol)
        with m.If(self.step):
            m.d.sync += row_starts.eq(self.eol)
        with m.If(row_over):
            m.d.sync += frame_starts.eq(self.eof)
        right = border(m, "x", self.settings.cell_width, self._margin, row_starts, self.step)
        lower = border(m, "y", self.settings.cell_height, self._margin, frame_starts, row_over)
        before = Signal.like(self.column, name="before")
        m.d.comb += [
            self.column.eq(Mux(row_starts, 0, before)),
            self.row_end.eq(row_over & (lower | self.eof)),
        ]
        with m.If(self.step):
            m.d.sync += before.eq(self.column + right)
        probe(self, row_starts=row_starts, frame_starts=frame_starts, before=before)
        return m


def border(m: Module, name: str, side: Value, margin: int, starts: Signal, step: Value) -> Value:
    """Is the place the last of its cell? ``starts``: it is the first that can have a corner."""
    whole, first, left, now = (
        Signal(range(MAX_CELL), name=f"{what}_{name}") for what in ("whole", "first", "left", "now")
    )
    # the first cell has less than the margin's pixels only if the margin is wider than a cell
    inside = Mux(whole >= margin, whole, (whole << 1) + 1) - margin
    m.d.sync += [whole.eq(side - 1), first.eq(inside)]
    m.d.comb += now.eq(Mux(starts, first, left))
    with m.If(step):
        m.d.sync += left.eq(Mux(now == 0, whole, now - 1))
    return now == 0
