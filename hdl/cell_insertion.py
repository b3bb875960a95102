"""Cell insertion: puts each corner among the strongest of its cell, in their order."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import RECORD_BITS, RESPONSE_SHIFT
from golden.parameters import Parameters
from hdl.output_constructor import found_record_layout
from hdl.parts.probes import probe


def record_address_layout(parameters: Parameters) -> data.StructLayout:
    """Where a record lies: its place in its cell, which row of cells, and which cell of it."""
    return data.StructLayout(
        {"rank": range(parameters.max_per_cell), "row": 1, "column": range(parameters.max_cells)}
    )


def cell_address_layout(parameters: Parameters) -> data.StructLayout:
    """Where the number of a cell's records lies."""
    return data.StructLayout({"row": 1, "column": range(parameters.max_cells)})


def count_bits(parameters: Parameters) -> int:
    """Width of the number of a cell's records."""
    return parameters.max_per_cell.bit_length()


class CellInsertion(wiring.Component):
    """Inserts corners into the row of cells that fills.

    The records of a cell are sorted, the strongest first. A new one is compared with them from the
    weakest on: each that is weaker moves down by one place, and what finds no place is surplus. A
    record is copied down while it is compared. If it turns out not to be weaker, the new one comes
    over its copy in the next clock; otherwise the record above it is copied in that clock.
    The numbers of records are cleared, cell by cell, while a row of cells begins; a corner waits
    for this.

    Members
    -------
    i
        Stream of ``found_record_layout(parameters)``, corners only.
    row, begin
        Which row of cells fills; in the next clock another one does.
    look, scan, read
        The number of records, or a record, is to be read at once, and its
        ``record_address_layout(parameters)``.
    count, record
        What was to be read two clocks ago.
    write_count, write_record
        With ``en``, ``data`` is written to ``addr``.
    some, last_column
        The row of cells has a corner; the last of its cells that have.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = p = parameters
        count, record_address = count_bits(p), record_address_layout(p)
        super().__init__(
            {
                "i": In(stream.Signature(found_record_layout(p))),
                "row": In(1),
                "begin": In(1),
                "look": Out(1),
                "scan": Out(1),
                "read": Out(record_address),
                "count": In(count),
                "record": In(RECORD_BITS),
                "write_count": Out(_write_signature(cell_address_layout(p), count)),
                "write_record": Out(_write_signature(record_address, RECORD_BITS)),
                "some": Out(1),
                "last_column": Out(range(p.max_cells)),
            }
        )

    @property
    def clocks(self) -> int:
        """Most clocks for a corner: for one that is stronger than all in its cell, which is full.

        One whose cell is empty takes 4.
        """
        return 5 + self._parameters.max_per_cell

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        record, cell = self.i.payload.record, self.i.payload.cell
        # one of them in every clock
        idle, cleared = Signal(init=1), Signal(range(self._parameters.max_cells + 1))
        counting, start, fetching, step = (
            Signal(name=name) for name in ("counting", "start", "fetching", "step")
        )
        # the record before was weaker; only this is decided by comparing, and in the next clock
        weaker = Signal(init=1)
        begins, top, put = (Signal(name=name) for name in ("begins", "top", "put"))
        m.d.comb += [
            # also while the corner waits, so that no address depends on this comparison
            self.look.eq(idle & self.i.valid),
            begins.eq(self.look & (cell.column < cleared)),
            put.eq(step & (~weaker | top)),
            self.i.ready.eq(put),
            self.scan.eq(start | fetching | step),
        ]
        m.d.sync += [
            idle.eq(put | (idle & ~begins)),
            counting.eq(begins),
            start.eq(counting),
            fetching.eq(start & (self.count != 0)),
            step.eq(fetching | (start & (self.count == 0)) | (step & ~put)),
            weaker.eq(~step | (self._response(self.record) < self._response(record))),
        ]
        self._write(m, start, step, weaker, top)
        m.d.comb += self.write_record.data.eq(Mux(put, record, self.record))
        self._read(m, start)
        self._count(m, start, cleared)
        probe(self, weaker=weaker, cleared=cleared)
        return m

    def _response(self, record: Value) -> Value:
        return record[RESPONSE_SHIFT : RESPONSE_SHIFT + self._parameters.response_bits]

    def _write(self, m: Module, start: Signal, step: Signal, weaker: Signal, top: Signal) -> None:
        """Where a step writes: a place higher than the step before, or over what that one wrote."""
        place = data.StructLayout({"rank": len(self.count), "beyond": 1})
        higher, same, chosen = (Signal(place, name=name) for name in ("higher", "same", "chosen"))
        with m.If(start):
            # beyond the last place is none
            m.d.sync += [
                higher.rank.eq(self.count),
                higher.beyond.eq(self.count == self.i.payload.cell.per_cell),
                top.eq(self.count == 0),
            ]
        with m.If(step):
            m.d.sync += [
                same.eq(higher),
                higher.rank.eq(higher.rank - 1),
                higher.beyond.eq(0),
                top.eq(higher.rank == 1),
            ]
        m.d.comb += [
            chosen.eq(Mux(weaker, higher, same)),
            self.write_record.en.eq(step & ~chosen.beyond),
            self.write_record.addr.rank.eq(chosen.rank),
            self.write_record.addr.row.eq(self.row),
            self.write_record.addr.column.eq(self.i.payload.cell.column),
        ]

    def _read(self, m: Module, start: Value) -> None:
        """The records of the cell are read from the last one on, one per clock."""
        following = Signal.like(self.count, name="following")
        rank = Mux(start, self.count, following) - 1
        m.d.sync += following.eq(rank)
        m.d.comb += [
            self.read.rank.eq(rank),
            self.read.row.eq(self.row),
            self.read.column.eq(self.i.payload.cell.column),
        ]

    def _count(self, m: Module, start: Value, cleared: Signal) -> None:
        """Numbers of records are written when a corner starts, and cleared in all other clocks."""
        cell, clearing = self.i.payload.cell, Signal()
        m.d.comb += [
            clearing.eq(~start & (cleared != self._parameters.max_cells)),
            self.write_count.en.eq(clearing | (start & (self.count != cell.per_cell))),
            self.write_count.addr.row.eq(self.row),
            self.write_count.addr.column.eq(Mux(start, cell.column, cleared)),
            self.write_count.data.eq(Mux(start, self.count + 1, 0)),
        ]
        with m.If(self.begin):
            m.d.sync += cleared.eq(0)
        with m.Elif(clearing):
            m.d.sync += cleared.eq(cleared + 1)
        with m.If(self.begin):
            m.d.sync += self.some.eq(0)
        with m.If(start):
            m.d.sync += self.some.eq(1)
            with m.If(~self.some | (cell.column > self.last_column)):
                m.d.sync += self.last_column.eq(cell.column)


def _write_signature(address: data.StructLayout, width: int) -> wiring.Signature:
    return wiring.Signature({"en": Out(1), "addr": Out(address), "data": Out(width)})
