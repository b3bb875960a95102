"""Frame guard: makes whole frames of any video (``golden.video``), and reports malformed ones."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.video import Event
from hdl.build import Build
from hdl.parts.optional import optional
from hdl.parts.probes import probe
from hdl.sample import pixels_shape


def video_layout(build: Build) -> data.StructLayout:
    """A beat with its framing: first of a frame, last of a line.

    With several pixels per clock ``last_lane`` is the place of its last pixel.
    """
    lanes = build.pixels_per_clock
    return data.StructLayout(
        {
            "pixel": pixels_shape(build),
            **optional(lanes > 1, last_lane=range(lanes)),
            "sof": 1,
            "eol": 1,
        }
    )


def arriving_layout(build: Build) -> data.StructLayout:
    """A beat as it comes; with several pixels per clock ``keep`` says which of them are there."""
    lanes = build.pixels_per_clock
    return data.StructLayout(
        {"pixel": pixels_shape(build), **optional(lanes > 1, keep=lanes), "sof": 1, "eol": 1}
    )


def last_byte(build: Build, lane: int) -> int:
    """The byte of a beat that holds the last bit of a lane's pixel."""
    return ((lane + 1) * build.pixel_bits - 1) // 8


def events_layout(*events: Event) -> data.StructLayout:
    """One bit per event, high for the clock in which it happens."""
    return data.StructLayout({str(event.name).lower(): 1 for event in events})


GUARD_EVENTS = (
    Event.SOF_EARLY,
    Event.SOF_LATE,
    Event.SOF_MISSING,
    Event.EOL_EARLY,
    Event.EOL_LATE,
    Event.EOL_MISSING,
)


