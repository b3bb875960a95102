# amaranth: UnusedElaboratable=no
"""Middle stage of the detector: from responses to candidates, by the windows around each place."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.algorithm import ResponseFilter as ResponseFilterName
from golden.algorithm import Texture
from golden.formats import WINDOW_SIZE
from hdl.adaptation import Adaptation, adapted_layout
from hdl.adaptive_threshold import AdaptiveThreshold
from hdl.build import Build
from hdl.candidate_selection import CandidateSelection, corner_flag_layout, pending_record_layout
from hdl.centre_rows import CentreRows
from hdl.corner_detection import CornerDetection
from hdl.fits import derivatives_layout, equations_block
from hdl.parts.circular_buffer import CircularBuffer
from hdl.parts.nets import connect_by_name
from hdl.parts.optional import optional
from hdl.parts.stream import Beat
from hdl.parts.stream_delay import StreamDelay
from hdl.response_filter import ResponseFilter
from hdl.sample import sample_layout
from hdl.suppression import Suppression
from hdl.texture_filter import TextureFilter
from hdl.thresholds import thresholds_layout

TEXTURE_FILTERS: dict[Texture, type[TextureFilter] | type[AdaptiveThreshold]] = {
    "patches": TextureFilter,
    "mean": AdaptiveThreshold,
}
CENTRES: dict[ResponseFilterName, type[CentreRows] | type[ResponseFilter]] = {
    "none": CentreRows,
    "binomial": ResponseFilter,
}


class WindowStage(wiring.Component):
    """Candidates out of samples.

        samples ─ buffer 9 ─┬ texture filter ───────────────── (delay) ┐
                            ├ centre rows ┬ corner detection ─ (delay) ┼ candidate selection
                            │             └ surface fit ───────────────┤
                            └ gradient step ───────────────────────────┘

    There is a surface fit or a gradient step, not both. With ``response_filter`` the centre rows
    are smoothed ones; with ``texture="mean"`` an adaptive threshold filters textures; and for a
    neighbourhood larger than 3x3, or with ``budget``, another block detects corners, in columns of
    nine rows. Each block says itself which columns it reads: all nine rows, or the centre rows.

    The blocks between buffer and candidate selection move in step: all are ready whenever the
    candidate selection is, and for each window all deliver in the same clock; those that take less
    are delayed.

    With ``budget`` the adaptation counts what goes into the candidate selection.

    Parameters
    ----------
    parameters
        Parameters of the detector.

    Members
    -------
    samples
        Stream of ``Beat(sample_layout(parameters))``.
    limits
        Stream of ``thresholds_layout(parameters)``. A frame's thresholds are taken with its last
        window, when its largest response is known. They never come too late: they are ready soon
        after a frame's first response, and its first column needs eight rows of responses.
    candidate, pending, corner_flags, largest
        As in :class:`hdl.candidate_selection.CandidateSelection`; flags with ``video_out`` only.
    adapted, adapting, history
        With ``budget`` only: as in :class:`hdl.adaptation.Adaptation`, where ``adapting`` is
        ``busy``.
    """

    def __init__(self, parameters: Build) -> None:
        p = parameters
        sample, adapted = sample_layout(p), adapted_layout(p)
        self.response_buffer = CircularBuffer(sample, WINDOW_SIZE, p.max_width, p.buffering, registers=1)
        self.texture_filter = TEXTURE_FILTERS[p.algorithm.texture](p)
        self.centre_rows = CENTRES[p.algorithm.response_filter](p)
        wide = p.algorithm.suppression > 1 or p.budget
        self.corner_detection = Suppression(p) if wide else CornerDetection(p)
        self.equations = equations_block(p)(p)
        self.candidate_selection = CandidateSelection(p)
        self._adaptation = optional(p.budget, adaptation=Adaptation(p))
        latest = self._arrival(self.equations)
        waits = {"late textures": self.texture_filter, "late corners": self.corner_detection}
        self._delays = {
            name: StreamDelay(block.o.payload.shape(), latest - self._arrival(block))
            for name, block in waits.items()
            if self._arrival(block) < latest
        }
        super().__init__(
            {
                "samples": In(stream.Signature(Beat(sample))),
                "limits": In(stream.Signature(thresholds_layout(p))),
                "candidate": Out(stream.Signature(derivatives_layout(p))),
                "pending": Out(stream.Signature(pending_record_layout(p))),
                "largest": Out(p.response_bits),
                **optional(p.video_out, corner_flags=Out(stream.Signature(corner_flag_layout()))),
                **optional(p.budget, adapted=Out(adapted), adapting=Out(1), history=In(adapted)),
            }
        )

    def _arrival(self, block: Any) -> int:
        """Clocks from a column to a block's result for the window that it completes."""
        return block.latency + (self.centre_rows.latency if block.reads == "centres" else 0)

    @property
    def blocks(self) -> dict[str, Any]:
        """Those on one way through, each with a ``latency``."""
        late = {name: delay for name, delay in self._delays.items() if name == "late textures"}
        return {
            "response buffer": self.response_buffer,
            "texture filter": self.texture_filter,
            **late,
            "candidate selection": self.candidate_selection,
        }

    @property
    def _beside(self) -> dict[str, Any]:
        """The other blocks; no centre rows where nobody reads them."""
        blocks = (self.texture_filter, self.corner_detection, self.equations)
        centres = any(block.reads == "centres" or hasattr(block, "centres") for block in blocks)
        return {
            **optional(centres, centre_rows=self.centre_rows),
            "corner_detection": self.corner_detection,
            "equations": self.equations,
            **self._delays,
            **self._adaptation,
        }

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in (self.blocks | self._beside).items():
            m.submodules[name.replace(" ", "_")] = block
        selection, columns = self.candidate_selection, self.response_buffer.o
        wiring.connect(m, wiring.flipped(self.samples), self.response_buffer.i)
        m.d.comb += columns.ready.eq(self.equations.i.ready)
        self._feed(m, self.centre_rows.i, columns)
        m.d.comb += self.centre_rows.o.ready.eq(self.equations.i.ready)
        for block in (self.texture_filter, self.corner_detection, self.equations):
            self._feed(m, block.i, columns if block.reads == "columns" else self.centre_rows.o)
        if isinstance(self.texture_filter, AdaptiveThreshold):
            self._feed(m, self.texture_filter.centres, self.centre_rows.o)
        self._limit(m)
        self._deliver(m, "late corners", self.corner_detection.o, selection.corners)
        self._deliver(m, "late textures", self.texture_filter.o, selection.textures)
        wiring.connect(m, self.equations.o, selection.surfaces)
        connect_by_name(m, wiring.flipped(self), selection)
        for adaptation in self._adaptation.values():
            self._adapt(m, adaptation)
        return m

    @staticmethod
    def _feed(m: Module, sink: Any, source: Any) -> None:
        """Feeds a sink beside others that are ready whenever it is; its ready is not read."""
        m.d.comb += [sink.valid.eq(source.valid), sink.payload.eq(source.payload)]

    def _limit(self, m: Module) -> None:
        limits = self.limits
        m.d.comb += [
            self.corner_detection.t1.valid.eq(1),
            self.corner_detection.t1.payload.eq(limits.payload.t1),
            self.texture_filter.thresholds.valid.eq(1),
            self.texture_filter.thresholds.payload.eq(limits.payload),
            limits.ready.eq(self.candidate_selection.last),
        ]

    def _deliver(self, m: Module, name: str, found: Any, sink: Any) -> None:
        if name in self._delays:
            wiring.connect(m, found, self._delays[name].i)
            found = self._delays[name].o
        wiring.connect(m, found, sink)

    def _adapt(self, m: Module, adaptation: Adaptation) -> None:
        """Counts what goes into the candidate selection, and limits what comes out of it."""
        selection, limits = self.candidate_selection, self.limits.payload
        connect_by_name(m, wiring.flipped(self), adaptation)
        m.d.comb += [
            selection.max_corners.eq(limits.max_corners),
            selection.rank.eq(limits.aim.rank),
            adaptation.corner.eq(selection.counted),
            adaptation.strength.eq(selection.strength),
            adaptation.last.eq(selection.last),
            adaptation.aim.eq(limits.aim),
            self.adapting.eq(adaptation.busy),
        ]
