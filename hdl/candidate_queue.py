"""Candidates one after the other: beats with peaks wait, their lanes are taken in turn."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import COORDINATE_BITS, OFFSET_BITS
from hdl.build import Build
from hdl.cell_beats import CellBeats
from hdl.cell_grid import cell_settings_layout
from hdl.parts.optional import optional
from hdl.parts.probes import probe
from hdl.parts.queue import Queue
from hdl.peak_mask import mask_layout
from hdl.step_layouts import reads_pixels

PLACE_BITS = COORDINATE_BITS - OFFSET_BITS


def place_layout(build: Build) -> data.StructLayout:
    """Pixel of a candidate; with ``note`` it is none, but the end of a row of windows.

    ``end``: and that of a frame. With ``max_per_cell`` there are the number of the cell in its row,
    and whether a row of cells ends, too.
    """
    cells = {"column": range(build.max_cells), "cells_end": 1}
    return data.StructLayout(
        {
            "x": PLACE_BITS,
            "y": PLACE_BITS,
            "note": 1,
            "end": 1,
            **optional(build.max_per_cell > 0, **cells),
        }
    )


def request_layout(build: Build) -> data.StructLayout:
    """The window's newest column in the ring, and its centre's place."""
    lane_bits = (build.pixels_per_clock - 1).bit_length()
    return data.StructLayout({"column": _ring_bits(build) + lane_bits, "place": place_layout(build)})


def _ring_bits(build: Build) -> int:
    return (build.ring_beats - 1).bit_length()


def _entry_layout(build: Build) -> data.StructLayout:
    lanes = build.pixels_per_clock
    cells = {"column": range(build.max_cells), "last_lane": range(lanes), "cells_end": 1}
    return data.StructLayout(
        {
            "mask": lanes,
            "note": 1,
            "end": 1,
            "ring": _ring_bits(build),
            "beat": PLACE_BITS - (lanes - 1).bit_length(),
            "y": PLACE_BITS,
            **optional(build.max_per_cell > 0, **cells),
        }
    )


class CandidateQueue(wiring.Component):
    """Places of peaks in raster order, and notes of ends behind them.

    Beats that hold a peak, or need a note, wait in a queue. At its output the lanes are taken from
    the left, one per clock, and then the note. Every frame's end has one; with ``video_out`` or
    gradient steps every row's, and where cells choose, every row of cells.

    Members
    -------
    i
        Stream of ``mask_layout(lanes)``, which is ready as long as there is room: a register.
    full
        The ring has no room, or there are no thresholds yet; it closes the input a clock later.
    cells
        With ``max_per_cell`` only: as in :class:`hdl.candidate_selection.Selection`.
    o
        Stream of ``request_layout(build)``.
    waiting
        There is a candidate here that is at least three clocks old.
    """

    latency = Queue.latency + 3

    def __init__(self, build: Build) -> None:
        self._build = build
        super().__init__(
            {
                "i": In(stream.Signature(mask_layout(build.pixels_per_clock))),
                "full": In(1),
                **optional(build.max_per_cell > 0, cells=In(cell_settings_layout())),
                "o": Out(stream.Signature(request_layout(build))),
                "waiting": Out(1),
            }
        )

    @property
    def beats(self) -> int:
        """Most beats that are here: one waits behind the memory, one is taken, one leaves."""
        return self._build.candidate_beats + 3

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.entries = entries = Queue(
            _entry_layout(self._build), self._build.candidate_beats, registered=True
        )
        room, step = Signal(init=1), Signal()
        marks, entry = self.i.payload, entries.i.payload
        m.d.sync += room.eq(entries.room & ~self.full)
        m.d.comb += [self.i.ready.eq(room), step.eq(self.i.valid & room)]
        probe(self, room=room, given=entry)
        starts = self._count(m, step, entry)
        every_row = self._build.video_out or reads_pixels(self._build)
        noted = marks.eol if every_row else marks.eof
        if self._build.max_per_cell:
            noted |= self._cells(m, step, starts, entry)
        m.d.comb += [
            entries.i.valid.eq(step & (marks.mask.any() | noted)),
            entry.mask.eq(marks.mask),
            entry.note.eq(noted),
            entry.end.eq(marks.eof),
        ]
        self._take(m, entries)
        return m

    def _count(self, m: Module, step: Signal, entry: Any) -> Value:
        """Where a beat is in the ring and in the frame, by its newest pixels.

        Returns whether there is no complete window before it in its row.
        """
        algorithm, lanes, marks = self._build.algorithm, self._build.pixels_per_clock, self.i.payload
        first = 2 * algorithm.response_margin // lanes
        ring = Signal.like(entry.ring, name="ring")
        beat, y = Signal.like(entry.beat, name="beat", init=first), Signal(PLACE_BITS, init=algorithm.margin)
        with m.If(step):
            m.d.sync += [ring.eq(ring + 1), beat.eq(Mux(marks.eol, first, beat + 1))]
            with m.If(marks.eol):
                m.d.sync += y.eq(Mux(marks.eof, algorithm.margin, y + 1))
        m.d.comb += [entry.ring.eq(ring), entry.beat.eq(beat), entry.y.eq(y)]
        return beat <= 2 * algorithm.margin // lanes

    def _cells(self, m: Module, step: Signal, starts: Value, entry: Any) -> Value:
        """The cells of a beat; returns whether a row of them ends."""
        m.submodules.cell_beats = beats = CellBeats(self._build)
        ends = Signal(name="cells_end")
        m.d.comb += [
            beats.step.eq(step),
            beats.eol.eq(self.i.payload.eol),
            beats.eof.eq(self.i.payload.eof),
            beats.starts.eq(starts),
            beats.settings.eq(self.cells),
            ends.eq(beats.row_end & (self.cells.per_cell != 0)),
            entry.column.eq(beats.column),
            entry.last_lane.eq(beats.last_lane),
            entry.cells_end.eq(ends),
        ]
        return ends

    def _take(self, m: Module, entries: Queue) -> None:
        lanes, margin = self._build.pixels_per_clock, self._build.algorithm.margin
        entry = entries.o.payload
        # what is left of the beat: a bit for each lane, and the note behind them; it was looked at
        left, begun = Signal(lanes + 1), Signal()
        rest = left & (left - 1)[: lanes + 1]
        lane, note = Signal((lanes - 1).bit_length()), ~left[:lanes].any()
        for k in reversed(range(lanes)):
            with m.If(left[k]):
                m.d.comb += lane.eq(k)
        free = Signal()
        m.d.comb += [
            free.eq(~self.o.valid | self.o.ready),
            # two clocks of its own for each beat, so that the queue's enables hang on these alone;
            # a window takes more clocks anyhow
            entries.o.ready.eq((left == 0) & begun),
            self.waiting.eq(self.o.valid | entries.waiting),
        ]
        request = self.o.payload
        with m.If(free):
            m.d.sync += [
                left.eq(rest),
                self.o.valid.eq(left != 0),
                request.column.eq(Cat(lane, entry.ring)),
                request.place.x.eq(Cat(lane, entry.beat) - margin),
                request.place.y.eq(entry.y),
                request.place.note.eq(note),
                request.place.end.eq(note & entry.end),
            ]
            if self._build.max_per_cell:
                m.d.sync += [
                    request.place.column.eq(entry.column + (lane > entry.last_lane)),
                    request.place.cells_end.eq(note & entry.cells_end),
                ]
        with m.If(~begun):
            m.d.sync += begun.eq(entries.o.valid)
            with m.If(entries.o.valid):
                m.d.sync += left.eq(Cat(entry.mask, entry.note))
        with m.Elif(entries.o.ready):
            m.d.sync += begun.eq(0)
        probe(self, entries=entries, entry=entry, begun=begun, left=left)
