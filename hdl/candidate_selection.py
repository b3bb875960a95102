"""Candidate selection: joins corner detection, texture filter and subpixel equations."""

from __future__ import annotations

from typing import Any, NamedTuple

from amaranth.hdl import C, Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import BUDGET_BITS, COORDINATE_BITS, OFFSET_BITS
from golden.output_constructor import COUNT_BITS
from golden.parameters import Parameters
from golden.textures import TEXTURES
from hdl.build import Build
from hdl.cell_grid import CellGrid, cell_layout, cell_settings_layout
from hdl.corner_detection import corner_layout
from hdl.fits import candidate_layout, derivatives_layout
from hdl.parts.optional import optional
from hdl.parts.probes import probe
from hdl.parts.queue import Queue
from hdl.parts.stream import Beat
from hdl.step_layouts import reads_pixels, rows_kept, steps_in_flight
from hdl.textures import texture_layout

PIXEL_COORDINATE_BITS = COORDINATE_BITS - OFFSET_BITS


def pending_record_layout(parameters: Parameters) -> data.StructLayout:
    """What a record needs besides the offset. With ``end`` it is the end of a frame, not a corner.

    The response of an end is the frame's largest. With ``budget`` its x and y are, side by side,
    the number of corners that the frame had. With ``max_per_cell`` there is a ``cell_layout``,
    whose ``row_end`` is the end of a row of cells, which may be a frame's end, too.
    """
    return data.StructLayout(
        {
            "x": PIXEL_COORDINATE_BITS,
            "y": PIXEL_COORDINATE_BITS,
            "response": parameters.response_bits,
            "textured": 1,
            "end": 1,
            **optional(parameters.max_per_cell > 0, cell=cell_layout(parameters)),
        }
    )


def corner_flag_layout(build: Build) -> data.StructLayout:
    """Which pixels are accepted corners.

    With one pixel per clock one flag for each window: is its centre a corner; is it the last of its
    row, of its frame. With several one for each accepted corner, with the column of its pixel, and
    one without ``corner`` behind the last verdict of each row of windows, with ``eof`` behind that
    of a frame. They come in raster order.
    """
    if build.pixels_per_clock == 1:
        return data.StructLayout({"corner": 1, "eol": 1, "eof": 1})
    return data.StructLayout({"x": PIXEL_COORDINATE_BITS, "corner": 1, "eof": 1})


CORNER_FLAGS = 16
"""Corner flags that can wait: more than can come before their sink holds them up."""
INSIDE = 4
"""Candidates inside a unit of the subpixel refinement and at its end: their records wait too."""


class _Verdict(NamedTuple):
    """What the texture filter says; without one, every corner is kept."""

    textured: Value
    keep: Value
    response: Value
    """The response in a record: that of the texture filter, if it gives one."""


