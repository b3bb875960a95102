"""Circular buffer (Sec. 4.1, Fig. 10): rows held in block RAM, delivered as columns of a window.

The paper delivers N×N windows. Here a buffer delivers the window's newest column, and each block
that follows keeps the columns it needs: the N×N registers of Fig. 10 without those that nobody
reads.
"""

from __future__ import annotations

from typing import Any, cast

from amaranth.hdl import Array, Cat, Module, Mux, Shape, ShapeLike, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.build import Buffering
from hdl.parts.stream import Beat, Columns, Pipeline

FAR_BITS = 256
"""Bits of a memory's word above which its read address goes to so many blocks that no logic may
come before it."""


class CircularBuffer(wiring.Component):
    """Columns of N rows out of a raster.

    Takes a raster of any width from 3 to ``max_width`` and any height, and delivers, once N rows
    have come, one column of N values for each further position: (height-N+1) rows of ``width``
    columns. Rows of different frames never meet in a column. One beat per clock.

    Parameters
    ----------
    shape
        Shape of one value.
    rows
        N, the height of the window.
    max_width
        Longest row.
    buffering
        ``"lean"``: N-1 rows in one memory, the incoming value forwarded as the column's last.
        ``"banked"``: N+1 memories of one row, one written while N are read, roles rotating row by
        row. A row is read out once it is complete, while the next one is written, or by itself if
        none comes.
    registers
        With ``"lean"``: additional registers behind the columns, so that the path of the next block
        does not begin in block RAM. ``"banked"`` has them already, behind its multiplexers.
    reads_ahead
        With ``"lean"``: the memory is read for the next column while this one comes, one clock
        earlier. So the incoming value waits in one register less.
    tags_first
        With ``reads_ahead``: a beat's value comes a clock after its tags, which is a clock in which
        the buffer moves. So the incoming value waits in no register, and the source's must hold it.

    Attributes
    ----------
    filled
        With ``reads_ahead`` and ``"lean"`` only: a beat that is taken now completes a column.

    Members
    -------
    i
        Stream of ``Beat(shape)``.
    o
        Stream of ``Columns(shape, rows)``.
    """

    def __init__(
        self,
        shape: ShapeLike,
        rows: int,
        max_width: int,
        buffering: Buffering,
        registers: int = 0,
        *,
        reads_ahead: bool = False,
        tags_first: bool = False,
    ) -> None:
        self._shape = Shape.cast(shape)
        self._rows = rows
        self._max_width = max_width
        self._buffering = buffering
        self._registers = registers if buffering == "lean" else 0
        self._reads_ahead = reads_ahead
        self._tags_first = tags_first
        self.filled = Signal()
        super().__init__(
            {"i": In(stream.Signature(Beat(shape))), "o": Out(stream.Signature(Columns(shape, rows)))}
        )

    @property
    def latency(self) -> int:
        """Clocks from a beat to its column, or (banked) from a row's end to its first column."""
        return 2 - self._reads_ahead + self._registers if self._buffering == "lean" else 5

    @property
    def memory_bits(self) -> int:
        rows = self._rows - 1 if self._buffering == "lean" else self._rows + 1
        return rows * self._max_width * self._shape.width

    def elaborate(self, platform: Any) -> Module:
        return self._lean() if self._buffering == "lean" else self._banked()

    def _lean(self) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        width = self._shape.width
        stored = self._rows - 1
        m.submodules.rows = memory = Memory(shape=width * stored, depth=self._max_width, init=[])
        read, write = memory.read_port(), memory.write_port()

        def wait(value: Value, name: str, *, reset: bool = False) -> Value:
            return value if self._reads_ahead else pipe.register(value, name, reset=reset)

        # one clock for the memory's own register, one for ours behind it
        step = pipe.valid & pipe.advance
        rows_seen = Signal(range(self._rows))
        foresees = width * stored > FAR_BITS
        last = Signal(range(self._max_width), init=self._max_width - 1)
        if self._reads_ahead:
            # what is read waits for its beat; no adder comes before the address
            m.d.comb += read.en.eq(step)
            if foresees:
                # the end of a row is foreseen. What is read before a frame's first row ends means
                # nothing, and that end tells how long the rows are
                following = Mux(read.addr == last, 0, read.addr + 1)
                with m.If(step):
                    m.d.sync += read.addr.eq(Mux(rows_seen == 0, self.i.payload.eol, following))
            else:
                after_next = Signal(range(self._max_width))
                m.d.comb += read.addr.eq(Mux(self.i.payload.eol, 0, after_next))
                with m.If(step):
                    m.d.sync += after_next.eq(read.addr + 1)
        else:
            x = Signal(range(self._max_width))
            with m.If(step):
                m.d.sync += x.eq(Mux(self.i.payload.eol, 0, x + 1))
            m.d.comb += [read.addr.eq(x), read.en.eq(pipe.advance)]
        arrived = wait(pipe.valid, "arrived", reset=True)
        eol, eof = (wait(tag, "arrived_tag") for tag in (self.i.payload.eol, self.i.payload.eof))
        tags = pipe.register(Cat(eol, eof), "tags")

        complete = rows_seen == stored
        if self._reads_ahead:
            m.d.comb += self.filled.eq(complete)
        with m.If(arrived & eol & pipe.advance):
            with m.If(eof):
                m.d.sync += rows_seen.eq(0)
            with m.Elif(~complete):
                m.d.sync += rows_seen.eq(rows_seen + 1)
        ends = pipe.register(arrived & complete, "valid", reset=True)
        newest = wait(Value.cast(self.i.payload.data), "newest")
        if self._tags_first:
            column: Value = Cat(pipe.register(read.data, "column"), newest)
        else:
            column = pipe.register(Cat(read.data, newest), "column")

        # each row moves up by one: what was read, less its oldest value, goes back with the newest
        # one below
        store = pipe.register(arrived, "store", reset=True)
        with m.If(store & pipe.advance):
            m.d.sync += write.addr.eq(Mux(tags[0], 0, write.addr + 1))
        if self._reads_ahead and foresees:
            with m.If(store & tags[0]):
                m.d.sync += last.eq(write.addr)
        m.d.comb += [
            write.data.eq(column[width:]),
            write.en.eq(store),
            self.o.valid.eq(pipe.delay(ends, self._registers, "last_valid", reset=True)),
            self.o.payload.eq(pipe.delay(Cat(column, tags), self._registers, "last")),
        ]
        return m

    def _banked(self) -> Module:
        m = Module()
        banks = self._rows + 1
        width = self._shape.width
        memories = [Memory(shape=width, depth=self._max_width, init=[]) for _ in range(banks)]
        for k, memory in enumerate(memories):
            m.submodules[f"bank_{k}"] = memory
        bank_type, column_type = range(banks), range(self._max_width)

        def following(bank: Signal) -> Signal:
            result = Signal(bank_type, name="following")
            m.d.comb += result.eq(bank + 1)
            with m.If(bank == banks - 1):
                m.d.comb += result.eq(0)
            return result

        # Read-out of the newest complete row and the N-1 before it. A row that completes meanwhile
        # is pending.
        reading, pending, last_read = Signal(), Signal(), Signal()
        read_x, read_last, pending_last = (
            Signal(column_type, name=n) for n in ("read_x", "read_last", "pending_last")
        )
        read_eof, pending_eof = Signal(), Signal()
        read_newest, pending_newest = Signal(bank_type), Signal(bank_type)

        # Writing. A bank that the read-out still needs may be overwritten only behind it, column by
        # column.
        write_x, write_bank = Signal(column_type), Signal(bank_type)
        rows_seen = Signal(range(self._rows))
        complete = rows_seen == self._rows - 1
        spare = write_bank == following(read_newest)
        next_bank = following(write_bank)
        behind = Signal()
        allowed = (~reading | spare | behind) & ~(pending & self.i.payload.eol)
        step, row_done = Signal(), Signal()
        # a clock ahead, so that the comparison is no part of the handshake: neither moves by more
        # than one
        m.d.sync += behind.eq(Mux(row_done, read_x != 0, write_x + 1 < read_x) & ~last_read)
        m.d.comb += [
            self.i.ready.eq(allowed),
            step.eq(self.i.valid & self.i.ready),
            row_done.eq(step & self.i.payload.eol),
        ]
        with m.If(step):
            m.d.sync += write_x.eq(write_x + 1)
        with m.If(row_done):
            m.d.sync += [write_x.eq(0), write_bank.eq(next_bank)]
            with m.If(self.i.payload.eof):
                m.d.sync += rows_seen.eq(0)
            with m.Elif(~complete):
                m.d.sync += rows_seen.eq(rows_seen + 1)
        for k, memory in enumerate(memories):
            port = memory.write_port()
            m.d.comb += [
                port.addr.eq(write_x),
                port.data.eq(self.i.payload.data),
                port.en.eq(step & (write_bank == k)),
            ]

        advance = Signal()
        m.d.comb += [
            advance.eq(~self.o.valid | self.o.ready),
            last_read.eq(reading & advance & (read_x == read_last)),
        ]
        with m.If(reading & advance):
            m.d.sync += read_x.eq(read_x + 1)
        with m.If(last_read | ~reading):
            m.d.sync += [
                reading.eq(pending),
                pending.eq(0),
                read_x.eq(0),
                read_last.eq(pending_last),
                read_eof.eq(pending_eof),
                read_newest.eq(pending_newest),
            ]
        with m.If(row_done & complete):
            m.d.sync += [
                pending.eq(1),
                pending_last.eq(write_x),
                pending_eof.eq(self.i.payload.eof),
                pending_newest.eq(write_bank),
            ]

        # memory register, our register behind it, then the rotation that puts the rows in order
        values = []
        for k, memory in enumerate(memories):
            port = memory.read_port()
            m.d.comb += [port.addr.eq(read_x), port.en.eq(advance)]
            value = Signal(width, name=f"value_{k}", reset_less=True)
            with m.If(advance):
                m.d.sync += value.eq(port.data)
            values.append(value)
        eol = read_x == read_last
        stages = [Cat(reading, eol, eol & read_eof, read_newest)]
        for k in range(3):
            stage = Signal(len(stages[0]), name=f"stage_{k + 1}")
            with m.If(advance):
                m.d.sync += stage.eq(stages[-1])
            stages.append(stage)
        newest = cast(Signal, stages[2][3:])
        column = Signal(width * self._rows, reset_less=True)
        rotated = Array(
            # the row above the newest lies in the bank before it, and so on, all the way round
            [
                Cat(values[(bank - age) % banks] for age in reversed(range(self._rows)))
                for bank in range(banks)
            ]
        )
        with m.If(advance):
            m.d.sync += column.eq(rotated[newest])
        m.d.comb += [self.o.valid.eq(stages[3][0]), self.o.payload.eq(Cat(column, stages[3][1:3]))]
        return m
