"""Corner marks: corners one by one become a mask for each beat of pixels that has some."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.candidate_selection import corner_flag_layout
from hdl.parts.probes import probe


def mark_layout(build: Build) -> data.StructLayout:
    """The corners of one beat of a row, counted from the row's first; no beat between has any.

    With ``end`` no beat after it has any, and it may have none itself; ``eof`` with the last row
    that can have corners.
    """
    return data.StructLayout(
        {"beat": range(build.beats), "corners": build.pixels_per_clock, "end": 1, "eof": 1}
    )


class CornerMarks(wiring.Component):
    """Puts together the corners that are in one beat of pixels; for several pixels per clock.

    A mask is complete when the next corner, or the end of the row, is known. A flag is taken in
    each clock, but for those in which the output waits.

    Members
    -------
    i
        Stream of ``corner_flag_layout(build)``.
    o
        Stream of ``mark_layout(build)``, all of it registers.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        super().__init__(
            {
                "i": In(stream.Signature(corner_flag_layout(build))),
                "o": Out(stream.Signature(mark_layout(build))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        flag, mark, lanes = self.i.payload, self.o.payload, self._build.pixels_per_clock
        lane_bits = lanes.bit_length() - 1
        # the mask under way; none is while it is empty
        beat, corners = Signal.like(mark.beat), Signal(lanes)
        here, bit, leaves, free, step = Signal(), Signal(lanes), Signal(), Signal(), Signal()
        m.d.comb += [
            here.eq(flag.x[lane_bits:] == beat),
            bit.eq(Cat(flag.x[:lane_bits] == lane for lane in range(lanes))),
            leaves.eq(~flag.corner | (corners.any() & ~here)),
            free.eq(~self.o.valid | self.o.ready),
            self.i.ready.eq(free | ~leaves),
            step.eq(self.i.valid & self.i.ready),
        ]
        with m.If(free):
            m.d.sync += [
                self.o.valid.eq(self.i.valid & leaves),
                mark.beat.eq(beat),
                mark.corners.eq(corners),
                mark.end.eq(~flag.corner),
                mark.eof.eq(flag.eof),
            ]
        with m.If(step):
            m.d.sync += [
                beat.eq(flag.x[lane_bits:]),
                corners.eq(Mux(flag.corner, bit | Mux(here, corners, 0), 0)),
            ]
        probe(self, beat=beat, corners=corners)
        return m
