"""Windows of candidates out of the last beats of columns, one column per clock."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Array, Cat, Module, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.candidate_queue import RING_BEATS, RING_BITS, place_layout, request_layout
from hdl.parts.lanes import each_lane
from hdl.parts.stream import Columns
from hdl.sample import response_layout, responses_shape

SLACK = 32
"""Beats that may still be written once the ring is called full, and those a window reaches back."""


class CandidateRing(wiring.Component):
    """The columns of each candidate's window, one after the other, as a row of their own.

    The last 256 beats of columns lie in block RAM, a memory for each lane.

    Parameters
    ----------
    build
        Parameters of the detector.
    rows
        Rows of a column.
    size
        Columns of a window, 3 or more.
    late
        Columns by which the window's last column is behind the newest of the request.

    Members
    -------
    columns, step
        A beat of columns, and in this clock it is written.
    i
        Stream of ``request_layout(build)``.
    waiting
        Others wait behind the window that is being read.
    full
        A register: as good as no place is left that a window will not need.
    o
        Stream of ``Columns(response_layout(build), rows)``, ``size`` to a row. ``eof``: it is no
        candidate, but the end of a frame, and the columns mean nothing.
    place
        The place of the window whose last column is on offer.
    """

    latency = 4
    """Clocks from a request to the window's first column."""

    @property
    def interval(self) -> int:
        """Clocks from one window to the next, where many wait."""
        return self._size

    def __init__(self, build: Build, rows: int, size: int, late: int) -> None:
        self._build, self._rows, self._size, self._late = build, rows, size, late
        sample = response_layout(build)
        super().__init__(
            {
                "columns": In(data.ArrayLayout(responses_shape(build), rows)),
                "step": In(1),
                "i": In(stream.Signature(request_layout(build))),
                "waiting": In(1),
                "full": Out(1),
                "o": Out(stream.Signature(Columns(sample, rows))),
                "place": Out(place_layout(build)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        advance = self.o.ready
        running, count = Signal(), Signal(range(self._size))
        column = Signal(self.i.payload.column.shape())
        is_last, start = Signal(), Signal()
        m.d.comb += [
            is_last.eq(count == self._size - 1),
            self.i.ready.eq(~running | (is_last & advance)),
            start.eq(self.i.valid & self.i.ready),
        ]
        now = Signal(place_layout(self._build), reset_less=True)
        with m.If(advance & running):
            m.d.sync += [count.eq(count + 1), column.eq(column + 1)]
        with m.If(self.i.ready):
            m.d.sync += [
                running.eq(start),
                count.eq(0),
                column.eq(self.i.payload.column - (self._size - 1 + self._late)),
                now.eq(self.i.payload.place),
            ]
        with m.If(advance & running & is_last):
            m.d.sync += self.place.eq(now)
        self._guard(m, running, column)
        m.d.comb += Value.cast(self.o.payload.data).eq(self._read(m, advance, column))
        tags = Cat(running, running & is_last, running & is_last & now.end)
        for k in range(self.latency - 1):
            register = Signal(3, name=f"tags_{k + 1}")
            with m.If(advance):
                m.d.sync += register.eq(tags)
            tags = register
        m.d.comb += Cat(self.o.valid, self.o.payload.eol, self.o.payload.eof).eq(tags)
        return m

    def _guard(self, m: Module, running: Signal, column: Signal) -> None:
        """Full: the column that is being read is nearly as old as the ring is long.

        Candidates are read in raster order, so those that wait are younger. Between two windows it
        stays as it is; where none waits, whatever comes is new.
        """
        lane_bits = (self._build.pixels_per_clock - 1).bit_length()
        written, age, was_running = Signal(RING_BITS), Signal(RING_BITS), Signal()
        with m.If(self.step):
            m.d.sync += written.eq(written + 1)
        m.d.sync += [was_running.eq(running), age.eq(written - column[lane_bits:])]
        with m.If(was_running):
            m.d.sync += self.full.eq(age >= RING_BEATS - SLACK)
        with m.Elif(~running & ~self.waiting):
            m.d.sync += self.full.eq(0)
        self.written = written

    def _read(self, m: Module, advance: Value, column: Signal) -> Value:
        lanes = self._build.pixels_per_clock
        lane_bits = (lanes - 1).bit_length()
        read_out = []
        for k in range(lanes):
            given = Cat(each_lane(self.columns[row], lanes)[k] for row in range(self._rows))
            memory = Memory(shape=len(given), depth=RING_BEATS, init=[], attrs={"ram_style": "block"})
            m.submodules[f"lane_{k}"] = memory
            write, read = memory.write_port(), memory.read_port()
            m.d.comb += [
                write.addr.eq(self.written),
                write.data.eq(given),
                write.en.eq(self.step),
                read.addr.eq(column[lane_bits:]),
                read.en.eq(advance),
            ]
            # block RAM is far
            register = Signal(len(given), name=f"read_{k}", reset_less=True)
            with m.If(advance):
                m.d.sync += register.eq(read.data)
            read_out.append(register)
        lane_1, lane_2 = Signal(lane_bits, reset_less=True), Signal(lane_bits, reset_less=True)
        selected = Signal(len(read_out[0]), reset_less=True)
        with m.If(advance):
            m.d.sync += [
                lane_1.eq(column[:lane_bits]),
                lane_2.eq(lane_1),
                selected.eq(Array(read_out)[lane_2]),
            ]
        return selected
