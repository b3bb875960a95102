# amaranth: UnusedElaboratable=no
"""First stage of the detector: from pixels to responses, with each frame's thresholds."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.adaptation import adapted_layout
from hdl.build import Build
from hdl.convolution import Convolution
from hdl.frame_control import FrameControl
from hdl.parts.circular_buffer import CircularBuffer
from hdl.parts.elastic_queue import ElasticQueue
from hdl.parts.nets import chain, connect_by_name
from hdl.parts.optional import optional
from hdl.parts.stream import Beat, SkidBuffer
from hdl.pixel_filter import FILTER_ROWS, PixelFilter
from hdl.pixel_store import PixelStore, store_members
from hdl.preprocessing import PIXEL_ROWS, Preprocessing
from hdl.response import Response
from hdl.sample import pixels_shape, responses_shape
from hdl.step_layouts import reads_pixels, rows_kept
from hdl.thresholds import Thresholds, settings_layout, settings_members, thresholds_layout


class ResponseStage(wiring.Component):
    """Samples out of pixels.

        pixels ─ frame control ─ (pixel store) ─ (buffer 3 ─ pixel filter) ─┐
            ┌───────────────────────────────────────────────────────────────┘
            └ buffer 7 ─ preprocessing ─ convolution ─ response ─ skid ─ thresholds ─ samples

    With several pixels per clock a queue takes the place of the skid, and preprocessing,
    convolution and response never stop: beats go in as long as the queue has room for all that are
    under way.

    There is a pixel filter for each time that pixels are smoothed, with two rows of pixels (lean)
    of its own; and a pixel store for the gradient step, which reads pixels as they come.

    Members
    -------
    i
        Stream of ``pixels_shape(parameters)``, in raster order.
    width, height, and the fields of ``settings_layout(parameters)``
        Size and settings of the next frame, as in :class:`hdl.frame_control.FrameControl`.
    samples
        Stream of ``Beat(responses_shape(parameters))``, without ``Algorithm.response_margin``.
    limits
        Stream of ``thresholds_layout(parameters)``, one per frame.
    largest, adapted, adapting
        As in :class:`hdl.thresholds.Thresholds`; the last two with ``budget`` only.
    needed, reading, place, column
        With the gradient step only: as in :class:`hdl.pixel_store.PixelStore`.
    """

    def __init__(self, parameters: Build) -> None:
        self._parameters = p = parameters
        pixels, samples = pixels_shape(p), responses_shape(p)
        self.frame_control = FrameControl(p)
        ahead = p.pixels_per_clock > 1
        # pixels wait for their tags in a filter, and need no register in the lean buffer behind it
        first = ahead and p.buffering == "lean"
        self._filters: dict[str, Any] = {}

        def buffer(rows: int) -> CircularBuffer:
            behind = first and bool(self._filters)
            reads_ahead = ahead and (behind or rows > FILTER_ROWS or not p.is_wide)
            return CircularBuffer(
                pixels, rows, p.beats, p.buffering, reads_ahead=reads_ahead, tags_first=behind
            )

        for k in range(p.algorithm.pixel_passes):
            number = f" {k + 1}" if k else ""
            self._filters |= {
                f"filter buffer{number}": buffer(FILTER_ROWS),
                f"pixel filter{number}": PixelFilter(p, 2 * k, tags_first=first),
            }
        self.pixel_buffer = buffer(PIXEL_ROWS)
        self.preprocessing = Preprocessing(p)
        self.convolution = Convolution(p)
        self.response = Response(p)
        self._free: dict[str, Any] = {
            "preprocessing": self.preprocessing,
            "convolution": self.convolution,
            "response": self.response,
        }
        under_way = sum(block.latency for block in self._free.values())
        self.skid: Any = SkidBuffer(Beat(samples))
        if p.pixels_per_clock > 1:
            self.skid = ElasticQueue(Beat(samples), under_way)
        self.thresholds = Thresholds(p)
        kept = rows_kept(p)
        self._store = optional(reads_pixels(p), **{"pixel store": PixelStore(p, kept)})
        super().__init__(
            {
                "i": In(stream.Signature(pixels)),
                "width": In(range(p.max_width + 1)),
                "height": In(range(p.max_height + 1)),
                **settings_members(p),
                "samples": Out(stream.Signature(Beat(samples))),
                "limits": Out(stream.Signature(thresholds_layout(p))),
                "largest": In(p.response_bits),
                **optional(p.budget, adapted=In(adapted_layout(p)), adapting=In(1)),
                **optional(reads_pixels(p), **store_members(p, kept)),
            }
        )

    @property
    def blocks(self) -> dict[str, Any]:
        """Every block on the way of a frame's last pixel, by name, with a ``latency``."""
        return {
            "frame control": self.frame_control,
            **self._store,
            **self._filters,
            "pixel buffer": self.pixel_buffer,
            **self._free,
            **{"response skid" if self._parameters.pixels_per_clock == 1 else "response queue": self.skid},
            "thresholds": self.thresholds,
        }

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in self.blocks.items():
            m.submodules[name.replace(" ", "_")] = block
        control, thresholds = self.frame_control, self.thresholds
        connect_by_name(m, wiring.flipped(self), control)
        for name, _ in settings_layout(self._parameters):
            m.d.comb += control.next_settings[name].eq(getattr(self, str(name)))
        # in the order of their way, thresholds last
        blocks = list(self.blocks.values())
        if self._parameters.pixels_per_clock == 1:
            chain(m, *blocks)
        else:
            first = blocks.index(self.preprocessing)
            self._free_run(m, blocks[:first], blocks[first:])
        for store in self._store.values():
            connect_by_name(m, wiring.flipped(self), store, names=store_members(self._parameters, 1))
        wiring.connect(m, thresholds.o, wiring.flipped(self.samples))
        wiring.connect(m, control.settings, thresholds.settings)
        wiring.connect(m, thresholds.thresholds, wiring.flipped(self.limits))
        connect_by_name(m, wiring.flipped(self), thresholds, names=("largest", "adapted", "adapting"))
        return m

    def _free_run(self, m: Module, before: list[Any], free: list[Any]) -> None:
        """Beats go on from where they can wait to what never stops while the queue has room."""
        chain(m, *before)
        chain(m, *free)
        source, sink, room = before[-1].o, free[0].i, self.skid.room
        m.d.comb += [
            source.ready.eq(room),
            sink.valid.eq(source.valid & room),
            sink.payload.eq(source.payload),
        ]