class FrameGuard(wiring.Component):
    """Passes exactly width · height pixels from each start of frame, or reports a cut frame.

    A malformed frame raises ``cut``; then nothing is taken until ``resume`` answers. Pixels outside
    of frames are taken and dropped, so that they never hold up a source.

    With several pixels per clock, a line's last beat must have the pixels that the width asks for,
    and every other beat of a frame all of them. Places in the same byte as a line's last pixel are
    not looked at: a source that says which bytes are there cannot leave them out.

    Members
    -------
    i
        Stream of ``arriving_layout(build)``.
    o
        Stream of ``video_layout(build)``: beats of whole frames with correct framing.
    width, height
        Size of the next frame, allowed by the detector; sampled with its first pixel.
    frame_width, frame_height
        Size of the frame under way, or of the last one, until the first pixel of the next one is
        taken.
    enable
        Frames may start.
    ignore_eol
        Lines are told apart by counting only.
    restart
        Forgets everything, and takes nothing more until ``resume``.
    cut, resume
        The frame under way ends here; its packet has been closed. ``resume`` is one clock long.
    active
        A frame is under way.
    taken
        A beat of a frame is taken. All are passed on, except a frame's first one that cuts it.
    done
        The last beat of a frame is taken.
    events
        ``events_layout(*GUARD_EVENTS)``.
    """

    latency = 1

    def __init__(self, build: Build) -> None:
        self._build = build
        width, height = range(build.max_width + 1), range(build.max_height + 1)
        super().__init__(
            {
                "i": In(stream.Signature(arriving_layout(build))),
                "o": Out(stream.Signature(video_layout(build))),
                "width": In(width),
                "height": In(height),
                "frame_width": Out(width, init=build.min_width),
                "frame_height": Out(height, init=build.algorithm.support),
                "enable": In(1),
                "ignore_eol": In(1),
                "restart": In(1),
                "cut": Out(1),
                "resume": In(1),
                "active": Out(1),
                "taken": Out(1),
                "done": Out(1),
                "events": Out(events_layout(*GUARD_EVENTS)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        sof, eol = self.i.payload.sof, self.i.payload.eol
        # surplus: the last beat of a line has been seen, but not its end of line; after: a
        # complete frame went before
        surplus, after = Signal(), Signal()
        row_end, last_row = Signal(), Signal()
        ignore_eol = Signal()

        start, early, short, belongs, beat, free = (
            Signal(name=name) for name in ("start", "early", "short", "belongs", "beat", "free")
        )
        inside = self.active & ~surplus & ~sof
        # a frame's first beat is no line's last: no frame is as narrow
        ends_early = Mux(start, ~self.ignore_eol, inside & ~row_end & ~ignore_eol)
        short_line = eol & ends_early
        late = too_long = inside & row_end & ~eol & ~ignore_eol
        if self._build.pixels_per_clock > 1:
            last_lane, lacking, beyond = self._kept(m, row_end)
            short_line |= (inside | start) & lacking
            too_long = inside & row_end & (~eol | beyond) & ~ignore_eol & ~lacking
        m.d.comb += [
            start.eq(~self.active & sof & self.enable),
            early.eq(self.active & sof),
            short.eq(short_line),
            belongs.eq(start | (inside & ~short)),
            free.eq(~self.o.valid | self.o.ready),
            self.i.ready.eq(~self.cut & ~self.restart & ~early & (free | ~belongs)),
            beat.eq(self.i.valid & self.i.ready),
            self.taken.eq(beat & belongs),
            self.done.eq(self.taken & self.active & row_end & last_row),
        ]

        with m.If(self.taken & ~short):
            m.d.sync += [
                self.o.valid.eq(1),
                self.o.payload.pixel.eq(self.i.payload.pixel),
                self.o.payload.sof.eq(sof),
                self.o.payload.eol.eq(row_end & self.active),
            ]
            if self._build.pixels_per_clock > 1:
                m.d.sync += self.o.payload.last_lane.eq(Mux(row_end & self.active, last_lane, -1))
        with m.Elif(self.o.ready):
            m.d.sync += self.o.valid.eq(0)

        with m.If(beat):
            with m.If(start):
                m.d.sync += [self.active.eq(1), surplus.eq(0), after.eq(0)]
            with m.Elif(surplus):
                m.d.sync += surplus.eq(~eol)
            with m.Elif(late):
                m.d.sync += surplus.eq(1)
        with m.If(self.done):
            m.d.sync += [self.active.eq(0), after.eq(1)]
        with m.If(~self.active & ~self.enable):
            m.d.sync += [surplus.eq(0), after.eq(0)]
        with m.If((self.i.valid & early) | (beat & short)):
            m.d.sync += [self.cut.eq(1), self.active.eq(0), surplus.eq(0), after.eq(0)]
        with m.If(self.resume):
            m.d.sync += self.cut.eq(0)

        row = self._count(m, beat, start, surplus, row_end, last_row, ignore_eol)
        between = beat & ~self.active & ~start & ~surplus & self.enable
        events = self.events
        m.d.comb += [
            events.sof_early.eq(self.i.valid & early),
            events.sof_late.eq(between & after),
            events.sof_missing.eq(between & row & last_row),
            events.eol_early.eq(beat & short),
            events.eol_late.eq(beat & too_long),
            events.eol_missing.eq(beat & ~start & surplus & row_end & ~eol),
        ]
        with m.If(self.restart):
            m.d.sync += self.cut.eq(1)
            m.d.sync += [s.eq(0) for s in (self.active, self.o.valid, surplus, after)]
        probe(self, surplus=surplus, ignore_eol=ignore_eol, row_end=row_end, last_row=last_row)
        return m

    def _count(
        self,
        m: Module,
        beat: Signal,
        start: Signal,
        surplus: Signal,
        row_end: Signal,
        last_row: Signal,
        ignore_eol: Signal,
    ) -> Signal:
        """Counts the place of the next beat: in a frame, a line's surplus, or between frames.

        All are counted alike, so that a surplus line or frame is noticed. Returns whether the beat
        is the last of a row.
        """
        build = self._build
        x, y = Signal(range(build.beats)), Signal(range(build.max_height))
        # row and frame ends are known one beat, and one row, ahead, so that they are registers
        last_but_one_x = Signal.like(x, init=-(-build.min_width // build.pixels_per_clock) - 2)
        last_but_one_y = Signal.like(y, init=build.algorithm.support - 2)
        with m.If(~self.active):
            m.d.sync += [
                last_but_one_x.eq(self._beats(self.width) - 2),
                last_but_one_y.eq(self.height - 2),
                ignore_eol.eq(self.ignore_eol),
            ]
        with m.If(start & beat):
            m.d.sync += [self.frame_width.eq(self.width), self.frame_height.eq(self.height)]

        probe(self, x=x, y=y, last_but_one_x=last_but_one_x, last_but_one_y=last_but_one_y)
        line_over = surplus & self.i.payload.eol
        row = Signal()
        m.d.comb += row.eq(row_end & ~surplus)
        with m.If(beat):
            m.d.sync += [
                x.eq(Mux(row_end | line_over, 0, x + 1)),
                row_end.eq((x == last_but_one_x) & ~line_over),
            ]
            with m.If(row):
                m.d.sync += [
                    y.eq(Mux(last_row, 0, y + 1)),
                    last_row.eq(y == last_but_one_y),
                ]
        with m.If(start & beat):
            m.d.sync += [x.eq(1), y.eq(0), row_end.eq(0), last_row.eq(0)]
        with m.Elif((~self.active & ~self.enable) | self.cut | self.restart):
            m.d.sync += [x.eq(0), y.eq(0), row_end.eq(0), last_row.eq(0)]
        return row

    def _beats(self, width: Value) -> Value:
        """Beats of a line of so many pixels."""
        lanes = self._build.pixels_per_clock
        return width if lanes == 1 else (width + lanes - 1)[lanes.bit_length() - 1 :]

    def _kept(self, m: Module, row_end: Signal) -> tuple[Signal, Value, Value]:
        """Where a line's last pixel is in its beat, and what a beat has.

        Whether it lacks a pixel, and whether a line's last one has pixels to spare.
        """
        lanes, keep = self._build.pixels_per_clock, self.i.payload.keep
        last_lane, needed, beyond = Signal(range(lanes)), Signal(lanes), Signal(lanes)
        ends = [last_byte(self._build, lane) for lane in range(lanes)]
        left = (self.width - 1)[: len(last_lane)]
        with m.If(~self.active):
            m.d.sync += last_lane.eq(left)
            with m.Switch(left):
                for lane, end in enumerate(ends):
                    with m.Case(lane):
                        m.d.sync += [
                            needed.eq((2 << lane) - 1),
                            beyond.eq(Cat(C(byte > end, 1) for byte in ends)),
                        ]
        probe(self, last_lane=last_lane, needed=needed, beyond=beyond)
        spared = Mux(row_end & self.active, ~needed, 0)
        return last_lane, ~(keep | spared).all(), (keep & beyond).any()
