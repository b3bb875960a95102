# amaranth: UnusedElaboratable=no
"""Cell selection: the strongest corners of each cell (``golden.cell_selection``)."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.formats import BUDGET_BITS
from golden.output_constructor import COUNT_BITS, RECORD_BITS
from golden.parameters import Parameters
from hdl.cell_insertion import CellInsertion, count_bits
from hdl.cell_readout import CellReadout
from hdl.output_constructor import found_record_layout, record_layout
from hdl.parts.probes import probe


class CellSelection(wiring.Component):
    """Passes on the strongest corners of each cell, once its row of cells is complete.

        records ┬ insertion ─ two rows of cells ─ readout ┬ records
                └──────────────── ends ───────────────────┘

    A block RAM holds two rows of cells: one fills while the one before it is read out. So a corner
    waits for the corner before it, but not for the output, unless that stalls until both are full.
    Another block RAM has the number of records of each cell. Where cells do not choose, all records
    are passed on.

    Members
    -------
    i
        Stream of ``found_record_layout(parameters)``.
    o
        Stream of ``record_layout()``. All of it except its ready comes from registers.
    found
        Corners of the frame whose end-of-frame record is on offer, not only those reported.
    """

    latency = 1

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.insertion = CellInsertion(parameters)
        self.readout = CellReadout(parameters)
        super().__init__(
            {
                "i": In(stream.Signature(found_record_layout(parameters))),
                "o": Out(stream.Signature(record_layout())),
                "found": Out(COUNT_BITS),
            }
        )

    @property
    def memory_bits(self) -> int:
        """Two rows of cells: records of each, as many as a power of two, and their number."""
        records = 1 << (self._parameters.max_per_cell - 1).bit_length()
        return 2 * self._parameters.max_cells * (records * RECORD_BITS + count_bits(self._parameters))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.insertion = insertion = self.insertion
        m.submodules.readout = readout = self.readout
        item, cell, valid = self.i.payload, self.i.payload.cell, self.i.valid
        # the row of cells is over that ends with the frame, whose end is still on offer
        row_over, filling = Signal(), Signal()
        passes, turn, pass_on, free = (Signal(name=name) for name in ("passes", "turn", "pass_on", "free"))
        m.d.comb += [
            free.eq(~self.o.valid | self.o.ready),
            passes.eq(Mux(item.last, row_over | ~cell.row_end, cell.per_cell == 0)),
            turn.eq(valid & cell.row_end & ~row_over & ~readout.busy),
            pass_on.eq(valid & passes & ~readout.busy & free),
            insertion.i.payload.eq(item),
            insertion.i.valid.eq(valid & ~passes & ~cell.row_end),
            self.i.ready.eq(pass_on | (turn & ~item.last) | insertion.i.ready),
        ]
        with m.If(turn):
            m.d.sync += [filling.eq(~filling), row_over.eq(item.last)]
        with m.If(pass_on):
            m.d.sync += row_over.eq(0)
        m.d.comb += [
            insertion.row.eq(filling),
            insertion.begin.eq(turn),
            readout.row.eq(~filling),
            readout.begin.eq(turn & insertion.some),
            readout.free.eq(free),
        ]
        with m.If(turn):
            m.d.sync += readout.last_column.eq(insertion.last_column)
        self._output(m, pass_on, turn, free, self._memories(m))
        probe(self, row_over=row_over, filling=filling)
        return m

    def _memories(self, m: Module) -> Signal:
        """Both memories; returns the record that was to be read two clocks ago.

        The insertion may read in every clock, and the readout in those that it leaves.
        """
        insertion, readout = self.insertion, self.readout
        first, second = Value.cast(insertion.read), Value.cast(readout.read)
        rank_bits = len(insertion.read.rank)
        cells = 2 * self._parameters.max_cells
        count = _memory(
            m, "counts", cells, insertion.write_count, Mux(insertion.look, first, second)[rank_bits:]
        )
        record = _memory(
            m, "records", cells << rank_bits, insertion.write_record, Mux(insertion.scan, first, second)
        )
        m.d.comb += [
            insertion.count.eq(count),
            insertion.record.eq(record),
            readout.count.eq(count),
            readout.count_taken.eq(insertion.look),
            readout.record_taken.eq(insertion.scan),
        ]
        return record

    def _output(self, m: Module, pass_on: Signal, turn: Signal, free: Signal, record: Signal) -> None:
        """Records that are given or passed on, as many as the frame may have, and its end."""
        item, reported, allowed = self.i.payload, Signal(COUNT_BITS), Signal(init=1)
        given = self.readout.given & allowed
        if self._parameters.budget:
            limit = Signal(BUDGET_BITS)
            with m.If(turn):
                m.d.sync += limit.eq(item.cell.max_corners)
            # a clock late, which is before the next record is given
            m.d.sync += allowed.eq((limit == 0) | (reported != limit))
        with m.If(free):
            m.d.sync += self.o.valid.eq(pass_on | given)
        with m.If(pass_on | given):
            m.d.sync += [
                reported.eq(Mux(pass_on & item.last, 0, reported + 1)),
                self.o.payload.last.eq(pass_on & item.last),
                self.o.payload.record.eq(record),
            ]
        with m.If(pass_on):
            m.d.sync += self.o.payload.record[COUNT_BITS:].eq(item.record[COUNT_BITS:])
            m.d.sync += self.o.payload.record[:COUNT_BITS].eq(
                Mux(item.last, reported, item.record[:COUNT_BITS])
            )
        with m.If(pass_on & item.last):
            m.d.sync += self.found.eq(item.record[:COUNT_BITS])
        probe(self, reported=reported, allowed=allowed)


def _memory(m: Module, name: str, depth: int, write: Any, read: Value) -> Signal:
    """A block RAM; returns what was to be read two clocks ago.

    The second clock is that of a register which becomes a part of the block RAM.
    """
    memory = Memory(shape=len(write.data), depth=depth, init=[], attrs={"ram_style": "block"})
    m.submodules[name] = memory
    read_port, write_port = memory.read_port(), memory.write_port()
    result = Signal(len(write.data), name=f"read_{name}", reset_less=True)
    m.d.comb += [
        read_port.addr.eq(read),
        write_port.en.eq(write.en),
        write_port.addr.eq(Value.cast(write.addr)),
        write_port.data.eq(write.data),
    ]
    m.d.sync += result.eq(read_port.data)
    return result
