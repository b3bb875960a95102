"""Faults in the choice of the strongest corners of each cell."""

from __future__ import annotations

from tests.mutations.copies import Mutation

CELLS = {
    "of equal corners the last one counts": Mutation(
        "golden/cell_selection.py",
        "np.lexsort((-response.astype(np.int64), columns, rows))",
        "np.lexsort((-y, -response.astype(np.int64), columns, rows))",
        "tests/golden/test_cell_selection.py",
        "by_hand",
    ),
    "a row of cells is decided a row too soon": Mutation(
        "golden/cell_selection.py",
        "(y // settings.cell_height + 1) * settings.cell_height - 1",
        "(y // settings.cell_height + 1) * settings.cell_height - 2",
        "tests/golden/test_cell_selection.py",
        "last_rows",
    ),
    "an equal corner moves the one before it down": Mutation(
        "hdl/cell_insertion.py",
        "self._response(self.record) < self._response(record)",
        "self._response(self.record) <= self._response(record)",
        "tests/hdl/test_cell_selection.py",
        "by_hand and amaranth",
    ),
    "a record that is not weaker is copied down": Mutation(
        "hdl/cell_insertion.py",
        "put.eq(step & (~weaker | top))",
        "put.eq(step & top)",
        "tests/hdl/test_cell_selection.py",
        "full_cell and amaranth",
    ),
    "a new corner comes a place too high": Mutation(
        "hdl/cell_insertion.py",
        "chosen.eq(Mux(weaker, higher, same))",
        "chosen.eq(higher)",
        "tests/hdl/test_cell_selection.py",
        "by_hand and amaranth",
    ),
    "what was compared before a corner counts for its first step": Mutation(
        "hdl/cell_insertion.py",
        "weaker.eq(~step | (",
        "weaker.eq((",
        "tests/hdl/test_cell_selection.py",
        "frames and amaranth",
    ),
    "what is surplus is written": Mutation(
        "hdl/cell_insertion.py",
        "step & ~chosen.beyond",
        "step",
        "tests/hdl/test_cell_selection.py",
        "full_cell and amaranth",
    ),
    "a cell takes one corner too many": Mutation(
        "hdl/cell_insertion.py",
        "clearing | (start & (self.count != cell.per_cell))",
        "clearing | start",
        "tests/hdl/test_cell_selection.py",
        "by_hand and amaranth",
    ),
    "a corner does not wait until its cell is cleared": Mutation(
        "hdl/cell_insertion.py",
        "self.look & (cell.column < cleared)",
        "self.look",
        "tests/hdl/test_cell_selection.py",
        "leave_nothing and amaranth",
    ),
    "cells are not cleared again": Mutation(
        "hdl/cell_insertion.py",
        "m.d.sync += cleared.eq(0)",
        "m.d.sync += cleared.eq(cleared)",
        "tests/hdl/test_cell_selection.py",
        "leave_nothing and amaranth",
    ),
    "the first corner decides how far a row of cells is read": Mutation(
        "hdl/cell_insertion.py",
        "~self.some | (cell.column > self.last_column)",
        "~self.some",
        "tests/hdl/test_cell_selection.py",
        "leave_nothing and amaranth",
    ),
    "the end of a frame is counted as a corner": Mutation(
        "hdl/cell_selection.py",
        "Mux(pass_on & item.last, 0, reported + 1)",
        "Mux(pass_on & item.last, 1, reported + 1)",
        "tests/hdl/test_cell_selection.py",
        "leave_nothing and amaranth",
    ),
    "a frame's last row of cells is not over": Mutation(
        "hdl/cell_grid.py",
        "row_over & (lower | self.eof)",
        "row_over & lower",
        "tests/hdl/test_cell_grid.py",
        "frames and amaranth",
    ),
    "the first cell of a row is as wide as all": Mutation(
        "hdl/cell_grid.py",
        "Mux(starts, first, left)",
        "Mux(starts, whole, left)",
        "tests/hdl/test_cell_grid.py",
        "frames and amaranth",
    ),
    "a first cell of one pixel is skipped": Mutation(
        "hdl/cell_grid.py",
        "Mux(whole >= margin",
        "Mux(whole > margin",
        "tests/hdl/test_cell_grid.py",
        "frames and amaranth",
    ),
    "the limit of a frame holds before cells choose": Mutation(
        "hdl/candidate_selection.py",
        "allowed.eq(chosen | ",
        "allowed.eq(",
        "tests/hdl/test_candidate_selection.py",
        "cells and amaranth",
    ),
    "rejected corners are reported where cells choose": Mutation(
        "hdl/thresholds.py",
        "settings.report_rejected & ~cells",
        "settings.report_rejected",
        "tests/hdl/test_thresholds.py",
        "cells and amaranth",
    ),
}
