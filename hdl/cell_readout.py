"""Cell readout: reads the records of a row of cells, cell by cell, the strongest first."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.cell_insertion import count_bits, record_address_layout
from hdl.parts.probes import probe


class CellReadout(wiring.Component):
    """Reads a row of cells out, each record when there is a place for it.

    Members
    -------
    begin, row, last_column
        Read this row of cells, up to this cell; steady while busy.
    busy
        Records are to be read. It begins a clock after ``begin``.
    read
        ``record_address_layout(parameters)`` of the record that is read next; its cell is the one
        whose number of records is read.
    count_taken, record_taken
        Somebody else reads a number, or a record, in this clock.
    count
        The number that was read two clocks ago.
    free
        There is a place for a record, until one is given.
    given
        The record that was read two clocks ago is the next one.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = p = parameters
        column = range(p.max_cells)
        super().__init__(
            {
                "begin": In(1),
                "row": In(1),
                "last_column": In(column),
                "busy": Out(1),
                "read": Out(record_address_layout(p)),
                "count_taken": In(1),
                "record_taken": In(1),
                "count": In(count_bits(p)),
                "free": In(1),
                "given": Out(1),
            }
        )

    @property
    def clocks(self) -> int:
        """Most clocks for a row of cells, where neither the output nor corners hold it up."""
        return 3 * self._parameters.max_cells * (1 + self._parameters.max_per_cell) + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        left, cell_done = Signal.like(self.count, name="left"), Signal()
        rank, column = Signal.like(self.count, name="rank"), Signal.like(self.last_column, name="column")
        with m.FSM():
            with m.State("LOOK"):
                with m.If(self.busy & ~self.count_taken):
                    m.next = "COUNT"
            with m.State("COUNT"):
                m.next = "START"
            with m.State("START"):
                m.d.sync += [left.eq(self.count), rank.eq(0)]
                m.next = "READ"
                with m.If(self.count == 0):
                    m.d.comb += cell_done.eq(1)
                    m.next = "LOOK"
            with m.State("READ"):
                with m.If(self.free & ~self.record_taken):
                    m.next = "FETCH"
            with m.State("FETCH"):
                m.next = "GIVE"
            with m.State("GIVE"):
                m.d.sync += [left.eq(left - 1), rank.eq(rank + 1)]
                m.d.comb += self.given.eq(1)
                m.next = "READ"
                with m.If(left == 1):
                    m.d.comb += cell_done.eq(1)
                    m.next = "LOOK"
        with m.If(cell_done):
            m.d.sync += column.eq(column + 1)
            with m.If(column == self.last_column):
                m.d.sync += self.busy.eq(0)
        with m.If(self.begin):
            m.d.sync += [self.busy.eq(1), column.eq(0)]
        m.d.comb += [self.read.rank.eq(rank), self.read.row.eq(self.row), self.read.column.eq(column)]
        probe(self, left=left, rank=rank, column=column)
        return m
