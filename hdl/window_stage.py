# amaranth: UnusedElaboratable=no
"""Middle stage of the detector: from responses to candidates, by the windows around each place."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import wiring

from hdl.adaptation import Adaptation
from hdl.build import Build
from hdl.candidate_selection import CandidateSelection
from hdl.centre_rows import CENTRE_SIZE
from hdl.corner_detection import CornerDetection
from hdl.middle_stage import CENTRES, adapt, feed, stage_members
from hdl.parts.circular_buffer import CircularBuffer
from hdl.parts.nets import connect_by_name
from hdl.parts.optional import optional
from hdl.sample import response_layout
from hdl.suppression import Suppression
from hdl.surface import SurfaceFit
from hdl.textures import TEXTURES


class WindowStage(wiring.Component):
    """Candidates out of samples.

        samples ─ buffer N ─┬ texture filter ─────────────────┐
                            ├ centre rows ┬ corner detection ─┼ candidate selection
                            └             └ surface fit ──────┘

    N is the side of the algorithm's window. With ``response_filter`` the centre rows are smoothed
    ones; where N is 3, they are the columns themselves. With ``texture="mean"`` an adaptive
    threshold filters textures, and there may be no texture filter at all. For a neighbourhood
    larger than 3x3, or with ``budget``, another block detects corners, in columns of N rows. Each
    block says itself which columns it reads: all N rows, or the centre rows.

    The blocks between buffer and candidate selection move in step: all are ready whenever the
    candidate selection is, and for each window all deliver in the same clock.

    With ``budget`` the adaptation counts what goes into the candidate selection.

    Parameters
    ----------
    parameters
        Parameters of the detector.

    Members
    -------
    samples
        Stream of ``Beat(responses_shape(parameters))``.
    limits
        Stream of ``thresholds_layout(parameters)``. A frame's thresholds are taken with its last
        window, when its largest response is known. They never come too late: they are ready soon
        after a frame's first response, and its first window needs two further rows at least.
    candidate, pending, corner_flags, largest
        As in :class:`hdl.candidate_selection.CandidateSelection`; flags with ``video_out`` only.
    picked, row
        With the gradient step only: as in :class:`hdl.candidate_selection.CandidateSelection`.
    adapted, adapting, history
        With ``budget`` only: as in :class:`hdl.adaptation.Adaptation`, where ``adapting`` is
        ``busy``.
    """

    end_late = 1
    """Clocks from a frame's last window to its end's pending record."""
    interval = 1
    """Clocks from one window to the next."""

    def __init__(self, parameters: Build) -> None:
        p = parameters
        sample, size = response_layout(p), p.algorithm.window_size
        self.response_buffer = CircularBuffer(sample, size, p.max_width, p.buffering, registers=1)
        block = TEXTURES[p.algorithm.texture]
        self.texture_filters: dict[str, Any] = {"texture filter": block(p)} if block else {}
        centres = CENTRES[p.algorithm.response_filter]
        self.centre_rows = centres(p) if size > CENTRE_SIZE else None
        wide = p.algorithm.suppression > 1 or p.budget
        self.corner_detection = Suppression(p) if wide else CornerDetection(p)
        self.surface_fit = SurfaceFit(p)
        self.candidate_selection = CandidateSelection(p)
        self._choosing = p.max_per_cell > 0
        self._adaptation = optional(p.budget, adaptation=Adaptation(p))
        super().__init__(stage_members(p))

    @staticmethod
    def waiting(beats: int) -> int:
        """Candidates that wait for their windows when so many beats come at once: none."""
        return 0

    def _is_behind(self, block: Any) -> bool:
        """Does the block read what the centre rows deliver?"""
        return self.centre_rows is not None and block.reads == "centres"

    @property
    def blocks(self) -> dict[str, Any]:
        """Those on one way through, each with a ``latency``."""
        behind = self._is_behind(self.corner_detection)
        return {
            "response buffer": self.response_buffer,
            **optional(behind, **{"centre rows": self.centre_rows}),
            "corner detection": self.corner_detection,
            "candidate selection": self.candidate_selection,
        }

    @property
    def _readers(self) -> tuple[Any, ...]:
        """Blocks that read columns or centre rows."""
        return (*self.texture_filters.values(), self.corner_detection, self.surface_fit)

    @property
    def _beside(self) -> dict[str, Any]:
        """The other blocks; no centre rows where nobody reads them."""
        read = any(self._is_behind(block) or hasattr(block, "centres") for block in self._readers)
        return {
            **optional(read, **{"centre rows": self.centre_rows}),
            **self.texture_filters,
            "surface fit": self.surface_fit,
            **self._adaptation,
        }

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in (self.blocks | self._beside).items():
            m.submodules[name.replace(" ", "_")] = block
        selection, columns = self.candidate_selection, self.response_buffer.o
        wiring.connect(m, wiring.flipped(self.samples), self.response_buffer.i)
        m.d.comb += columns.ready.eq(self.surface_fit.i.ready)
        centres = columns
        if self.centre_rows is not None:
            centres = self.centre_rows.o
            feed(m, self.centre_rows.i, columns)
            m.d.comb += centres.ready.eq(self.surface_fit.i.ready)
        for block in self._readers:
            feed(m, block.i, columns if block.reads == "columns" else centres)
            if hasattr(block, "centres"):
                feed(m, block.centres, centres)
        self._limit(m)
        # all of a window's results come in the same clock
        wiring.connect(m, self.corner_detection.o, selection.corners)
        for block in self.texture_filters.values():
            wiring.connect(m, block.o, selection.textures)
        wiring.connect(m, self.surface_fit.o, selection.surfaces)
        connect_by_name(m, wiring.flipped(self), selection)
        for adaptation in self._adaptation.values():
            adapt(m, self, adaptation, selection)
        return m

    def _limit(self, m: Module) -> None:
        limits, t1 = self.limits, self.corner_detection.t1
        m.d.comb += [
            *(t1.valid.eq(1), t1.payload.eq(limits.payload.t1)),
            limits.ready.eq(self.candidate_selection.last),
        ]
        for block in self.texture_filters.values():
            m.d.comb += [block.thresholds.valid.eq(1), block.thresholds.payload.eq(limits.payload)]
        if self._choosing:
            m.d.comb += self.candidate_selection.cells.eq(limits.payload.cells)
