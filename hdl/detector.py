# amaranth: UnusedElaboratable=no
# the parts are made at once, because the latency is theirs, and elaborated perhaps never
"""The whole detector, wired as the paper's Fig. 9."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import COUNT_BITS
from golden.parameters import WINDOW_SIZE, Parameters
from hdl.adaptation import Adaptation, adapted_layout
from hdl.candidate_selection import CandidateSelection, mark_layout
from hdl.centre_rows import CentreRows
from hdl.circular_buffer import CircularBuffer
from hdl.convolution import Convolution
from hdl.corner_detection import CornerDetection
from hdl.frame_control import FrameControl
from hdl.output_constructor import OutputConstructor, record_layout
from hdl.preprocessing import PIXEL_ROWS, Preprocessing
from hdl.response import Response
from hdl.stream import SkidBuffer
from hdl.subpixel import Subpixel
from hdl.suppression import Suppression
from hdl.surface import SurfaceFit
from hdl.texture_filter import TextureFilter
from hdl.thresholds import Thresholds, settings_layout


def budget_members(parameters: Parameters) -> dict[str, Any]:
    """Of ``Detector``, with ``budget``."""
    return {
        "found": Out(COUNT_BITS),
        "adapted": Out(adapted_layout(parameters)),
        "adapting": Out(1),
        "kept": In(adapted_layout(parameters)),
    }


class Detector(wiring.Component):
    """Corners out of a stream of pixels, one pixel per clock, without blanking.

        pixels ─ frame control ─ buffer 7 ─ preprocessing ─ convolution ─ response ─ thresholds ─┐
            ┌────────────────────────────────────────────────────────────────────────────────────┘
            └ buffer 9 ─┬ texture filter ──────────────────┐
                        └ centre rows ─┬ corner detection ─┼─ candidate selection ─┐
                                       └ surface fit ──────┘                       │
            ┌──────────────────────────────────────────────────────────────────────┘
            ├ candidates ─ subpixel ┬─ output constructor ─ records
            └ notes ────────────────┘

    The paper also buffers A, B and C, and the responses three times, and refines every pixel. Here gradients and
    products are made anew for each row of the smoothing window; one response buffer serves all that need windows;
    and only candidates are refined. The records are the same.

    Parameters
    ----------
    parameters
        What to build. ``ValueError`` for ``fit="printed"``, which exists in the golden model only.

    Members
    -------
    i
        Stream of pixels, unsigned(pixel_bits), in raster order, frames back to back.
    width, height
        Frame size, 15 to the built maximum; sampled with a frame's first pixel, as is all that follows.
    sigma1, sigma2
        Thresholds in units of 2**-16 (``Settings.sigma1_fixed``, ``sigma2_fixed``).
    use_constant, constant, floor, report_rejected
        As in ``golden.Settings``; use_constant is its ``reference="constant"``.
    max_corners, target_corners
        With ``budget`` only: as in ``golden.Settings``.
    o
        Stream of ``record_layout()``: the frame's corners in raster order, then its end-of-frame record.
    mark
        With ``video_out`` only: stream of ``mark_layout()``, one for each pixel that can be a corner.
    found
        With ``budget`` only: corners of the frame whose end-of-frame record is on offer, not only those reported.
    adapted, adapting
        With ``budget`` only: ``adapted_layout(parameters)`` for the next frame, and that it is not ready yet.
    kept
        With ``budget`` only: what ``adapted`` was before a reset, if the next frame is to follow it; steady.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = p = parameters
        pixel, response = unsigned(p.pixel_bits), unsigned(p.response_bits)

        def buffer(shape: Any, rows: int, registers: int) -> CircularBuffer:
            return CircularBuffer(shape, rows, p.max_width, p.buffering, registers=registers)

        self._frame_control = FrameControl(p)
        self._pixel_buffer = buffer(pixel, PIXEL_ROWS, 0)
        self._preprocessing = Preprocessing(p)
        self._convolution = Convolution(p)
        self._response = Response(p)
        self._response_skid = SkidBuffer(self._response.o.payload.shape())
        self._thresholds = Thresholds(p)
        self._response_buffer = buffer(response, WINDOW_SIZE, 1)
        self._texture_filter = TextureFilter(p)
        # the same, one for what always was, the other for every radius, and what would be corners but for T1
        self._wide = p.suppression > 1 or p.budget
        self._corner_detection = Suppression(p) if self._wide else CornerDetection(p)
        self._adaptation = Adaptation(p) if p.budget else None
        self._centre_rows = CentreRows(p)
        self._surface = SurfaceFit(p)
        self._candidates = CandidateSelection(p)
        self._subpixel = Subpixel(p)
        self._constructor = OutputConstructor(p)
        settings = {str(name): In(field.shape) for name, field in settings_layout(p)}
        super().__init__(
            {
                "i": In(stream.Signature(pixel)),
                "width": In(range(p.max_width + 1)),
                "height": In(range(p.max_height + 1)),
                **settings,
                "o": Out(stream.Signature(record_layout())),
                **({"mark": Out(stream.Signature(mark_layout()))} if p.video_out else {}),
                **(budget_members(p) if p.budget else {}),
            }
        )

    @property
    def blocks(self) -> dict[str, Any]:
        """Every block on the way of a frame's last pixel to its end-of-frame record, by name, with a ``latency``."""
        return {
            "frame control": self._frame_control,
            "pixel buffer": self._pixel_buffer,
            "preprocessing": self._preprocessing,
            "convolution": self._convolution,
            "response": self._response,
            "response skid": self._response_skid,
            "thresholds": self._thresholds,
            "response buffer": self._response_buffer,
            "texture filter": self._texture_filter,
            "candidate selection": self._candidates,
            "output constructor": self._constructor,
        }

    @property
    def latency(self) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, ``lean`` and unstalled.

        Corners go first: one near the frame's end, or several that still wait, can add up to
        :attr:`refinement_latency`. With ``banked`` buffers the time to read out the last row comes on top: see
        :meth:`frame_latency`.
        """
        # the end is noted a clock after the last window
        return sum(block.latency for block in self.blocks.values()) + 1

    @property
    def refinement_latency(self) -> int:
        """Most clocks that a frame's end waits for corners: a full queue, and those in the refinement."""
        return (self._parameters.queue_depth + 1) * self._subpixel.interval + self._subpixel.latency

    def frame_latency(self, width: int) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, unstalled, for either buffering."""
        if self._parameters.buffering == "lean":
            return self.latency
        # each buffer starts reading a row when its last value is in, and ends one row's length later
        return self.latency + (width - 1) + (width - 7)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in self.blocks.items():
            m.submodules[name.replace(" ", "_")] = block
        self._response_chain(m)
        self._window_chain(m)
        self._record_chain(m)
        return m

    def _response_chain(self, m: Module) -> None:
        """From pixels to responses."""
        control = self._frame_control
        wiring.connect(m, wiring.flipped(self.i), control.i)
        m.d.comb += [control.width.eq(self.width), control.height.eq(self.height)]
        for name, _ in settings_layout(self._parameters):
            m.d.comb += control.next_settings[name].eq(getattr(self, str(name)))
        wiring.connect(m, control.o, self._pixel_buffer.i)
        wiring.connect(m, self._pixel_buffer.o, self._preprocessing.i)
        wiring.connect(m, self._preprocessing.o, self._convolution.i)
        wiring.connect(m, self._convolution.o, self._response.i)
        wiring.connect(m, self._response.o, self._response_skid.i)
        wiring.connect(m, self._response_skid.o, self._thresholds.i)
        wiring.connect(m, control.settings, self._thresholds.settings)
        wiring.connect(m, self._thresholds.o, self._response_buffer.i)

    def _window_chain(self, m: Module) -> None:
        """From responses to candidates."""
        centre_rows, corners, surface = self._centre_rows, self._corner_detection, self._surface
        for name, block in (
            ("centre_rows", centre_rows),
            ("corner_detection", corners),
            ("surface", surface),
        ):
            m.submodules[name] = block
        columns, texture = self._response_buffer.o, self._texture_filter
        limits = self._thresholds.thresholds
        corner_columns = columns if self._wide else centre_rows.o
        # These four move in step: they are ready whenever the candidate selection is, and equally long.
        # Thresholds stay until the last window of their frame has left. They never come too late: they are ready
        # soon after a frame's first response, and its first column needs eight rows of them.
        m.d.comb += [
            columns.ready.eq(surface.i.ready),
            texture.i.valid.eq(columns.valid),
            centre_rows.i.valid.eq(columns.valid),
            centre_rows.o.ready.eq(surface.i.ready),
            corners.i.valid.eq(corner_columns.valid),
            surface.i.valid.eq(centre_rows.o.valid),
            corners.t1.valid.eq(1),
            texture.thresholds.valid.eq(1),
            limits.ready.eq(texture.thresholds.ready if self._adaptation is None else self._adaptation.last),
            centre_rows.i.payload.eq(columns.payload),
            texture.i.payload.eq(columns.payload),
            corners.i.payload.eq(corner_columns.payload),
            surface.i.payload.eq(centre_rows.o.payload),
            corners.t1.payload.eq(limits.payload.t1),
            texture.thresholds.payload.eq(limits.payload),
        ]
        wiring.connect(m, corners.o, self._candidates.corners)
        wiring.connect(m, texture.o, self._candidates.textures)
        wiring.connect(m, surface.o, self._candidates.surfaces)
        if self._adaptation is not None:
            self._budget(m, self._adaptation)

    def _budget(self, m: Module, adaptation: Adaptation) -> None:
        """Counts what goes into the candidate selection, and limits what comes out of it."""
        m.submodules.adaptation = adaptation
        corners, limits = self._candidates.corners, self._thresholds.thresholds
        step = corners.valid & corners.ready
        m.d.comb += [
            adaptation.corner.eq(
                step & corners.payload.data.peak & self._candidates.textures.payload.data.keep
            ),
            adaptation.response.eq(corners.payload.data.response),
            adaptation.last.eq(step & corners.payload.eof),
            adaptation.target.eq(limits.payload.target_corners),
            adaptation.kept.eq(self.kept),
            self._thresholds.adapted.eq(adaptation.adapted),
            self._thresholds.adapting.eq(adaptation.busy),
            self.adapted.eq(adaptation.adapted),
            self.adapting.eq(adaptation.busy),
            self._candidates.max_corners.eq(limits.payload.max_corners),
            self.found.eq(self._constructor.found),
        ]

    def _record_chain(self, m: Module) -> None:
        """From candidates to records."""
        constructor = self._constructor
        m.submodules.subpixel = self._subpixel
        wiring.connect(m, self._candidates.candidate, self._subpixel.i)
        wiring.connect(m, self._candidates.note, constructor.note)
        wiring.connect(m, self._subpixel.o, constructor.offset)
        if self._parameters.video_out:
            wiring.connect(m, self._candidates.mark, wiring.flipped(self.mark))
        wiring.connect(m, self._thresholds.maximum, constructor.maximum)
        wiring.connect(m, constructor.o, wiring.flipped(self.o))
