# amaranth: UnusedElaboratable=no
"""The detector for any video: guarded, so that nothing that comes in can hang or confuse it."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, ResetInserter, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import COUNT_BITS
from golden.settings import Settings
from golden.video import NO_LIMIT
from hdl.adaptation import adapted_layout
from hdl.build import Build
from hdl.candidate_selection import INSIDE
from hdl.detector import Detector
from hdl.edges.frame_clock import FrameClock
from hdl.edges.frame_guard import GUARD_EVENTS, FrameGuard, arriving_layout, events_layout
from hdl.edges.lane_overlay import LaneOverlay
from hdl.edges.overlay import Overlay, overlay_layout
from hdl.edges.packet_constructor import PACKET_EVENTS, PacketConstructor, results_layout
from hdl.output_constructor import record_layout
from hdl.parts.optional import optional
from hdl.parts.probes import probe
from hdl.parts.stream import SkidBuffer
from hdl.thresholds import settings_layout

VIDEO_EVENTS = (*PACKET_EVENTS, *GUARD_EVENTS)
CLOCK_BITS = 32


def output_members(build: Build) -> dict[str, wiring.Member]:
    """The streams that leave the core, by name."""
    return {
        "records": Out(stream.Signature(record_layout())),
        **optional(build.video_out, overlay=Out(stream.Signature(overlay_layout(build)))),
    }


def report_members(build: Build) -> dict[str, wiring.Member]:
    """What the registers show of the video, or do at its pace, by name."""
    return {
        "active": Out(1),
        "results": Out(results_layout()),
        **optional(build.budget, history=Out(adapted_layout(build))),
        "clocks": Out(CLOCK_BITS),
        "times": Out(times_layout()),
        "reset_done": Out(1),
    }


def times_layout() -> data.StructLayout:
    """The present time, and that of the last frame that has ended, in clocks since reset."""
    words = ("now_low", "now_high", "frame_time_low", "frame_time_high")
    return data.StructLayout(dict.fromkeys(words, 32))


def control_layout(build: Build) -> data.StructLayout:
    """All settings: ``golden.video.VideoSettings`` in the formats of the hardware, and ``reset``.

    ``reset`` is held until ``reset_done``.
    """
    return data.StructLayout(
        {
            "enable": 1,
            "ignore_eol": 1,
            "send_time": 1,
            "reset": 1,
            "width": range(build.max_width + 1),
            "height": range(build.max_height + 1),
            "max_records": COUNT_BITS,
            "settings": settings_layout(build),
        }
    )


def initial_control(build: Build) -> dict[str, Any]:
    """The settings after reset: the largest frame and default thresholds.

    The core is enabled only with ``autostart``.
    """
    return {
        "enable": int(build.autostart),
        "width": build.max_width,
        "height": build.max_height,
        "max_records": NO_LIMIT,
        "settings": Settings.default(build).fixed(build),
    }


class VideoDetector(wiring.Component):
    """Packets of corners out of any stream of framed pixels, as ``golden.video`` specifies.

        video ─ skid ─ frame guard ─┬─ detector ─┬─ packet constructor ─ records
                                    └─ overlay ──┘       (restart)
                                          └─ pixels with corner flags

    The detector gets whole frames only. Where one is cut, the detector is restarted as soon as the
    frames before have left it. Until then no video is taken; this lasts a few hundred clocks at
    most, or until two rows of cells have come out, unless the output is held up. What a frame
    passes on to the next one, its largest response and what T1 is adapted to, is stored here.

    Parameters
    ----------
    build
        What to build.
    detector
        Another component with the members of ``Detector(build)``, to examine the edges alone.

    Members
    -------
    video
        Stream of ``arriving_layout(build)``. Its ready is a register.
    control
        ``control_layout(build)``.
    records
        Stream of ``record_layout()``: one packet for each frame that began. All of it is registers.
    overlay
        With ``video_out`` only: stream of ``overlay_layout(build)``. All of it is registers.
    results
        ``results_layout()``.
    clocks
        From the first pixel of the last complete frame to its last, both counted.
    times
        ``times_layout()``. A frame's time is that at which ``video`` took its first pixel.
    events
        ``events_layout(*VIDEO_EVENTS)``.
    active
        A frame is under way at the input.
    idle
        A frame is under way, and its next pixel has not come yet.
    history
        With ``budget`` only: ``adapted_layout(build)`` from the last complete frame.
    reset_done
        The reset that ``control.reset`` asks for is done; one clock long.
    """

    def __init__(self, build: Build, *, detector: Any = None) -> None:
        self._build = build
        self._skid = SkidBuffer(arriving_layout(build), closed_in_reset=True)
        self._guard = FrameGuard(build)
        self._detector = detector or Detector(build)
        self._packets = PacketConstructor(counts_found=build.counts_found)
        # complete frames inside, the one under way, and two starts of frame in the skid buffer
        self._clock = FrameClock(self._most_inside + 3)
        super().__init__(
            {
                "video": In(stream.Signature(arriving_layout(build))),
                "control": In(control_layout(build), init=initial_control(build)),
                **output_members(build),
                **report_members(build),
                "events": Out(events_layout(*VIDEO_EVENTS)),
                "idle": Out(1),
            }
        )

    @property
    def edge_latency(self) -> int:
        """Clocks that the edges add to those of the detector."""
        return self._skid.latency + self._guard.latency + self._packets.latency

    @property
    def latency(self) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, as ``Detector.latency``."""
        return self.edge_latency + self._detector.latency

    def frame_latency(self, width: int) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, for either buffering.

        They hold without stalls.
        """
        return self.edge_latency + self._detector.frame_latency(width)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        guard, packets, detector = self._guard, self._packets, self._detector
        restart, stopped = Signal(), Signal()
        m.submodules.skid = self._skid
        m.submodules.guard = guard
        m.submodules.detector = ResetInserter(restart)(detector)
        m.submodules.packets = packets
        wiring.connect(m, wiring.flipped(self.video), self._skid.i)
        wiring.connect(m, self._skid.o, guard.i)
        m.d.comb += [
            guard.width.eq(self.control.width),
            guard.height.eq(self.control.height),
            guard.enable.eq(self.control.enable),
            guard.ignore_eol.eq(self.control.ignore_eol),
            guard.restart.eq(restart),
        ]
        room, shown = self._show(m, restart) if self._build.video_out else (C(1), C(1))
        settled = self._store(m, restart) if self._build.budget else C(1)
        self._feed(m, room)

        m.d.comb += [
            packets.i.valid.eq(detector.o.valid & ~stopped),
            detector.o.ready.eq(packets.i.ready & ~stopped),
            packets.i.payload.eq(detector.o.payload),
            packets.max_records.eq(self.control.max_records),
            packets.send_time.eq(self.control.send_time),
        ]
        if self._build.counts_found:
            m.d.comb += packets.found.eq(detector.found)
        wiring.connect(m, packets.o, wiring.flipped(self.records))
        self._restart(m, restart, stopped, shown & settled)
        self._time(m)
        self._report(m)
        return m

    def _show(self, m: Module, restart: Signal) -> tuple[Value, Value]:
        """The guard's pixels into the overlay, in the clocks in which the detector takes them.

        Returns whether the overlay has room for one, and whether all complete frames have left it.
        """
        kind = Overlay if self._build.pixels_per_clock == 1 else LaneOverlay
        m.submodules.overlay = overlay = kind(self._build)
        pixels, detector = self._guard.o, self._detector
        m.d.comb += [
            overlay.restart.eq(restart),
            overlay.i.payload.eq(pixels.payload),
            overlay.i.valid.eq(pixels.valid & detector.i.ready),
        ]
        wiring.connect(m, detector.corner_flags, overlay.corner_flags)
        wiring.connect(m, overlay.o, wiring.flipped(self.overlay))
        shown = self._in_flight(m, "shown", overlay.done, restart)
        probe(self, shown=shown)
        return overlay.i.ready, shown == 0

    def _feed(self, m: Module, room: Value) -> None:
        """The guard's pixels into the detector, where there is room for them elsewhere, too."""
        guard, detector, settings = self._guard, self._detector, self.control.settings
        m.d.comb += [
            detector.i.payload.eq(guard.o.payload.pixel),
            detector.i.valid.eq(guard.o.valid & room),
            guard.o.ready.eq(detector.i.ready & room),
            detector.width.eq(guard.frame_width),
            detector.height.eq(guard.frame_height),
        ]
        for name, _ in settings_layout(self._build):
            if name != "constant":
                m.d.comb += getattr(detector, str(name)).eq(settings[name])
        # right after a restart the detector knows no frame before, and takes the constant
        m.d.comb += detector.constant.eq(
            Mux(
                settings.use_constant | ~self._packets.any_results,
                settings.constant,
                self._packets.results.maximum,
            )
        )

    def _restart(self, m: Module, restart: Signal, stopped: Signal, others_empty: Value) -> None:
        """What follows a cut or a soft reset: the detector is restarted, then the packet closed."""
        guard, packets = self._guard, self._packets
        closing, clearing, ask, drained, opened = (
            Signal(name=name) for name in ("closing", "clearing", "ask", "drained", "opened")
        )
        inside = self._in_flight(m, "inside", packets.done, restart)
        probe(self, restart=restart, closing=closing, clearing=clearing, opened=opened, inside=inside)
        m.d.comb += drained.eq(inside == 0)
        empty = drained & others_empty
        m.d.comb += [
            ask.eq(self.control.reset | (guard.cut & empty)),
            stopped.eq(restart | closing),
            packets.close.eq(closing & opened),
            packets.clear.eq(self.reset_done),
            guard.resume.eq(closing & (packets.closed | ~opened)),
            self.reset_done.eq(guard.resume & clearing),
        ]
        m.d.sync += restart.eq(ask & ~stopped)
        with m.If(restart):
            m.d.sync += [
                closing.eq(1),
                clearing.eq(self.control.reset),
                opened.eq(guard.active | guard.cut | ~drained),
            ]
        with m.If(guard.resume):
            m.d.sync += closing.eq(0)

    def _store(self, m: Module, restart: Signal) -> Value:
        """Stores what T1 is adapted to over a restart, but not over a soft reset.

        Returns whether what is stored is up to date. It is out of date for some clocks after a
        frame's last window, and so from before the frame's end comes out.
        """
        with m.If(restart & self.control.reset):
            m.d.sync += self.history.eq(0)
        with m.Elif(~self._detector.adapting):
            m.d.sync += self.history.eq(self._detector.adapted)
        m.d.comb += self._detector.history.eq(self.history)
        return ~self._detector.adapting

    def _in_flight(self, m: Module, name: str, out: Any, restart: Signal) -> Signal:
        """Complete frames whose last pixel has gone in, but whose end has not come out."""
        inside = Signal(range(self._most_inside + 1), name=name)
        with m.If(restart):
            m.d.sync += inside.eq(0)
        with m.Elif(self._guard.done & ~out):
            m.d.sync += inside.eq(inside + 1)
        with m.Elif(out & ~self._guard.done):
            m.d.sync += inside.eq(inside - 1)
        return inside

    @property
    def _most_inside(self) -> int:
        """Complete frames that can be in flight at most."""
        # each of them, but for two, has at least one window among the corner flags and pending
        # records that wait; where candidates wait for their windows, only one frame's do, because
        # the next one's thresholds come behind them
        return self._build.queue_depth + 31 + (self._build.units - 1) * INSIDE

    def _time(self, m: Module) -> None:
        video, guard, packets, clock = self.video, self._guard, self._packets, self._clock
        m.submodules.clock = clock
        taken = guard.i.valid & guard.i.ready & guard.i.payload.sof
        m.d.comb += [
            clock.arrives.eq(video.valid & video.ready & video.payload.sof),
            clock.begins.eq(taken & guard.taken),
            clock.drops.eq(taken & ~guard.taken),
            clock.ends.eq(packets.ended),
            clock.forget.eq(self.reset_done),
            packets.time.eq(clock.time),
            Value.cast(self.times).eq(Cat(clock.now, clock.time)),
        ]

    def _report(self, m: Module) -> None:
        guard, packets = self._guard, self._packets
        m.d.comb += [
            self.results.eq(packets.results),
            self.active.eq(guard.active),
            # a pixel that is inside already may be the frame's last
            self.idle.eq(guard.active & ~self._skid.o.valid),
        ]
        for part in (guard, packets):
            for name, _ in part.events.shape():
                m.d.comb += self.events[name].eq(part.events[name])
        elapsed = Signal(CLOCK_BITS)
        with m.If(guard.active):
            m.d.sync += elapsed.eq(elapsed + 1)
        with m.Else():
            m.d.sync += elapsed.eq(2)
        with m.If(guard.done):
            m.d.sync += self.clocks.eq(elapsed)
