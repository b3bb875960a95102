"""Frame control: adds ends of rows and frames to beats of pixels; samples each frame's settings."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.parts.probes import probe
from hdl.parts.stream import Beat
from hdl.sample import pixels_shape
from hdl.thresholds import frame_layout, settings_layout


class FrameControl(wiring.Component):
    """Counts beats into rows and frames.

    Size and settings are sampled with the first beat of a frame and hold for the whole of it. A
    width or height out of range is taken as the nearest that is allowed: ``Build.min_width`` or
    ``Algorithm.support``, or the built maximum.

    Members
    -------
    i
        Stream of ``pixels_shape(parameters)`` in raster order; a row begins with a beat of its own.
    width, height
        Size of the next frame in pixels.
    next_settings
        ``settings_layout(parameters)`` for the next frame.
    o
        Stream of ``Beat(pixels_shape(parameters))``. Its ready must not wait for its valid.
    settings
        Stream of ``frame_layout(parameters)``, one per frame. A first beat waits until it can be
        taken.
    """

    latency = 1

    def __init__(self, parameters: Build) -> None:
        self._parameters = parameters
        pixels = pixels_shape(parameters)
        super().__init__(
            {
                "i": In(stream.Signature(pixels)),
                "width": In(range(parameters.max_width + 1)),
                "height": In(range(parameters.max_height + 1)),
                "next_settings": In(settings_layout(parameters)),
                "o": Out(stream.Signature(Beat(pixels))),
                "settings": Out(stream.Signature(frame_layout(parameters))),
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

        # compared one beat and one row early, so that the ends are registers; the values are never
        # 0, where counting begins
        p = self._parameters
        lanes, least = p.pixels_per_clock, p.algorithm.support
        lane_bits = (lanes - 1).bit_length()
        x, y = Signal(range(p.beats)), Signal(range(p.max_height))
        last_but_one_x = Signal.like(x, init=-(-p.min_width // lanes) - 2)
        last_but_one_y = Signal.like(y, init=least - 2)
        eol, last_row, eof = Signal(), Signal(), Signal()
        m.d.comb += eof.eq(eol & last_row)
        next_row = [y.eq(Mux(last_row, 0, y + 1)), last_row.eq(y == last_but_one_y)]
        with m.If(step):
            m.d.sync += [first.eq(eof), x.eq(Mux(eol, 0, x + 1)), eol.eq(x == last_but_one_x)]
            if lanes == 1:
                with m.If(eol):
                    m.d.sync += next_row
        if lanes > 1:
            # a clock later, because what stops everything is far away; a row has beats enough
            row_ended = Signal()
            m.d.sync += row_ended.eq(step & eol)
            with m.If(row_ended):
                m.d.sync += next_row
            probe(self, row_ended=row_ended)
        # sampled in every clock up to that of the first beat, so that no logic has to detect it
        width = _clamped(self.width, p.min_width, p.max_width)
        settings = self.next_settings if lanes == 1 else Cat(self.next_settings, width[:lane_bits])
        with m.If(first & ~self.settings.valid):
            m.d.sync += [
                # beats of a row, less 2
                last_but_one_x.eq((width - (lanes + 1))[lane_bits:]),
                last_but_one_y.eq(_clamped(self.height, least, p.max_height) - 2),
                self.settings.payload.eq(settings),
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
