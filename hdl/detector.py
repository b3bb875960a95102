# amaranth: UnusedElaboratable=no
# the parts are made at once, because the latency is theirs, and elaborated perhaps never
"""The whole detector, wired as the paper's Fig. 9."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import WINDOW_SIZE
from golden.output_constructor import COUNT_BITS
from hdl.adaptation import Adaptation, adapted_layout
from hdl.build import Build
from hdl.candidate_selection import CandidateSelection, corner_flag_layout
from hdl.centre_pixels import CentrePixels
from hdl.convolution import Convolution
from hdl.frame_control import FrameControl
from hdl.output_constructor import OutputConstructor, record_layout
from hdl.parts.circular_buffer import CircularBuffer
from hdl.parts.stream import Beat, SkidBuffer
from hdl.preprocessing import PIXEL_ROWS, Preprocessing
from hdl.response import Response
from hdl.subpixel import Subpixel
from hdl.thresholds import Thresholds, settings_layout
from hdl.window_stage import WindowStage, waiting_layout


def budget_members(parameters: Build) -> dict[str, Any]:
    """Of ``Detector``, with ``budget``."""
    return {
        "found": Out(COUNT_BITS),
        "adapted": Out(adapted_layout(parameters)),
        "adapting": Out(1),
        "history": In(adapted_layout(parameters)),
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
            └ pending ──────────────┘

    With ``fit="gradient"`` the pixel at each response's centre goes along with it through the
    second buffer, and the gradient step's normal equations take the place of the surface fit; other
    options exchange blocks of the windows, too: see :class:`hdl.window_stage.WindowStage`.

    The paper also buffers A, B and C, and the responses three times, and refines every pixel. Here
    gradients and products are made anew for each row of the smoothing window; one response buffer
    serves all that need windows; and only candidates are refined. The records are the same.

    Parameters
    ----------
    parameters
        What to build. ``ValueError`` for ``fit="printed"``, which exists in the golden model only.

    Members
    -------
    i
        Stream of pixels, unsigned(pixel_bits), in raster order, frames back to back.
    width, height
        Frame size, 15 to the built maximum; sampled with a frame's first pixel, as is all that
        follows.
    sigma1, sigma2
        Thresholds in units of 2**-16 (``Settings.sigma1_fixed``, ``sigma2_fixed``).
    use_constant, constant, floor, report_rejected
        As in ``golden.Settings``; use_constant is its ``reference="constant"``.
    max_corners, target_corners, reference_rank, smoothing
        With ``budget`` only: as in ``golden.Settings``.
    o
        Stream of ``record_layout()``: the frame's corners in raster order, then its end-of-frame
        record.
    corner_flags
        With ``video_out`` only: stream of ``corner_flag_layout()``, one for each pixel that can be a
        corner.
    found
        With ``budget`` only: corners of the frame whose end-of-frame record is on offer, not only
        those reported.
    adapted, adapting
        With ``budget`` only: ``adapted_layout(parameters)`` for the next frame, and that it is not
        ready yet.
    history
        With ``budget`` only: what ``adapted`` was before a reset, if the next frame is to follow
        it; steady.
    """

    def __init__(self, parameters: Build) -> None:
        self._parameters = p = parameters
        pixel, response = unsigned(p.pixel_bits), unsigned(p.response_bits)

        self._by_gradients = p.algorithm.fit == "gradient"
        waiting = waiting_layout(p, response, pixel)

        def buffer(shape: Any, rows: int, registers: int) -> CircularBuffer:
            return CircularBuffer(shape, rows, p.max_width, p.buffering, registers=registers)

        self._frame_control = FrameControl(p)
        self._pixel_buffer = buffer(pixel, PIXEL_ROWS, 0)
        self._preprocessing = Preprocessing(p)
        self._convolution = Convolution(p)
        self._response = Response(p)
        self._response_skid = SkidBuffer(Beat(waiting))
        self._thresholds = Thresholds(p)
        self._response_buffer = buffer(waiting, WINDOW_SIZE, 1)
        self._windows = WindowStage(p)
        self._adaptation = Adaptation(p) if p.budget else None
        if self._by_gradients:
            responses = (self._preprocessing, self._convolution, self._response)
            self._centre_pixels = CentrePixels(p, sum(block.latency for block in responses))
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
                **({"corner_flags": Out(stream.Signature(corner_flag_layout()))} if p.video_out else {}),
                **(budget_members(p) if p.budget else {}),
            }
        )

    @property
    def blocks(self) -> dict[str, Any]:
        """Every block on the way of a frame's last pixel to its end-of-frame record, by name, with
        a ``latency``.
        """
        return {
            "frame control": self._frame_control,
            "pixel buffer": self._pixel_buffer,
            "preprocessing": self._preprocessing,
            "convolution": self._convolution,
            "response": self._response,
            "response skid": self._response_skid,
            "thresholds": self._thresholds,
            "response buffer": self._response_buffer,
            **self._windows.blocks,
            "candidate selection": self._candidates,
            "output constructor": self._constructor,
        }

    @property
    def latency(self) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, ``lean`` and unstalled.

        Corners go first: one near the frame's end, or several that still wait, can add up to
        :attr:`refinement_latency`. With ``banked`` buffers the time to read out the last row comes
        on top: see :meth:`frame_latency`.
        """
        # the end is noted a clock after the last window
        return sum(block.latency for block in self.blocks.values()) + 1

    @property
    def refinement_latency(self) -> int:
        """Most clocks that a frame's end waits for corners: a full queue, and those in the
        refinement.
        """
        return (self._parameters.queue_depth + 1) * self._subpixel.interval + self._subpixel.latency

    def frame_latency(self, width: int) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, unstalled, for either
        buffering.
        """
        if self._parameters.buffering == "lean":
            return self.latency
        # each buffer starts reading a row when its last value is in, and ends one row's length
        # later
        return self.latency + (width - 1) + (width - 7)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in self.blocks.items():
            m.submodules[name.replace(" ", "_")] = block
        self._response_chain(m)
        self._window_stage(m)
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
        if self._by_gradients:
            self._pass_pixels_on(m)
        else:
            wiring.connect(m, self._response.o, self._response_skid.i)
            wiring.connect(m, self._response_skid.o, self._thresholds.i)
        wiring.connect(m, control.settings, self._thresholds.settings)
        if not self._by_gradients:
            wiring.connect(m, self._thresholds.o, self._response_buffer.i)

    def _pass_pixels_on(self, m: Module) -> None:
        """Responses, each with the pixel at its centre, into the second buffer."""
        m.submodules.centre_pixels = pixels = self._centre_pixels
        columns, responses = self._pixel_buffer.o, self._response.o
        skid, limits, buffer = self._response_skid, self._thresholds, self._response_buffer
        m.d.comb += [
            # the blocks from preprocessing to response move together, whenever what follows them is
            # ready
            pixels.enable.eq(responses.ready),
            pixels.step.eq(columns.valid & columns.ready),
            pixels.i.eq(columns.payload.data[PIXEL_ROWS // 2]),
            skid.i.payload.data.response.eq(responses.payload.data),
            skid.i.payload.data.pixel.eq(pixels.o),
            limits.i.payload.data.eq(skid.o.payload.data.response),
            buffer.i.payload.data.response.eq(limits.o.payload.data),
            # which passes responses on in the same clock
            buffer.i.payload.data.pixel.eq(skid.o.payload.data.pixel),
        ]
        for source, sink in ((responses, skid.i), (skid.o, limits.i), (limits.o, buffer.i)):
            m.d.comb += [
                sink.valid.eq(source.valid),
                source.ready.eq(sink.ready),
                sink.payload.eol.eq(source.payload.eol),
                sink.payload.eof.eq(source.payload.eof),
            ]

    def _window_stage(self, m: Module) -> None:
        """From responses to candidates."""
        for name, block in self._windows.other_blocks.items():
            m.submodules[name.replace(" ", "_")] = block
        self._windows.connect(m, self._response_buffer.o, self._thresholds.thresholds, self._candidates)
        m.d.comb += self._thresholds.largest.eq(self._candidates.largest)
        if self._adaptation is not None:
            self._budget(m, self._adaptation)

    def _budget(self, m: Module, adaptation: Adaptation) -> None:
        """Counts what goes into the candidate selection, and limits what comes out of it."""
        m.submodules.adaptation = adaptation
        corners, limits = self._candidates.corners, self._thresholds.thresholds
        texture = self._candidates.textures.payload.data
        step = corners.valid & corners.ready
        if self._parameters.algorithm.texture == "mean":
            # of T, which is what counts; whether it is above T1 does not
            response, counted = texture.response, texture.response.any()
        else:
            response, counted = corners.payload.data.response, ~texture.textured | limits.payload.aim.rank
        m.d.comb += [
            adaptation.corner.eq(step & corners.payload.data.peak & counted),
            adaptation.strength.eq(response),
            adaptation.last.eq(self._candidates.last),
            adaptation.aim.eq(limits.payload.aim),
            adaptation.history.eq(self.history),
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
        wiring.connect(m, self._candidates.pending, constructor.pending)
        wiring.connect(m, self._subpixel.o, constructor.offset)
        if self._parameters.video_out:
            wiring.connect(m, self._candidates.corner_flags, wiring.flipped(self.corner_flags))
        wiring.connect(m, constructor.o, wiring.flipped(self.o))
