"""Windows of candidates out of the last beats of columns, one or two columns per clock."""

from __future__ import annotations

import itertools
from typing import Any

from amaranth.hdl import Array, C, Cat, Module, Mux, Shape, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.candidate_queue import place_layout, request_layout
from hdl.parts.lanes import each_lane, lanes_of
from hdl.parts.probes import probe
from hdl.parts.stream import Columns
from hdl.sample import response_layout, responses_shape

SLACK = 32
"""Beats that may still be written once the ring is called full, and those a window reaches back."""


def window_order(build: Build, size: int) -> list[int]:
    """The columns of a window, ``size`` wide, in the order in which they are read.

    From the left; or both halves from the outer column to the centre. With two columns per clock it
    is the left half, and beside each column that which is half a window further right.
    """
    if not build.sums_halves:
        return list(range(size))
    left = list(range(size // 2 + 1))
    return left if build.window_reads == 2 else [*left, *(size - 1 - k for k in left)]


class CandidateRing(wiring.Component):
    """The columns of each candidate's window, one after the other, as a row of their own.

    The last ``Build.ring_beats`` beats of columns lie in block RAM, a memory for each lane.

    Two columns per clock are half a beat apart, so that they lie in different memories: one in the
    lower half of the lanes, the other in the upper half.

    Clocks of a read: 1 block RAM, 2 the register behind it, 3 one of the lanes, or one of each half
    of them and then, in clock 4, which one is the left one.

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
        Stream of ``Columns(lanes_of(response_layout(build), build.window_reads), rows)``, a window
        in :func:`window_order` to a row. ``eof``: it is no candidate, but the end of a frame, and
        the columns mean nothing.
    place
        The place of the window whose last column is on offer.
    """

    def __init__(self, build: Build, rows: int, size: int, late: int) -> None:
        self._build, self._rows, self._newest = build, rows, size - 1 + late
        self._order = window_order(build, size)
        self.latency = 3 + build.window_reads
        """Clocks from a request to the window's first column."""
        sample = lanes_of(response_layout(build), build.window_reads)
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

    @property
    def interval(self) -> int:
        """Clocks from one window to the next, where many wait."""
        return len(self._order)

    @property
    def memory_bits(self) -> int:
        bits = Shape.cast(response_layout(self._build)).width
        return self._build.ring_beats * self._build.pixels_per_clock * self._rows * bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        advance = self.o.ready
        running, count = Signal(), Signal(range(self.interval))
        column = Signal(self.i.payload.column.shape())
        is_last, start = Signal(), Signal()
        m.d.comb += [
            self.i.ready.eq(~running | (is_last & advance)),
            start.eq(self.i.valid & self.i.ready),
        ]
        stride = self._stride(m, count, advance & running)
        now = Signal(place_layout(self._build), reset_less=True)
        with m.If(advance & running):
            m.d.sync += [
                count.eq(count + 1),
                is_last.eq(count == self.interval - 2),
                column.eq(column + stride),
            ]
        with m.If(self.i.ready):
            m.d.sync += [
                running.eq(start),
                count.eq(0),
                is_last.eq(0),
                column.eq(self.i.payload.column - self._newest),
                now.eq(self.i.payload.place),
            ]
        with m.If(advance & running & is_last):
            m.d.sync += self.place.eq(now)
        self._guard(m, running, column)
        half = self._half_further(m, column, stride, advance & running)
        probe(self, running=running, count=count, is_last=is_last, column=column)
        m.d.comb += Value.cast(self.o.payload.data).eq(self._read(m, advance, column, half))
        tags = Cat(running, running & is_last, running & is_last & now.end)
        for k in range(self.latency - 1):
            register = Signal(3, name=f"tags_{k + 1}")
            with m.If(advance):
                m.d.sync += register.eq(tags)
            tags = register
        m.d.comb += Cat(self.o.valid, self.o.payload.eol, self.o.payload.eof).eq(tags)
        return m

    def _stride(self, m: Module, count: Signal, moves: Value) -> Value:
        """From a column to the next: a register, so that only the sum follows."""
        strides = [b - a for a, b in itertools.pairwise(self._order)]
        if set(strides) == {1}:
            return C(1, 1)
        shape = range(-1, max(strides) + 1)
        stride = Signal(shape)
        with m.If(moves):
            m.d.sync += stride.eq(Array(C(value, shape) for value in (*strides[1:], 0))[count])
        with m.If(self.i.ready):
            m.d.sync += stride.eq(strides[0])
        probe(self, stride=stride)
        return stride

    def _half_further(self, m: Module, column: Signal, stride: Value, moves: Value) -> Signal:
        """The column half a beat further right: a register, because its address goes far."""
        lanes = self._build.pixels_per_clock
        if self._build.window_reads == 1:
            return column
        half = Signal.like(column)
        with m.If(moves):
            m.d.sync += half.eq(half + stride)
        with m.If(self.i.ready):
            m.d.sync += half.eq(self.i.payload.column + (lanes // 2 - self._newest))
        probe(self, half=half)
        return half

    def _guard(self, m: Module, running: Signal, column: Signal) -> None:
        """Full: the column that is being read is nearly as old as the ring is long.

        Candidates are read in raster order, so those that wait are younger. Between two windows it
        stays as it is; where none waits, whatever comes is new.
        """
        lane_bits = (self._build.pixels_per_clock - 1).bit_length()
        beats = self._build.ring_beats
        written, age, was_running = Signal(range(beats)), Signal(range(beats)), Signal()
        with m.If(self.step):
            m.d.sync += written.eq(written + 1)
        m.d.sync += [was_running.eq(running), age.eq(written - column[lane_bits:])]
        with m.If(was_running):
            m.d.sync += self.full.eq(age >= beats - SLACK)
        with m.Elif(~running & ~self.waiting):
            m.d.sync += self.full.eq(0)
        self.written = written
        probe(self, written=written, age=age, was_running=was_running)

    def _read(self, m: Module, advance: Value, column: Signal, half: Signal) -> Value:
        """The column, or two of them side by side in each row."""
        build = self._build
        lanes, reads = build.pixels_per_clock, build.window_reads
        lane_bits = (lanes - 1).bit_length()
        beat, beat_before_half = column[lane_bits:], half[lane_bits:]

        def register(value: Value, name: str) -> Signal:
            signal = Signal(len(value), name=name, reset_less=True)
            with m.If(advance):
                m.d.sync += signal.eq(value)
            return signal

        read_out = []
        for k in range(lanes):
            given = Cat(each_lane(self.columns[row], lanes)[k] for row in range(self._rows))
            memory = Memory(shape=len(given), depth=build.ring_beats, init=[], attrs={"ram_style": "block"})
            m.submodules[f"lane_{k}"] = memory
            write, read = memory.write_port(), memory.read_port()
            m.d.comb += [
                write.addr.eq(self.written),
                write.data.eq(given),
                # again and again until it is the column, because an enable would go to all blocks
                write.en.eq(1),
                # of two columns, the right one may lie in the next beat, in the lower lanes
                read.addr.eq(beat_before_half if reads == 2 and k < lanes // 2 else beat),
                read.en.eq(advance),
            ]
            # block RAM is far
            read_out.append(register(read.data, f"read_{k}"))
        lane = register(register(column[:lane_bits], "lane_1"), "lane_2")
        size = lanes // reads
        low = lane[: (size - 1).bit_length()]
        groups = [register(Array(read_out[k : k + size])[low], f"group_{k}") for k in range(0, lanes, size)]
        if reads == 1:
            return groups[0]
        upper = register(lane[-1], "upper")
        left = register(Mux(upper, groups[1], groups[0]), "left")
        right = register(Mux(upper, groups[0], groups[1]), "right")
        bits = len(left) // self._rows
        return Cat(Cat(v[k * bits : (k + 1) * bits] for v in (left, right)) for k in range(self._rows))
