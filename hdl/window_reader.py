# amaranth: UnusedElaboratable=no
"""Reads windows of pixels for the gradient step out of the pixel store, beat by beat."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value, signed
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import OFFSET_BITS
from golden.normal_equations import FARTHEST, PLACE_BITS, STEP_SIZE
from hdl.build import Build
from hdl.normal_equations import PASSES, PAUSE, ROWS, first_complete, pass_beats, window_layout
from hdl.pixel_store import column_layout, place_layout, read_latency
from hdl.step_layouts import CENTRE_BITS, columns_read, rows_kept, step_layout, under_way_layout

_REACH = STEP_SIZE // 2 + 1
"""Pixels that a window reads to all sides of the one in its middle."""
_HALF = 1 << (PLACE_BITS - 1)


class WindowReader(wiring.Component):
    """Sweeps the window of one step after the other, in passes as the normal equations need them.

    A window's place along an axis, in 1/16 pixel, is that of the step's start, rounded and limited.
    Half a pixel more, it is a whole number of pixels, which is the window's centre, and a fraction,
    which is the weight of the last row or column.

    Members
    -------
    i
        Stream of ``step_layout(build)``; taken when its sweep begins.
    under_way
        Stream of ``under_way_layout(build)``, always ready, one for each sweep that begins.
    read
        In this clock the last pixels of a candidate's second window are read.
    reading, place, column
        Those of the pixel store.
    o
        Stream of ``window_layout(build)``.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        super().__init__(
            {
                "i": In(stream.Signature(step_layout(build))),
                "under_way": Out(stream.Signature(under_way_layout(build), always_ready=True)),
                "read": Out(1),
                "reading": Out(1),
                "place": Out(place_layout(build, rows_kept(build))),
                "column": In(column_layout(build)),
                "o": Out(stream.Signature(window_layout(build))),
            }
        )

    @property
    def interval(self) -> int:
        """Clocks from one window to the next."""
        return PASSES * pass_beats(self._build) + PAUSE + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        beats, first, at_once = (
            pass_beats(self._build),
            first_complete(self._build),
            columns_read(self._build),
        )
        advance = self.o.ready
        given = self.i.payload
        placed, running, second = Signal(), Signal(), Signal()
        x_place, y_place = (Signal(signed(CENTRE_BITS + PLACE_BITS), name=f"{axis}_place") for axis in "xy")
        number, beat = Signal(range(PASSES)), Signal(range(beats))
        right, bottom = beat == beats - 1, number == PASSES - 1
        begins = Signal()
        m.d.comb += [
            begins.eq(advance & placed),
            self.reading.eq(advance),
            self.i.ready.eq(begins),
            self.read.eq(advance & running & right & bottom & second),
            self.under_way.valid.eq(begins),
            self.under_way.payload.step.eq(given),
            self.under_way.payload.centre_x.eq(_centre(x_place)),
            self.under_way.payload.centre_y.eq(_centre(y_place)),
        ]
        # a pass ends with the window's last column
        before = beats * at_once - (2 * _REACH + 1)
        first_x = given.candidate.x + _centre(x_place) - (_REACH + before)
        first_row = given.candidate.row + _centre(y_place) + (self._build.algorithm.margin - _REACH)
        with m.If(advance):
            m.d.sync += placed.eq(self.i.valid & ~running & ~placed)
            with m.If(placed):
                m.d.sync += [
                    running.eq(1),
                    second.eq(given.second),
                    self.place.x.eq(first_x),
                    self.place.row.eq(first_row),
                ]
            with m.Elif(running):
                step = Mux(right, C((1 - beats) * at_once, signed(5)), at_once)
                m.d.sync += [beat.eq(Mux(right, 0, beat + 1)), self.place.x.eq(self.place.x + step)]
                with m.If(right):
                    m.d.sync += [
                        self.place.row.eq(self.place.row + ROWS),
                        number.eq(Mux(bottom, 0, number + 1)),
                        running.eq(~bottom),
                    ]
            with m.Else():
                m.d.sync += [x_place.eq(_place(given.from_x)), y_place.eq(_place(given.from_y))]
        complete = running & (beat >= first)
        tags = Cat(complete, beat == first, complete & right, complete & (number == 0), complete & bottom)
        read = Cat(running, tags)
        for k in range(read_latency(self._build)):
            later = Signal(len(read), name=f"tags_{k + 1}")
            with m.If(advance):
                m.d.sync += later.eq(read)
            read = later
        window = self.o.payload
        m.d.comb += [
            self.o.valid.eq(read[0]),
            Cat(window.complete, window.left, window.right, window.top, window.bottom).eq(read[1:]),
            window.pixels.eq(self.column),
            window.x.eq(x_place[:PLACE_BITS]),
            window.y.eq(y_place[:PLACE_BITS]),
        ]
        return m


def _place(offset: Value) -> Value:
    """The window's place for a corner at this offset, plus half a pixel."""
    shift = OFFSET_BITS - PLACE_BITS
    rounded = ((offset + ((_HALF << shift) + (1 << (shift - 1)))) >> shift)[:8]
    low, high = _HALF - FARTHEST, _HALF + FARTHEST
    # -31 and 47: told by single bits, where a comparison would take a carry chain
    sign, top = rounded[7], rounded[4:7]
    above = ~sign & (top[2] | (top[1] & top[0]))
    below = sign & (~(top[2] & top[1]) | ~rounded[:5].any())
    bits = CENTRE_BITS + PLACE_BITS
    return Mux(below, C(low, signed(bits)), Mux(above, C(high, signed(bits)), rounded[:bits].as_signed()))


def _centre(place: Value) -> Value:
    return place[PLACE_BITS:].as_signed()
