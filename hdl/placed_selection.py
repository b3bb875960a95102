"""Candidate selection where candidates come one after the other, and bring their places."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Module, Mux, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from hdl.build import Build
from hdl.candidate_queue import place_layout
from hdl.candidate_selection import CORNER_FLAGS, Selection, corner_flag_layout
from hdl.parts.queue import Queue


class PlacedSelection(Selection):
    """Selects the candidates that are reported: those that the texture filter accepts.

    Candidates are three clocks apart at least. A note comes in the place of a candidate; that of a
    frame's end closes the frame.

    Members
    -------
    place
        ``place_layout(parameters)`` of what is in ``corners``.
    largest
        Largest response of the frame whose end comes.
    corner_flags
        With ``video_out`` only: stream of ``corner_flag_layout(parameters)``, one for each accepted
        corner and one for each note.

    The others are those of :class:`hdl.candidate_selection.Selection`; there is no corner in a
    note.
    """

    def __init__(self, parameters: Build) -> None:
        members = {"place": In(place_layout(parameters)), "largest": In(parameters.response_bits)}
        super().__init__(parameters, members)

    def elaborate(self, platform: Any) -> Module:
        m, p = Module(), self._parameters
        candidates, pending = self._queues(m)
        room, ending, picked = Signal(init=1), Signal(), Signal()
        step, place, verdict = self._take(m, room), self.place, self._verdict
        m.d.comb += ending.eq(step & place.end)
        allowed, (x, y) = C(1), (place.x, place.y)
        if p.budget:
            allowed, (x, y) = self._budget(m, step, ending, (x, y))
        flags_room = self._corner_flags(m, step, allowed) if p.video_out else C(1)
        m.d.sync += room.eq(candidates.room & pending.room & flags_room)
        record = pending.i.payload
        closing = self._cell(m, step, record.cell) if p.max_per_cell else C(0)
        # with the gradient step there is a note of every row
        self._offer(m, candidates, picked, place.x, step & place.note, place.end)
        m.d.comb += [
            picked.eq(step & self.corners.payload.data.corner & verdict.keep & allowed),
            pending.i.valid.eq(picked | ending | closing),
            record.x.eq(x),
            record.y.eq(y),
            record.response.eq(Mux(ending, self.largest, verdict.response)),
            record.textured.eq(verdict.textured),
            record.end.eq(ending),
        ]
        return m

    def _cell(self, m: Module, step: Signal, cell: Any) -> Value:
        """The cell of a pending record; returns whether a row of cells ends."""
        closing = Signal()
        m.d.comb += [
            closing.eq(step & self.place.cells_end),
            cell.column.eq(self.place.column),
            cell.per_cell.eq(self.cells.per_cell),
            cell.row_end.eq(closing),
        ]
        if self._parameters.budget:
            m.d.comb += cell.max_corners.eq(self.max_corners)
        return closing

    def _corner_flags(self, m: Module, step: Signal, allowed: Value) -> Value:
        """Accepted corners and notes into a queue of their own; returns whether that has room."""
        m.submodules.corner_flags = flags = Queue(corner_flag_layout(self._parameters), CORNER_FLAGS)
        wiring.connect(m, flags.o, wiring.flipped(self.corner_flags))
        corner = self.corners.payload.data.corner & ~self._verdict.textured & allowed
        m.d.comb += [
            flags.i.valid.eq(step & (corner | self.place.note)),
            flags.i.payload.x.eq(self.place.x),
            flags.i.payload.corner.eq(corner),
            flags.i.payload.eof.eq(self.place.end),
        ]
        return flags.room