class Selection(wiring.Component):
    """Queues of what is reported, and what decides about it; others say where that is.

    Every candidate goes out twice: its derivatives to the subpixel refinement, and a pending record
    of the rest to the output constructor. Each frame is closed by one more pending record, with
    ``end``. Both wait in queues, whose filling alone decides, in a register, whether the blocks
    before may move: these are always in step with each other.

    With ``budget``, once a frame has had ``max_corners`` that the texture filter accepts, no more
    of its corners are picked; 0 is no limit. All are counted. Where cells choose, the limit comes
    after them, in another block.

    Members
    -------
    corners
        Stream of ``Beat(corner_layout(parameters))`` from corner detection.
    textures
        With a texture filter only: stream of ``Beat(texture_layout(parameters))``, for the same
        centres in the same clocks.
    surfaces
        Stream of ``derivatives_layout(parameters)`` from the surface fit, for the same centres in
        the same clocks.
    candidate
        Stream of ``candidate_layout(parameters)``.
    pending
        Stream of ``pending_record_layout(parameters)``.
    last
        In this clock the frame's last window leaves.
    corner_flags
        With ``video_out`` only: stream of ``corner_flag_layout(parameters)``.
    max_corners, rank
        With ``budget`` only: the limit, and whether textured peaks are counted, too; steady from
        before a frame's first window to its last.
    cells
        With ``max_per_cell`` only: ``cell_settings_layout()``, steady from two clocks before a
        frame's first window to its last.
    counted, strength
        With ``budget`` only: in this clock there is a corner that counts whatever T1 is, and its
        response.
    picked, row
        With the gradient step only: in this clock there is a candidate, and the row of pixels that
        it would have as its place's.
    """

    latency = Queue.latency

    def __init__(self, parameters: Build, members: dict[str, Any]) -> None:
        self._parameters = parameters
        texture, surface = texture_layout(parameters), derivatives_layout(parameters)
        self._filtered = bool(texture.members)
        self._by_pixels = reads_pixels(parameters)
        flags = optional(parameters.video_out, corner_flags=corner_flag_layout(parameters))
        super().__init__(
            {
                "corners": In(stream.Signature(Beat(corner_layout(parameters)))),
                **optional(self._filtered, textures=In(stream.Signature(Beat(texture)))),
                "surfaces": In(stream.Signature(surface)),
                "candidate": Out(stream.Signature(candidate_layout(parameters))),
                "pending": Out(stream.Signature(pending_record_layout(parameters))),
                "last": Out(1),
                **{name: Out(stream.Signature(layout)) for name, layout in flags.items()},
                **optional(
                    parameters.budget,
                    max_corners=In(BUDGET_BITS),
                    rank=In(1),
                    counted=Out(1),
                    strength=Out(parameters.response_bits),
                ),
                **optional(parameters.max_per_cell > 0, cells=In(cell_settings_layout())),
                **optional(self._by_pixels, picked=Out(1), row=Out(range(2 * rows_kept(parameters)))),
                **members,
            }
        )

    def _queues(self, m: Module) -> tuple[Queue, Queue]:
        """Those of candidates and of pending records."""
        p = self._parameters
        m.submodules.candidates = candidates = Queue(candidate_layout(p), p.queue_depth)
        refined = steps_in_flight(p) if self._by_pixels else p.units * INSIDE
        m.submodules.pending = pending = Queue(pending_record_layout(p), p.queue_depth + refined)
        wiring.connect(m, candidates.o, wiring.flipped(self.candidate))
        wiring.connect(m, pending.o, wiring.flipped(self.pending))
        return candidates, pending

    def _take(self, m: Module, room: Signal) -> Signal:
        """A window is taken: everything comes in the same clock."""
        step = Signal()
        m.d.comb += [
            *(source.ready.eq(room) for source in (self.corners, self.surfaces)),
            step.eq(self.corners.valid & room),
            self.last.eq(step & self.corners.payload.eof),
        ]
        if self._filtered:
            m.d.comb += self.textures.ready.eq(room)
        return step

    def _offer(
        self, m: Module, candidates: Queue, picked: Value, x: Value, row_ends: Value, frame_ends: Value
    ) -> None:
        """A candidate's surface and, with the gradient step, its place among the pixels.

        Its row there is the one a margin above the centre, as the pixel store numbers rows.
        """
        candidate = candidates.i.payload
        m.d.comb += candidates.i.valid.eq(picked)
        if not self._by_pixels:
            m.d.comb += candidate.eq(self.surfaces.payload)
            return
        row, left_out = Signal.like(self.row), 2 * self._parameters.algorithm.margin
        with m.If(row_ends):
            m.d.sync += row.eq(row + Mux(frame_ends, left_out + 1, 1))
        m.d.comb += [
            candidate.surface.eq(self.surfaces.payload),
            candidate.place.x.eq(x),
            candidate.place.row.eq(row),
            self.picked.eq(picked),
            self.row.eq(row),
        ]

    @property
    def _verdict(self) -> _Verdict:
        response = self.corners.payload.data.response
        if not self._filtered:
            return _Verdict(C(0, 1), C(1, 1), response)
        texture = self.textures.payload.data
        given = "response" in texture.shape().members
        return _Verdict(texture.textured, texture.keep, texture.response if given else response)

    def _budget(
        self, m: Module, step: Signal, ending: Signal, place: tuple[Value, Value]
    ) -> tuple[Value, tuple[Value, Value]]:
        """Whether the frame may have more candidates, and the x and y of a pending record.

        In an end, x and y hold how many corners could have been picked. All is two clocks late,
        because no two corners come in two clocks in a row.
        """
        allowed, found, accepted = Signal(), Signal(COUNT_BITS), Signal(BUDGET_BITS)
        corner, verdict = self.corners.payload.data, self._verdict
        if TEXTURES[self._parameters.algorithm.texture].by_reference:
            counts = ~verdict.textured | self.rank
        else:
            # what is left of D is what counts; whether it is above T1 does not
            counts = verdict.response.any()
        m.d.comb += [self.counted.eq(step & corner.peak & counts), self.strength.eq(verdict.response)]
        chosen = self.cells.per_cell != 0 if self._parameters.max_per_cell else C(0)
        m.d.sync += allowed.eq(chosen | (self.max_corners == 0) | (accepted != self.max_corners))
        with m.If(ending):
            m.d.sync += [found.eq(0), accepted.eq(0)]
        with m.Elif(step & corner.corner & verdict.keep):
            m.d.sync += found.eq(found + 1)
            with m.If(~verdict.textured & (accepted != self.max_corners)):
                m.d.sync += accepted.eq(accepted + 1)
        halves = found[:PIXEL_COORDINATE_BITS], found[PIXEL_COORDINATE_BITS:]
        return allowed, (Mux(ending, halves[0], place[0]), Mux(ending, halves[1], place[1]))


