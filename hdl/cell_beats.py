"""The grid of cells (``golden.cell_selection``) by beats: where each lane's window centre lies."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.formats import MAX_CELL
from hdl.build import Build
from hdl.cell_grid import border, cell_settings_layout


class CellBeats(wiring.Component):
    """Follows the beats of a frame through the grid of cells.

    It does for beats what :class:`hdl.cell_grid.CellGrid` does for window centres. A cell is at
    least as wide as a beat, so that one border at most lies in a beat.

    Members
    -------
    step, eol, eof
        A beat is taken; it is the last of its row, of its frame.
    starts
        The beat is a row's first with a complete window, or comes before it.
    settings
        ``cell_settings_layout()``, steady from two clocks before a frame's first beat with a
        window to its last.
    column
        Number of the cell of lane 0, from 0 for the first cell that has centres.
    last_lane
        The last lane of that cell, as far as it lies in the beat. Where no border lies in the beat,
        that is its last lane.
    row_end
        The last beat of a row of cells is taken.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        lanes = build.pixels_per_clock
        super().__init__(
            {
                "step": In(1),
                "eol": In(1),
                "eof": In(1),
                "starts": In(1),
                "settings": In(cell_settings_layout()),
                "column": Out(range(build.max_cells)),
                "last_lane": Out(range(lanes)),
                "row_end": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m, lanes, margin = Module(), self._build.pixels_per_clock, self._build.algorithm.margin
        row_over, frame_starts = Signal(), Signal(init=1)
        m.d.comb += row_over.eq(self.step & self.eol)
        with m.If(row_over):
            m.d.sync += frame_starts.eq(self.eof)
        lower = border(m, "y", self.settings.cell_height, margin, frame_starts, row_over)
        m.d.comb += self.row_end.eq(row_over & (lower | self.eof))

        # places of the cell that follow lane 0
        whole, first, left, now = (
            Signal(range(MAX_CELL + lanes), name=name) for name in ("whole", "first", "left", "now")
        )
        inside = Mux(whole >= margin, whole, (whole << 1) + 1) - margin
        # the lanes before the first complete window belong to its cell
        m.d.sync += [whole.eq(self.settings.cell_width - 1), first.eq(inside + 2 * margin % lanes)]
        before, ends = Signal.like(self.column, name="before"), Signal()
        m.d.comb += [
            now.eq(Mux(self.starts, first, left)),
            ends.eq(now < lanes),
            self.column.eq(Mux(self.starts, 0, before)),
            self.last_lane.eq(Mux(ends, now, lanes - 1)),
        ]
        with m.If(self.step):
            m.d.sync += [
                left.eq(now - lanes + Mux(ends, whole + 1, 0)),
                before.eq(self.column + ends),
            ]
        return m
