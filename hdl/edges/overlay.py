"""Overlay: passes the pixels on, delayed so that each comes with its corner flag."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, ResetInserter, Signal, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.candidate_selection import corner_flag_layout
from hdl.edges.frame_guard import video_layout
from hdl.parts.queue import Queue

_CLOCKS = 128
"""Further pixels that come while the detector works on one, with a reserve."""


def overlay_layout(build: Build) -> data.StructLayout:
    """A beat with its framing, and whether there is an accepted corner (its whole pixel).

    ``corner`` has a bit for each pixel. With several of them per clock ``last_lane`` is the place
    of the beat's last one.
    """
    framed, lanes = video_layout(build).members, build.pixels_per_clock
    return data.StructLayout({"pixel": framed.pop("pixel"), "corner": lanes, **framed})


def overlay_members(build: Build) -> dict[str, wiring.Member]:
    """The members of both overlays, see :class:`Overlay`."""
    return {
        "i": In(stream.Signature(video_layout(build))),
        "corner_flags": In(stream.Signature(corner_flag_layout(build))),
        "restart": In(1),
        "o": Out(stream.Signature(overlay_layout(build))),
        "done": Out(1),
    }


class Overlay(wiring.Component):
    """Delays pixels in block RAM until the detector's corner flags are there.

    There are flags where a corner can be; the outermost pixels have none. A pixel is stored with
    one tag, which on the first pixel of a row means the first of the frame, and elsewhere the last
    of the row.

    It is deep enough that pixels wait only for their flags or for the output, and that it cannot
    lock up: when it is full, it holds more than the detector needs for the flag of the first pixel.

    Members
    -------
    i
        Stream of ``video_layout(build)``: pixels of whole frames.
    corner_flags
        Stream of ``corner_flag_layout(build)``.
    restart
        Forgets all but a beat at the output.
    o
        Stream of ``overlay_layout(build)``, all of it registers.
    done
        A frame's last pixel moves to the output.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        super().__init__(overlay_members(build))

    @property
    def depth(self) -> int:
        """Pixels that it holds."""
        rows = self._build.algorithm.margin + self._build.rows_late
        return rows * self._build.max_width + _CLOCKS

    @property
    def memory_bits(self) -> int:
        return self.depth * (self._build.pixel_bits + 1)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        stored = data.StructLayout({"pixel": unsigned(self._build.pixel_bits), "tag": 1})
        queue = Queue(stored, self.depth)
        m.submodules.pixels = ResetInserter(self.restart)(queue)
        room = Signal()
        m.d.sync += room.eq(queue.room & ~self.restart)
        m.d.comb += [
            self.i.ready.eq(room),
            queue.i.valid.eq(self.i.valid & room),
            queue.i.payload.pixel.eq(self.i.payload.pixel),
            queue.i.payload.tag.eq(self.i.payload.sof | self.i.payload.eol),
        ]

        # columns and rows before the first that can have a flag; right, below: the last flag of
        # the row, or of the frame, has been used
        margin = self._build.algorithm.margin
        column, row = Signal(range(margin + 1)), Signal(range(margin + 1))
        right, below = Signal(), Signal()
        flagged, free, step, eol = Signal(), Signal(), Signal(), Signal()
        tag = queue.o.payload.tag
        m.d.comb += [
            flagged.eq((column == margin) & (row == margin) & ~right & ~below),
            free.eq((~self.o.valid | self.o.ready) & (~flagged | self.corner_flags.valid)),
            step.eq(queue.o.valid & free),
            queue.o.ready.eq(free),
            self.corner_flags.ready.eq(step & flagged),
            eol.eq(tag & (column != 0)),
            self.done.eq(step & eol & below & (row == margin)),
        ]
        with m.If(step):
            m.d.sync += column.eq(Mux(eol, 0, Mux(column == margin, margin, column + 1)))
            with m.If(flagged):
                m.d.sync += right.eq(self.corner_flags.payload.eol)
                with m.If(self.corner_flags.payload.eof):
                    m.d.sync += [below.eq(1), row.eq(0)]
            with m.If(eol):
                m.d.sync += right.eq(0)
                with m.If(row != margin):
                    m.d.sync += row.eq(row + 1)
            with m.If(self.done):
                m.d.sync += [below.eq(0), row.eq(0)]
        with m.If(self.restart):
            m.d.sync += [signal.eq(0) for signal in (column, row, right, below)]

        with m.If(~self.o.valid | self.o.ready):
            m.d.sync += self.o.valid.eq(step & ~self.restart)
        with m.If(step):
            m.d.sync += [
                self.o.payload.pixel.eq(queue.o.payload.pixel),
                self.o.payload.corner.eq(flagged & self.corner_flags.payload.corner),
                self.o.payload.sof.eq(tag & (column == 0)),
                self.o.payload.eol.eq(eol),
            ]
        return m