class CandidateSelection(Selection):
    """Selects the window centres that are reported: corners that the texture filter accepts.

    It counts windows to know where they are. A frame's end comes one clock after its last window.

    A frame's largest response is that of the window centres, so that no pixel decides about
    thresholds at which there can be no corner.

    Members
    -------
    largest
        Largest response of the frame so far. From the clock after a frame's last window until the
        next frame's first, it is that of the whole frame.
    corner_flags
        With ``video_out`` only: stream of ``corner_flag_layout(parameters)``, one for every window.

    The others are those of :class:`Selection`.
    """

    def __init__(self, parameters: Build) -> None:
        super().__init__(parameters, {"largest": Out(parameters.response_bits)})

    def elaborate(self, platform: Any) -> Module:
        m, p = Module(), self._parameters
        candidates, pending = self._queues(m)
        room, ending = Signal(init=1), Signal()
        step = self._take(m, room)
        margin = p.algorithm.margin
        x, y = Signal(PIXEL_COORDINATE_BITS, init=margin), Signal(PIXEL_COORDINATE_BITS, init=margin)
        allowed, place = self._budget(m, step, ending, (x, y)) if p.budget else (C(1), (x, y))
        # a clock late, and an end can still follow: there is room for it, too
        flags_room = self._corner_flags(m, step, allowed) if p.video_out else C(1)
        m.d.sync += room.eq(candidates.room & pending.room & flags_room)
        self._largest(m, step)
        corner, verdict = self.corners.payload.data, self._verdict
        with m.If(step):
            m.d.sync += x.eq(x + 1)
            with m.If(self.corners.payload.eol):
                m.d.sync += [x.eq(margin), y.eq(y + 1)]
            with m.If(self.corners.payload.eof):
                m.d.sync += y.eq(margin)
        # the next window is at least a row's first eight columns away: the end never meets a
        # candidate
        m.d.sync += ending.eq(self.last)

        picked, closing = Signal(), Signal()
        if p.max_per_cell:
            self._cell(m, step, closing, pending.i.payload.cell)
        tags = self.corners.payload
        self._offer(m, candidates, picked, x, step & tags.eol, tags.eof)
        m.d.comb += [
            picked.eq(step & corner.corner & verdict.keep & allowed),
            pending.i.valid.eq(picked | ending | closing),
            pending.i.payload.x.eq(place[0]),
            pending.i.payload.y.eq(place[1]),
            pending.i.payload.response.eq(Mux(ending, self.largest, verdict.response)),
            pending.i.payload.textured.eq(verdict.textured),
            pending.i.payload.end.eq(ending),
        ]
        probe(self, candidates=candidates, pending=pending, room=room, x=x, y=y, ending=ending)
        return m

    def _largest(self, m: Module, step: Signal) -> None:
        first, response = Signal(init=1), self.corners.payload.data.response
        probe(self, first=first)
        with m.If(step):
            m.d.sync += first.eq(self.corners.payload.eof)
            with m.If(first | (response > self.largest)):
                m.d.sync += self.largest.eq(response)

    def _cell(self, m: Module, step: Signal, closing: Signal, cell: Any) -> None:
        """The cell of a pending record, and whether a row of cells has ended, a clock later."""
        m.submodules.cell_grid = grid = CellGrid(self._parameters)
        # at a frame's end they are still those of this frame
        per_cell, limit = Signal.like(self.cells.per_cell, name="per_cell"), Signal(BUDGET_BITS)
        m.d.sync += [per_cell.eq(self.cells.per_cell), closing.eq(grid.row_end & (per_cell != 0))]
        m.d.comb += [
            grid.step.eq(step),
            grid.eol.eq(self.corners.payload.eol),
            grid.eof.eq(self.corners.payload.eof),
            grid.settings.eq(self.cells),
            cell.column.eq(grid.column),
            cell.per_cell.eq(per_cell),
            cell.row_end.eq(closing),
        ]
        if self._parameters.budget:
            m.d.sync += limit.eq(self.max_corners)
            m.d.comb += cell.max_corners.eq(limit)

    def _corner_flags(self, m: Module, step: Signal, allowed: Value) -> Value:
        """A corner flag of every window into a queue of its own; returns whether that has room."""
        m.submodules.corner_flags = flags = Queue(corner_flag_layout(self._parameters), CORNER_FLAGS)
        wiring.connect(m, flags.o, wiring.flipped(self.corner_flags))
        corner = self.corners.payload.data.corner & ~self._verdict.textured
        m.d.comb += [
            flags.i.valid.eq(step),
            flags.i.payload.corner.eq(corner & allowed),
            flags.i.payload.eol.eq(self.corners.payload.eol),
            flags.i.payload.eof.eq(self.corners.payload.eof),
        ]
        return flags.room
