# amaranth: UnusedElaboratable=no
"""Middle stage of the detector with several pixels per clock: only candidates have windows."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Module, Signal, Value
from amaranth.lib import wiring

from golden.algorithm import RESPONSE_FILTER_REACH
from hdl.adaptation import Adaptation
from hdl.build import Build
from hdl.candidate_centres import CandidateCentres
from hdl.candidate_peak import CandidatePeak
from hdl.candidate_queue import CandidateQueue, place_layout
from hdl.candidate_ring import CandidateRing
from hdl.candidate_texture import CandidateTexture
from hdl.centre_rows import CENTRE_SIZE
from hdl.middle_stage import CENTRES, adapt, feed, stage_members
from hdl.parts.circular_buffer import CircularBuffer
from hdl.parts.nets import connect_by_name
from hdl.parts.optional import optional
from hdl.peak_mask import PeakMask
from hdl.placed_selection import PlacedSelection
from hdl.sample import responses_shape
from hdl.smoothed_beats import SmoothedBeats
from hdl.surface import SurfaceFit
from hdl.textures import TEXTURES


class CandidateStage(wiring.Component):
    """Candidates out of beats of samples.

        samples ─ buffer N ─ (smoothed beats) ─┬ peak mask ─ candidate queue ─┐
                                               └ candidate ring ──────────────┤
            ┌─────────────────────────────────────────────────────────────────┘
            ├ (texture filter) ──────────────┐
            └ (centre rows) ┬ candidate peak ┼ placed selection
                            └ surface fit ───┘

    All lanes are searched for peaks. What a candidate's window tells is found as with one pixel per
    clock, in columns: each candidate is a row of its own, as wide as the window, read from the ring
    of the last beats of columns. With a texture filter these are columns of N rows of D, otherwise
    three columns of the three rows around the centre, of S with a response filter.

    Without a texture filter, responses are smoothed once: buffer 3 ─ smoothed beats ─ buffer N-2.

    For the textures of ``texture="patches"`` half a window is as good as the other, turned round:
    the candidate texture takes the columns of both from the outer one to the centre, with 8 pixels
    per clock two columns side by side. Behind a response filter, which needs neighbours in their
    order, it is the texture filter of one pixel per clock, as with ``texture="mean"``.

    The blocks behind the ring move in step. Where they cannot keep up, the beats with candidates
    wait in the queue, and then the samples wait.

    Parameters
    ----------
    parameters
        Parameters of the detector, with two pixels per clock or more.

    Members
    -------
    samples
        Stream of ``Beat(responses_shape(parameters))``.
    limits
        Stream of ``thresholds_layout(parameters)``. Beats wait for them, and they are taken behind
        a frame's last candidate.
    candidate, picked, row, pending, corner_flags, largest, adapted, adapting, history
        As in :class:`hdl.window_stage.WindowStage`.
    """

    def __init__(self, parameters: Build) -> None:
        p = parameters
        algorithm, size, shape = p.algorithm, p.algorithm.window_size, responses_shape(p)
        reach = RESPONSE_FILTER_REACH[algorithm.response_filter]
        self._halves, self._choosing = p.sums_halves, p.max_per_cell > 0
        self._place, self._lean = place_layout(p), p.buffering == "lean"
        rows = 2 * reach + 1 if p.buffers_smoothed else size
        waits = p.is_wide and p.buffers_smoothed
        self.response_buffer = CircularBuffer(shape, rows, p.beats, p.buffering, reads_ahead=not waits)
        self.smoothed_beats: Any = None
        if reach:
            # S waits for its tags in the smoothed beats, and needs no register in the lean buffer
            tags_first = p.buffers_smoothed and p.buffering == "lean"
            rows_of_s = 1 if p.buffers_smoothed else CENTRE_SIZE
            self.smoothed_beats = SmoothedBeats(p, rows_of_s, tags_first=tags_first)
        smoothed_buffer = CircularBuffer(
            shape, size - 2 * reach, p.beats, p.buffering, reads_ahead=True, tags_first=True
        )
        self._smoothed_buffer = optional(p.buffers_smoothed, **{"smoothed buffer": smoothed_buffer})
        self.peak_mask = PeakMask(p)
        self.candidate_queue = CandidateQueue(p)
        block = TEXTURES[algorithm.texture]
        self.texture_filter: Any = block(p) if block else None
        self.centre_rows: Any = CENTRES[algorithm.response_filter](p) if block else None
        late = 0
        if p.sums_halves:
            self.texture_filter, self.centre_rows = CandidateTexture(p), CandidateCentres(p)
            # all that is said of a window is said in the same clock
            late = self.texture_filter.latency - self.centre_rows.last - CandidatePeak.shortest
        if block:
            self.candidate_ring = CandidateRing(p, size, size, 0)
        else:
            behind = (size - CENTRE_SIZE) // 2 - reach
            self.candidate_ring = CandidateRing(p, CENTRE_SIZE, CENTRE_SIZE, behind)
        self.candidate_peak = CandidatePeak(p, late)
        self.surface_fit = SurfaceFit(p)
        self.selection = PlacedSelection(p)
        self._adaptation = optional(p.budget, adaptation=Adaptation(p))
        super().__init__(stage_members(p))

    @property
    def blocks(self) -> dict[str, Any]:
        """Those on the way of a frame's last pixel to its end, each with a ``latency``."""
        return {
            "response buffer": self.response_buffer,
            **optional(self.smoothed_beats is not None, **{"smoothed beats": self.smoothed_beats}),
            **self._smoothed_buffer,
            "peak mask": self.peak_mask,
            "candidate queue": self.candidate_queue,
            "candidate ring": self.candidate_ring,
            **self._judges,
            "candidate selection": self.selection,
        }

    @property
    def _judges(self) -> dict[str, Any]:
        """From a window's last column to what is said of it."""
        if self._halves:
            return {"texture filter": self.texture_filter}
        rows = optional(self.centre_rows is not None, **{"centre rows": self.centre_rows})
        return {**rows, "candidate peak": self.candidate_peak}

    @property
    def end_late(self) -> int:
        """Clocks from the first to the last column of what is read for a frame's end."""
        return self.interval - 1

    @property
    def interval(self) -> int:
        """Clocks from one candidate's window to the next, where many wait."""
        return self.candidate_ring.interval

    def waiting(self, beats: int) -> int:
        """Most candidates and ends that wait for their windows when so many beats come at once."""
        return (self.candidate_queue.beats + beats) * (self.peak_mask.most + 1)

    @property
    def _submodules(self) -> dict[str, Any]:
        parts = {
            "response_buffer": self.response_buffer,
            "smoothed_beats": self.smoothed_beats,
            **{name.replace(" ", "_"): block for name, block in self._smoothed_buffer.items()},
            "peak_mask": self.peak_mask,
            "candidate_queue": self.candidate_queue,
            "candidate_ring": self.candidate_ring,
            "texture_filter": self.texture_filter,
            "centre_rows": self.centre_rows,
            "candidate_peak": self.candidate_peak,
            "surface_fit": self.surface_fit,
            "candidate_selection": self.selection,
            **self._adaptation,
        }
        return {name: block for name, block in parts.items() if block is not None}

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in self._submodules.items():
            m.submodules[name] = block
        wiring.connect(m, wiring.flipped(self.samples), self.response_buffer.i)
        self._search(m)
        self._judge(m)
        selection, limits = self.selection, self.limits
        reported = {"candidate", "picked", "row", "pending", "corner_flags"}
        connect_by_name(m, wiring.flipped(self), selection, names=reported)
        m.d.comb += [
            self.largest.eq(self.peak_mask.largest),
            selection.largest.eq(self.peak_mask.largest),
            limits.ready.eq(selection.last),
        ]
        if self._choosing:
            m.d.comb += [
                selection.cells.eq(limits.payload.cells),
                self.candidate_queue.cells.eq(limits.payload.cells),
            ]
        for adaptation in self._adaptation.values():
            adapt(m, self, adaptation, selection)
        return m

    def _search(self, m: Module) -> None:
        """Peaks into the queue, columns into the ring."""
        peaks, queue, ring = self.peak_mask, self.candidate_queue, self.candidate_ring
        buffer = self.response_buffer
        for buffer in self._smoothed_buffer.values():
            self._smooth(m, buffer)
        columns: Any = buffer.o
        first: Any = peaks
        if self.smoothed_beats and not self._smoothed_buffer:
            first = self.smoothed_beats
            m.d.comb += peaks.permit.eq(1)
            wiring.connect(m, first.o, peaks.i)
        # what comes before the first column must move, or there will be no limits
        permit, full = self.limits.valid | ~columns.valid, C(0, 1)
        if self._lean:
            # a clock ahead, in the register that stops everything
            permit, full = C(1, 1), ~self.limits.valid & buffer.filled
        m.d.comb += [
            first.permit.eq(permit),
            peaks.t1.eq(self.limits.payload.t1),
            peaks.last_lanes.eq(self.limits.payload.last_lanes),
        ]
        self._pass_rows(m, first.i, columns)
        wiring.connect(m, peaks.o, queue.i)
        wiring.connect(m, queue.o, ring.i)
        source: Any = columns if self.texture_filter is not None else peaks.i
        top = (len(source.payload.data) - len(ring.columns)) // 2
        m.d.comb += [
            *(ring.columns[k].eq(source.payload.data[top + k]) for k in range(len(ring.columns))),
            ring.step.eq(source.valid & source.ready),
            ring.waiting.eq(queue.waiting),
            queue.full.eq(ring.full | full),
        ]

    def _smooth(self, m: Module, buffer: CircularBuffer) -> None:
        """Into the buffer of S, smoothed once."""
        smoothed = self.smoothed_beats
        self._pass_rows(m, smoothed.i, self.response_buffer.o)
        m.d.comb += [
            smoothed.permit.eq(1),
            buffer.i.valid.eq(smoothed.o.valid),
            # a column of one row is a beat
            Value.cast(buffer.i.payload).eq(smoothed.o.payload),
            smoothed.o.ready.eq(buffer.i.ready),
        ]

    @staticmethod
    def _pass_rows(m: Module, sink: Any, source: Any) -> None:
        """The middle ones of a column, as many as the sink takes."""
        rows = len(sink.payload.data)
        top = (len(source.payload.data) - rows) // 2
        m.d.comb += [
            sink.valid.eq(source.valid),
            source.ready.eq(sink.ready),
            *(sink.payload.data[k].eq(source.payload.data[top + k]) for k in range(rows)),
            sink.payload.eol.eq(source.payload.eol),
            sink.payload.eof.eq(source.payload.eof),
        ]

    def _judge(self, m: Module) -> None:
        """Windows of candidates into the selection, by the blocks of the window stage."""
        selection, limits = self.selection, self.limits.payload
        columns: Any = self.candidate_ring.o
        centres = columns
        m.d.comb += columns.ready.eq(self.surface_fit.i.ready)
        if self.centre_rows is not None:
            centres = self.centre_rows.o
            feed(m, self.centre_rows.i, columns)
            m.d.comb += centres.ready.eq(self.surface_fit.i.ready)
        for block in (self.candidate_peak, self.surface_fit):
            feed(m, block.i, centres)
        if self.texture_filter is not None:
            texture = self.texture_filter
            feed(m, texture.i, columns)
            if hasattr(texture, "centres"):
                feed(m, texture.centres, centres)
            m.d.comb += [texture.thresholds.valid.eq(1), texture.thresholds.payload.eq(limits)]
            wiring.connect(m, texture.o, selection.textures)
        m.d.comb += [self.candidate_peak.t1.valid.eq(1), self.candidate_peak.t1.payload.eq(limits.t1)]
        wiring.connect(m, self.candidate_peak.o, selection.corners)
        wiring.connect(m, self.surface_fit.o, selection.surfaces)
        # it stays until the next window's centre has come, when all is said about this one
        place = Signal(self._place, reset_less=True)
        with m.If(centres.valid & centres.ready & centres.payload.eol):
            m.d.sync += place.eq(self.candidate_ring.place)
        m.d.comb += [
            self.candidate_peak.note.eq(place.note),
            self.candidate_peak.end.eq(place.end),
            selection.place.eq(place),
        ]
