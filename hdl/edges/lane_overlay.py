"""Overlay for several pixels per clock: beats are delayed until their corners are known."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, ResetInserter, Signal
from amaranth.lib import data, wiring

from hdl.build import Build
from hdl.edges.corner_marks import CornerMarks
from hdl.edges.overlay import overlay_members
from hdl.parts.probes import probe
from hdl.parts.queue import Queue
from hdl.sample import pixels_shape

_RESERVE = 128
"""Beats that come while a row's last candidate is decided, beside those that its ring can hold."""


class LaneOverlay(wiring.Component):
    """Delays beats in block RAM until the corners of their row are told, at the latest by its end.

    It does the same as :class:`hdl.edges.overlay.Overlay`, which has a flag for every window. Here
    a beat leaves when a corner to its right, or the end of its row, is known. The outermost rows
    wait for nothing.

    It is deep enough that beats wait only for their corners or for the output, and that it cannot
    lock up: when it is full, it holds more than the detector needs for the end of the first row.

    Members
    -------
    i, corner_flags, restart, o, done
        As in :class:`hdl.edges.overlay.Overlay`, with beats in place of its pixels.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        self._stored = data.StructLayout(
            {"pixel": pixels_shape(build), "last_lane": range(build.pixels_per_clock), "tag": 1}
        )
        super().__init__(overlay_members(build))

    @property
    def depth(self) -> int:
        """Beats that it holds."""
        # a row's end is told one row after the flags of its first window could be
        rows = self._build.algorithm.margin + 1 + self._build.rows_late
        return rows * self._build.beats + self._build.ring_beats + _RESERVE

    @property
    def memory_bits(self) -> int:
        return self.depth * self._stored.size

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        queue, marks = Queue(self._stored, self.depth), CornerMarks(self._build)
        m.submodules.beats = ResetInserter(self.restart)(queue)
        m.submodules.marks = ResetInserter(self.restart)(marks)
        wiring.connect(m, wiring.flipped(self.corner_flags), marks.i)
        room = Signal()
        m.d.sync += room.eq(queue.room & ~self.restart)
        m.d.comb += [
            self.i.ready.eq(room),
            queue.i.valid.eq(self.i.valid & room),
            queue.i.payload.pixel.eq(self.i.payload.pixel),
            queue.i.payload.last_lane.eq(self.i.payload.last_lane),
            # the first of a frame where a row begins, elsewhere the last of the row
            queue.i.payload.tag.eq(self.i.payload.sof | self.i.payload.eol),
        ]

        # rows above the first that can have corners, or, with below, under the last
        margin, mark, stored = self._build.algorithm.margin, marks.o.payload, queue.o.payload
        beat, row, below = Signal(range(self._build.beats)), Signal(range(margin + 1)), Signal()
        flagged, free, step, eol, here = Signal(), Signal(), Signal(), Signal(), Signal()
        m.d.comb += [
            flagged.eq((row == margin) & ~below),
            free.eq((~self.o.valid | self.o.ready) & (~flagged | marks.o.valid)),
            step.eq(queue.o.valid & free),
            queue.o.ready.eq(free),
            eol.eq(stored.tag & (beat != 0)),
            here.eq(flagged & (mark.beat == beat)),
            marks.o.ready.eq(step & flagged & Mux(mark.end, eol, here)),
            self.done.eq(step & eol & below & (row == margin)),
        ]
        with m.If(step):
            m.d.sync += beat.eq(Mux(eol, 0, beat + 1))
        with m.If(step & eol):
            with m.If(self.done):
                m.d.sync += [below.eq(0), row.eq(0)]
            with m.Elif(flagged & mark.eof):
                m.d.sync += [below.eq(1), row.eq(1)]
            with m.Elif(row != margin):
                m.d.sync += row.eq(row + 1)
        with m.If(self.restart):
            m.d.sync += [signal.eq(0) for signal in (beat, row, below)]

        with m.If(~self.o.valid | self.o.ready):
            m.d.sync += self.o.valid.eq(step & ~self.restart)
        with m.If(step):
            m.d.sync += [
                self.o.payload.pixel.eq(stored.pixel),
                self.o.payload.corner.eq(Mux(here, mark.corners, 0)),
                self.o.payload.last_lane.eq(stored.last_lane),
                self.o.payload.sof.eq(stored.tag & (beat == 0)),
                self.o.payload.eol.eq(eol),
            ]
        probe(self, queue=queue, beat=beat, row=row, below=below)
        return m
