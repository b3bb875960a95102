"""Video detector and Avalon core with inputs for the simulation's engines; packets sorted."""

from __future__ import annotations

from typing import Any

import numpy as np
from amaranth.hdl import Module
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import COUNT_BITS, Records
from golden.video import NO_LIMIT
from hdl.build import Build
from hdl.edges.avalon import AvalonCore
from hdl.edges.frame_guard import arriving_layout
from hdl.edges.overlay import overlay_layout
from hdl.edges.video_detector import VideoDetector
from hdl.output_constructor import record_layout
from hdl.parts.optional import optional
from hdl.thresholds import settings_layout
from sim import Capture
from tests.support.beats import in_words
from tests.support.malformed import Beats, places


class PlainVideoDetector(wiring.Component):
    """``VideoDetector`` with a plain input for each field of its control, without reset."""

    def __init__(self, parameters: Build, **more: wiring.Member) -> None:
        self._parameters = p = parameters
        self.dut = VideoDetector(p)
        super().__init__(
            {
                "video": In(stream.Signature(arriving_layout(p))),
                "records": Out(stream.Signature(record_layout())),
                **({"overlay": Out(stream.Signature(overlay_layout(p)))} if p.video_out else {}),
                "enable": In(1, init=1),
                "ignore_eol": In(1),
                "send_time": In(1),
                "width": In(range(p.max_width + 1)),
                "height": In(range(p.max_height + 1)),
                "max_records": In(COUNT_BITS, init=NO_LIMIT),
                **{str(name): In(field.shape) for name, field in settings_layout(p)},
                **more,
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self.dut
        wiring.connect(m, wiring.flipped(self.video), dut.video)
        wiring.connect(m, dut.records, wiring.flipped(self.records))
        if self._parameters.video_out:
            wiring.connect(m, dut.overlay, wiring.flipped(self.overlay))
        for name in ("enable", "ignore_eol", "send_time", "width", "height", "max_records"):
            m.d.comb += dut.control[name].eq(getattr(self, name))
        for name, _ in settings_layout(self._parameters):
            m.d.comb += dut.control.settings[name].eq(getattr(self, str(name)))
        return m


class PlainAvalonCore(wiring.Component):
    """``AvalonCore`` with streams for the simulation's engines; registers stay as they are."""

    def __init__(self, build: Build) -> None:
        self.dut = AvalonCore(build)
        lanes = build.pixels_per_clock
        beat = data.StructLayout(
            {
                "data": lanes * build.pixel_bits,
                **optional(lanes > 1, empty=range(lanes)),
                "start": 1,
                "end": 1,
            }
        )
        super().__init__(
            {
                "video": In(stream.Signature(beat)),
                "records": Out(stream.Signature(record_layout())),
                "starts": Out(stream.Signature(1, always_ready=True)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self.dut
        m.d.comb += [
            dut.asi_video_valid.eq(self.video.valid),
            dut.asi_video_data.eq(self.video.payload.data),
            dut.asi_video_startofpacket.eq(self.video.payload.start),
            dut.asi_video_endofpacket.eq(self.video.payload.end),
            self.video.ready.eq(dut.asi_video_ready),
            self.records.valid.eq(dut.aso_records_valid),
            self.records.payload.record.eq(dut.aso_records_data),
            self.records.payload.last.eq(dut.aso_records_endofpacket),
            dut.aso_records_ready.eq(self.records.ready),
            self.starts.valid.eq(dut.aso_records_valid & dut.aso_records_ready),
            self.starts.payload.eq(dut.aso_records_startofpacket),
        ]
        if hasattr(dut, "asi_video_empty"):
            m.d.comb += dut.asi_video_empty.eq(self.video.payload.empty)
        return m


def payloads(beats: Beats, build: Build) -> np.ndarray:
    """Payloads of the video stream; where there is no pixel, it is 0."""
    bits, lanes = build.pixel_bits, build.pixels_per_clock
    words = []
    for pixels, sof, eol in beats:
        there = places(pixels)
        word = sum((pixel or 0) << k * bits for k, pixel in enumerate(there))
        keep = sum((pixel is not None) << k for k, pixel in enumerate(there)) if lanes > 1 else 0
        tags = keep | (sof | eol << 1) << lanes * (lanes > 1)
        words.append(word | tags << bits * lanes)
    return in_words(words)


def packets(capture: Capture) -> list[Records]:
    """What came out, packet by packet; what is left open at the end is one more."""
    words, last = capture.outputs["records"].T
    ends = np.flatnonzero(last) + 1
    return [part for part in np.split(words, ends) if len(part)]
