# amaranth: UnusedElaboratable=no
# the blocks are made at once, because their latency decides who waits for whom, and elaborated perhaps never
"""From the windows of responses to candidates: which blocks these are, and how they are wired in
the detector.
"""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module
from amaranth.lib import data, wiring

from golden.formats import WINDOW_SIZE
from golden.parameters import Parameters
from hdl.adaptive_threshold import AdaptiveThreshold
from hdl.candidate_selection import CandidateSelection
from hdl.centre_rows import CentreRows
from hdl.corner_detection import CornerDetection
from hdl.gradient_step import GradientStep
from hdl.parts.stream_delay import StreamDelay
from hdl.response_filter import ResponseFilter
from hdl.suppression import Suppression
from hdl.surface import SurfaceFit
from hdl.texture_filter import TextureFilter


class WindowStage:
    """The blocks between response buffer and candidate selection. They move in step: all are ready
    whenever the candidate selection is, and for each window all deliver in the same clock; those
    that take less wait for the rest.

        columns ─┬ texture filter ─────────────────────────────── late textures ─┐
                 ├ centre rows ─┬─ corner detection ───────────── late corners ──┼─ candidate selection
                 │              └─ surface fit ──────────────────────────────────┤
                 └ pixels ──────── gradient step ────────────────────────────────┘

    Of surface fit and gradient step there is one. With ``response_filter`` the centre rows are
    smoothed ones; with ``texture="mean"`` the texture filter is an adaptive threshold; and where it
    is to be done for more than the 3x3 neighbourhood, or with ``budget``, another block detects
    corners, of D out of all nine rows.

    Parameters
    ----------
    parameters
        Of the detector.
    """

    def __init__(self, parameters: Parameters) -> None:
        p = parameters
        self._by_gradients = p.algorithm.fit == "gradient"
        wide = p.algorithm.suppression > 1 or p.budget
        self._by_columns = wide and p.algorithm.response_filter == "none"
        self.texture_filter: TextureFilter | AdaptiveThreshold = (
            AdaptiveThreshold(p) if p.algorithm.texture == "mean" else TextureFilter(p)
        )
        self.centre_rows: CentreRows | ResponseFilter = (
            ResponseFilter(p) if p.algorithm.response_filter == "binomial" else CentreRows(p)
        )
        self.corner_detection: CornerDetection | Suppression = Suppression(p) if wide else CornerDetection(p)
        self.equations: SurfaceFit | GradientStep = GradientStep(p) if self._by_gradients else SurfaceFit(p)

        corners, rows = self.corner_detection, 0 if self._by_columns else self.centre_rows.latency
        equations = self.equations.latency + (0 if self._by_gradients else self.centre_rows.latency)
        waits = {
            "late textures": (self.texture_filter, equations - self.texture_filter.latency),
            "late corners": (corners, equations - corners.latency - rows),
        }
        self._late = {
            name: StreamDelay(block.o.payload.shape(), clocks)
            for name, (block, clocks) in waits.items()
            if clocks
        }

    @property
    def blocks(self) -> dict[str, Any]:
        """Those on one way through, each with a ``latency``."""
        late = {name: block for name, block in self._late.items() if name == "late textures"}
        return {"texture filter": self.texture_filter, **late}

    @property
    def other_blocks(self) -> dict[str, Any]:
        """Those beside it; no centre rows where nobody reads them."""
        late = {name: block for name, block in self._late.items() if name != "late textures"}
        read = not (self._by_gradients and self._by_columns) or isinstance(
            self.texture_filter, AdaptiveThreshold
        )
        return {
            **({"centre rows": self.centre_rows} if read else {}),
            "corner detection": self.corner_detection,
            "gradient step" if self._by_gradients else "surface": self.equations,
            **late,
        }

    def connect(self, m: Module, columns: Any, limits: Any, candidates: CandidateSelection) -> None:
        """Into the detector's module.

        Parameters
        ----------
        columns
            Output of the response buffer: ``Columns`` of nine responses, or of nine {"response",
            "pixel"}.
        limits
            The thresholds' stream. They stay until the last window of their frame leaves, with
            which its largest response is known. They never come too late: they are ready soon after
            a frame's first response, and its first column needs eight rows of them.
        candidates
            Where corners, textures and equations go.
        """
        centre_rows, corners, equations = self.centre_rows, self.corner_detection, self.equations
        texture = self.texture_filter
        m.d.comb += [
            columns.ready.eq(equations.i.ready),
            texture.i.valid.eq(columns.valid),
            centre_rows.i.valid.eq(columns.valid),
            centre_rows.o.ready.eq(equations.i.ready),
            corners.i.valid.eq(columns.valid if self._by_columns else centre_rows.o.valid),
            equations.i.valid.eq(columns.valid if self._by_gradients else centre_rows.o.valid),
            corners.t1.valid.eq(1),
            texture.thresholds.valid.eq(1),
            limits.ready.eq(candidates.last),
            *self._payloads(columns.payload),
            corners.t1.payload.eq(limits.payload.t1),
            texture.thresholds.payload.eq(limits.payload),
        ]
        if isinstance(texture, AdaptiveThreshold):
            m.d.comb += [
                texture.centres.valid.eq(centre_rows.o.valid),
                texture.centres.payload.eq(centre_rows.o.payload),
            ]
        for name, found, sink in (
            ("late corners", corners.o, candidates.corners),
            ("late textures", texture.o, candidates.textures),
        ):
            if name in self._late:
                wiring.connect(m, found, self._late[name].i)
                found = self._late[name].o
            wiring.connect(m, found, sink)
        wiring.connect(m, equations.o, candidates.surfaces)

    def _payloads(self, columns: Any) -> list[Any]:
        """Responses to texture filter and corner detection; their middle rows, or the pixels, to
        the equations.
        """
        centre_rows, corners, equations = self.centre_rows, self.corner_detection.i, self.equations.i
        texture = self.texture_filter.i
        if not self._by_gradients:
            return [
                centre_rows.i.payload.eq(columns),
                texture.payload.eq(columns),
                corners.payload.eq(columns if self._by_columns else centre_rows.o.payload),
                equations.payload.eq(centre_rows.o.payload),
            ]
        parts = [] if self._by_columns else [corners.payload.eq(centre_rows.o.payload)]
        sinks = [(centre_rows.i, "response"), (texture, "response"), (equations, "pixel")]
        if self._by_columns:
            sinks.append((corners, "response"))
        for sink, part in sinks:
            parts += [
                *(sink.payload.data[row].eq(columns.data[row][part]) for row in range(WINDOW_SIZE)),
                Cat(sink.payload.eol, sink.payload.eof).eq(Cat(columns.eol, columns.eof)),
            ]
        return parts


def waiting_layout(parameters: Parameters, response: Any, pixel: Any) -> Any:
    """What the response buffer holds of each place."""
    if parameters.algorithm.fit != "gradient":
        return response
    return data.StructLayout({"response": response, "pixel": pixel})
