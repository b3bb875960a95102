# amaranth: UnusedElaboratable=no
# the parts are made at once, because the latency is theirs, and elaborated perhaps never
"""The whole detector, wired as the paper's Fig. 9."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from golden.parameters import SMOOTHING_SIZE, WINDOW_SIZE, Parameters
from hdl.candidate_selection import CandidateSelection, note_layout
from hdl.circular_buffer import CircularBuffer
from hdl.convolution import ConvolutionUnit
from hdl.corner_detection import CornerDetection
from hdl.frame_control import FrameControl
from hdl.output_constructor import OutputConstructor, record_layout
from hdl.preprocessing import Preprocessing, products_layout
from hdl.response import Response
from hdl.stream import Columns, Delay, SkidBuffer, fork, join
from hdl.subpixel import Subpixel
from hdl.texture_filter import TextureFilter
from hdl.thresholds import Thresholds, settings_layout


class Detector(wiring.Component):
    """Corners out of a stream of pixels, one pixel per clock, without blanking.

        pixels ─ frame control ─ buffer 3 ─ preprocessing ─ buffer 5 ─┬ convolution A ┬─ response ─┐
                                                                      ├ convolution B ┤            │
                                                                      └ convolution C ┘            │
            ┌──────────────────────────────────────────────────────────────────────────────────────┘
            └ thresholds ─ buffer 9 ─┬ delay ─ corner detection ┬─ candidate selection ─┐
                                     └ texture filter ──────────┘                       │
            ┌───────────────────────────────────────────────────────────────────────────┘
            ├ subpixel ┬─ output constructor ─ records
            └ notes ───┘

    One response buffer serves corner detection, texture filter and subpixel refinement, and only candidates are
    refined; the paper buffers the responses three times and refines every pixel. The records are the same.

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
    o
        Stream of ``record_layout()``: the frame's corners in raster order, then its end-of-frame record.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = p = parameters
        pixel, response = unsigned(p.pixel_bits), unsigned(p.response_bits)
        products = products_layout(p)

        def buffer(shape: Any, rows: int) -> CircularBuffer:
            return CircularBuffer(shape, rows, p.max_width, p.buffering)

        self._frame_control = FrameControl(p)
        self._pixel_buffer = buffer(pixel, 3)
        self._preprocessing = Preprocessing(p)
        self._product_buffer = buffer(products, SMOOTHING_SIZE)
        self._convolutions = {name: ConvolutionUnit(products[name].shape) for name in "abc"}
        self._response = Response(p)
        self._response_skid = SkidBuffer(self._response.o.payload.shape())
        self._thresholds = Thresholds(p)
        self._response_buffer = buffer(response, WINDOW_SIZE)
        self._texture_filter = TextureFilter(p)
        self._corner_detection = CornerDetection(p)
        self._middle_rows = Delay(
            Columns(response, 3), self._texture_filter.latency - self._corner_detection.latency
        )
        self._candidates = CandidateSelection(p)
        self._subpixel = Subpixel(p)
        self._constructor = OutputConstructor(p)
        self._output_skid = SkidBuffer(record_layout())
        settings = {str(name): In(field.shape) for name, field in settings_layout(p)}
        super().__init__(
            {
                "i": In(stream.Signature(pixel)),
                "width": In(range(p.max_width + 1)),
                "height": In(range(p.max_height + 1)),
                **settings,
                "o": Out(stream.Signature(record_layout())),
            }
        )

    @property
    def blocks(self) -> dict[str, Any]:
        """Every block on the way of a pixel that becomes a record, in order, by name: each has its ``latency``."""
        return {
            "frame control": self._frame_control,
            "pixel buffer": self._pixel_buffer,
            "preprocessing": self._preprocessing,
            "product buffer": self._product_buffer,
            "convolution": self._convolutions["a"],
            "response": self._response,
            "response skid": self._response_skid,
            "thresholds": self._thresholds,
            "response buffer": self._response_buffer,
            "texture filter": self._texture_filter,
            "candidate selection": self._candidates,
            "subpixel": self._subpixel,
            "output constructor": self._constructor,
            "output skid": self._output_skid,
        }

    @property
    def latency(self) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, ``lean`` and unstalled.

        A corner on the last possible pixel leaves ``CandidateSelection.END_DELAY`` clocks sooner. With ``banked``
        buffers the time to read out the last row comes on top, three times: see :meth:`frame_latency`.
        """
        return sum(block.latency for block in self.blocks.values()) + self._candidates.END_DELAY

    def frame_latency(self, width: int) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, unstalled, for either buffering."""
        if self._parameters.buffering == "lean":
            return self.latency
        # each buffer starts reading a row when its last value is in, and ends one row's length later
        return self.latency + (width - 1) + (width - 3) + (width - 7)

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
        wiring.connect(m, self._preprocessing.o, self._product_buffer.i)

        for name in "bc":
            m.submodules[f"convolution_{name}"] = self._convolutions[name]
        columns, smoothed = self._product_buffer.o, self._response.i
        fork(m, columns, [unit.i for unit in self._convolutions.values()])
        join(m, [unit.o for unit in self._convolutions.values()], smoothed)
        for name, unit in self._convolutions.items():
            m.d.comb += [
                unit.i.payload.data[row].eq(columns.payload.data[row][name]) for row in range(SMOOTHING_SIZE)
            ]
            m.d.comb += [
                unit.i.payload.eol.eq(columns.payload.eol),
                unit.i.payload.eof.eq(columns.payload.eof),
                smoothed.payload.data[name].eq(unit.o.payload.data),
            ]
        tags = self._convolutions["a"].o.payload
        m.d.comb += [smoothed.payload.eol.eq(tags.eol), smoothed.payload.eof.eq(tags.eof)]

        wiring.connect(m, self._response.o, self._response_skid.i)
        wiring.connect(m, self._response_skid.o, self._thresholds.i)
        wiring.connect(m, control.settings, self._thresholds.settings)
        wiring.connect(m, self._thresholds.o, self._response_buffer.i)

    def _window_chain(self, m: Module) -> None:
        """From responses to candidates."""
        m.submodules.middle_rows = middle = self._middle_rows
        m.submodules.corner_detection = self._corner_detection
        columns, texture = self._response_buffer.o, self._texture_filter
        fork(m, columns, [middle.i, texture.i])
        centre = WINDOW_SIZE // 2
        m.d.comb += [
            texture.i.payload.eq(columns.payload),
            *(middle.i.payload.data[row].eq(columns.payload.data[centre - 1 + row]) for row in range(3)),
            middle.i.payload.eol.eq(columns.payload.eol),
            middle.i.payload.eof.eq(columns.payload.eof),
        ]
        wiring.connect(m, middle.o, self._corner_detection.i)
        limits = self._thresholds.thresholds
        fork(m, limits, [self._corner_detection.t1, texture.thresholds])
        m.d.comb += [
            self._corner_detection.t1.payload.eq(limits.payload.t1),
            texture.thresholds.payload.eq(limits.payload),
        ]
        wiring.connect(m, self._corner_detection.o, self._candidates.corners)
        wiring.connect(m, texture.o, self._candidates.textures)

    def _record_chain(self, m: Module) -> None:
        """From candidates to records."""
        constructor = self._constructor
        layout: data.StructLayout = note_layout(self._parameters)
        # holds the notes of all candidates inside the subpixel refinement: at most one every other clock
        depth = 1 << (self._subpixel.latency // 2 + 2).bit_length()
        m.submodules.notes = notes = SyncFIFOBuffered(width=layout.size, depth=depth)
        wiring.connect(m, self._candidates.patch, self._subpixel.i)
        m.d.comb += [
            notes.w_data.eq(self._candidates.note.payload),
            notes.w_en.eq(self._candidates.note.valid),
            self._candidates.note.ready.eq(notes.w_rdy),
            constructor.note.payload.eq(notes.r_data),
            constructor.note.valid.eq(notes.r_rdy),
            notes.r_en.eq(constructor.note.ready),
        ]
        wiring.connect(m, self._subpixel.o, constructor.offset)
        wiring.connect(m, self._thresholds.maximum, constructor.maximum)
        wiring.connect(m, constructor.o, self._output_skid.i)
        wiring.connect(m, self._output_skid.o, wiring.flipped(self.o))
