"""Frame control: adds ends of rows and frames to the pixels, and samples each frame's settings."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal, Value, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.parts.probes import probe
from hdl.parts.stream import Beat
from hdl.thresholds import settings_layout


class FrameControl(wiring.Component):
    """Counts pixels into rows and frames.

    Size and settings are sampled with the first pixel of a frame and hold for the whole of it. A
    width or height out of range is taken as the nearest that is allowed: ``Algorithm.support``, or
    the built maximum.

    Members
    -------
    i
        Stream of pixels in raster order.
    width, height
        Size of the next frame in pixels.
    next_settings
        ``settings_layout(parameters)`` for the next frame.
    o
        Stream of ``Beat(unsigned(pixel_bits))``. Its ready must not wait for its valid.
    settings
        Stream of ``settings_layout(parameters)``, one per frame. A first pixel waits until it can
        be taken.
    """

    latency = 1

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        pixel = unsigned(parameters.pixel_bits)
        super().__init__(
            {
                "i": In(stream.Signature(pixel)),
                "width": In(range(parameters.max_width + 1)),
                "height": In(range(parameters.max_height + 1)),
                "next_settings": In(settings_layout(parameters)),
                "o": Out(stream.Signature(Beat(pixel))),
                "settings": Out(stream.Signature(settings_layout(parameters))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        first, advance, step = Signal(init=1), Signal(), Signal()
        m.d.comb += [
            advance.eq(self.o.ready),
            self.i.ready.eq(advance & (~first | ~self.settings.valid)),
            step.eq(self.i.valid & self.i.ready),
        ]

        # compared one pixel and one row early, so that the ends are registers; the values are never
        # 0, where counting begins
        x, y = Signal(range(self._parameters.max_width)), Signal(range(self._parameters.max_height))
        least = self._parameters.algorithm.support
        last_but_one_x, last_but_one_y = (Signal.like(place, init=least - 2) for place in (x, y))
        eol, last_row, eof = Signal(), Signal(), Signal()
        m.d.comb += eof.eq(eol & last_row)
        with m.If(step):
            m.d.sync += [first.eq(eof), x.eq(Mux(eol, 0, x + 1)), eol.eq(x == last_but_one_x)]
            with m.If(eol):
                m.d.sync += [y.eq(Mux(last_row, 0, y + 1)), last_row.eq(y == last_but_one_y)]
        # sampled in every clock up to that of the first pixel, so that no logic has to detect it
        with m.If(first & ~self.settings.valid):
            m.d.sync += [
                last_but_one_x.eq(_clamped(self.width, least, self._parameters.max_width) - 2),
                last_but_one_y.eq(_clamped(self.height, least, self._parameters.max_height) - 2),
                self.settings.payload.eq(self.next_settings),
            ]

        with m.If(step & first):
            m.d.sync += self.settings.valid.eq(1)
        with m.Elif(self.settings.ready):
            m.d.sync += self.settings.valid.eq(0)
        with m.If(advance):
            m.d.sync += [
                self.o.valid.eq(step),
                self.o.payload.data.eq(self.i.payload),
                self.o.payload.eol.eq(eol),
                self.o.payload.eof.eq(eof),
            ]
        probe(self, first=first, x=x, y=y, eol=eol, last_row=last_row)
        probe(self, last_but_one_x=last_but_one_x, last_but_one_y=last_but_one_y)
        return m


def _clamped(size: Value, least: int, largest: int) -> Value:
    return Mux(size < least, least, Mux(size > largest, largest, size))
