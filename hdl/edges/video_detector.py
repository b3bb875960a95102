# amaranth: UnusedElaboratable=no
# the parts are made at once, because the latency is theirs, and elaborated perhaps never
"""The detector for video as it comes: guarded, so that nothing that comes in can hang or confuse
it.
"""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, ResetInserter, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.output_constructor import COUNT_BITS
from golden.settings import Settings
from golden.video import NO_LIMIT
from hdl.adaptation import adapted_layout
from hdl.build import Build
from hdl.detector import Detector
from hdl.edges.frame_guard import GUARD_EVENTS, FrameGuard, events_layout, video_layout
from hdl.edges.overlay import Overlay, overlay_layout
from hdl.edges.packet_constructor import PACKET_EVENTS, PacketConstructor, results_layout
from hdl.output_constructor import record_layout
from hdl.parts.stream import SkidBuffer
from hdl.thresholds import settings_layout

VIDEO_EVENTS = (*PACKET_EVENTS, *GUARD_EVENTS)
CLOCK_BITS = 32


def control_layout(parameters: Build) -> data.StructLayout:
    """What can be set: ``golden.video.VideoSettings`` in the hardware's formats, and ``reset``,
    held until done.
    """
    return data.StructLayout(
        {
            "enable": 1,
            "ignore_eol": 1,
            "reset": 1,
            "width": range(parameters.max_width + 1),
            "height": range(parameters.max_height + 1),
            "max_records": COUNT_BITS,
            "settings": settings_layout(parameters),
        }
    )


def initial_control(parameters: Build) -> dict[str, Any]:
    """After reset: the largest frame, usual thresholds, enabled only where it is built to start by
    itself.
    """
    return {
        "enable": int(parameters.autostart),
        "width": parameters.max_width,
        "height": parameters.max_height,
        "max_records": NO_LIMIT,
        "settings": Settings.default(parameters).fixed(parameters),
    }


class VideoDetector(wiring.Component):
    """Packets of corners out of any stream of framed pixels; see ``golden.video`` for what becomes
    of which.

        video ─ skid ─ frame guard ─┬─ detector ─┬─ packet constructor ─ records
                                    └─ overlay ──┘       (restart)
                                          └─ pixels with corner flags

    The detector gets whole frames only. Where one is cut, it is restarted as soon as the frames
    before have left it; until then, a few hundred clocks at most unless the output is held up, no
    video is taken. What a frame passes on to the next, its largest response and what T1 is adapted
    to, is kept here.

    Parameters
    ----------
    parameters
        What to build.
    detector
        Another component with the members of ``Detector(parameters)``, to look at the edges alone.

    Members
    -------
    video
        Stream of ``video_layout(parameters)``. Its ready is a register.
    control
        ``control_layout(parameters)``.
    records
        Stream of ``record_layout()``: one packet for each frame that began. All of it is registers.
    overlay
        With ``video_out`` only: stream of ``overlay_layout(parameters)``. All of it is registers.
    results
        ``results_layout()``.
    clocks
        From the first pixel of the last complete frame to its last, both counted.
    events
        ``events_layout(*VIDEO_EVENTS)``.
    active
        A frame is under way at the input.
    idle
        A frame is under way, and it is its next pixel that is waited for.
    history
        With ``budget`` only: ``adapted_layout(parameters)``, of the last complete frame.
    reset_done
        What ``control.reset`` asks for is done; one clock long.
    """

    def __init__(self, parameters: Build, *, detector: Any = None) -> None:
        self._parameters = p = parameters
        self._skid = SkidBuffer(video_layout(p), closed_in_reset=True)
        self._guard = FrameGuard(p)
        self._detector = detector or Detector(p)
        self._packets = PacketConstructor(budget=p.budget)
        self._overlay = Overlay(p) if p.video_out else None
        super().__init__(
            {
                "video": In(stream.Signature(video_layout(p))),
                "control": In(control_layout(p), init=initial_control(p)),
                "records": Out(stream.Signature(record_layout())),
                **({"overlay": Out(stream.Signature(overlay_layout(p)))} if p.video_out else {}),
                "results": Out(results_layout()),
                **({"history": Out(adapted_layout(p))} if p.budget else {}),
                "clocks": Out(CLOCK_BITS),
                "events": Out(events_layout(*VIDEO_EVENTS)),
                "active": Out(1),
                "idle": Out(1),
                "reset_done": Out(1),
            }
        )

    @property
    def edge_latency(self) -> int:
        """Clocks that the edges add to those of the detector."""
        return self._skid.latency + self._guard.latency + self._packets.latency

    @property
    def latency(self) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, ``lean``; see
        ``Detector.latency``.
        """
        return self.edge_latency + self._detector.latency

    def frame_latency(self, width: int) -> int:
        """Clocks from a frame's last pixel to its end-of-frame record, unstalled, for either
        buffering.
        """
        return self.edge_latency + self._detector.frame_latency(width)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        guard, packets, overlay, detector = self._guard, self._packets, self._overlay, self._detector
        restart, stopped = Signal(), Signal()
        m.submodules.skid = self._skid
        m.submodules.guard = guard
        m.submodules.detector = ResetInserter(restart)(detector)
        m.submodules.packets = packets
        if overlay is not None:
            m.submodules.overlay = overlay
            m.d.comb += overlay.restart.eq(restart)
            wiring.connect(m, detector.corner_flags, overlay.corner_flags)
            wiring.connect(m, overlay.o, wiring.flipped(self.overlay))

        wiring.connect(m, wiring.flipped(self.video), self._skid.i)
        wiring.connect(m, self._skid.o, guard.i)
        m.d.comb += [
            guard.width.eq(self.control.width),
            guard.height.eq(self.control.height),
            guard.enable.eq(self.control.enable),
            guard.ignore_eol.eq(self.control.ignore_eol),
            guard.restart.eq(restart),
        ]
        self._feed(m)

        m.d.comb += [
            packets.i.valid.eq(detector.o.valid & ~stopped),
            detector.o.ready.eq(packets.i.ready & ~stopped),
            packets.i.payload.eq(detector.o.payload),
            packets.max_records.eq(self.control.max_records),
        ]
        wiring.connect(m, packets.o, wiring.flipped(self.records))
        self._restart(m, restart, stopped)
        self._report(m)
        return m

    def _feed(self, m: Module) -> None:
        """Guard to detector, and to the overlay in the same clocks."""
        guard, detector, overlay = self._guard, self._detector, self._overlay
        settings = self.control.settings
        others_ready = overlay.i.ready if overlay is not None else 1
        m.d.comb += [
            detector.i.payload.eq(guard.o.payload.pixel),
            detector.i.valid.eq(guard.o.valid & others_ready),
            guard.o.ready.eq(detector.i.ready & others_ready),
            detector.width.eq(guard.frame_width),
            detector.height.eq(guard.frame_height),
        ]
        for name, _ in settings_layout(self._parameters):
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
        if overlay is not None:
            m.d.comb += [
                overlay.i.payload.eq(guard.o.payload),
                overlay.i.valid.eq(guard.o.valid & detector.i.ready),
            ]

    def _restart(self, m: Module, restart: Signal, stopped: Signal) -> None:
        """What follows a cut, or what software wants: the detector is restarted, then the packet
        closed.
        """
        guard, packets = self._guard, self._packets
        closing, clearing, ask, drained, opened = (
            Signal(name=name) for name in ("closing", "clearing", "ask", "drained", "opened")
        )
        m.d.comb += drained.eq(self._in_flight(m, "inside", packets.done, restart) == 0)
        empty = drained
        if self._overlay is not None:
            empty = drained & (self._in_flight(m, "shown", self._overlay.done, restart) == 0)
        if self._parameters.budget:
            empty &= self._history(m, restart)
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

    def _history(self, m: Module, restart: Signal) -> Value:
        """Keeps what T1 is adapted to over a restart, but not over a reset; returns whether that is
        up to date.

        It is soon after a frame's last window, and so is known to be not yet before the frame's end
        comes out.
        """
        with m.If(restart & self.control.reset):
            m.d.sync += self.history.eq(0)
        with m.Elif(~self._detector.adapting):
            m.d.sync += self.history.eq(self._detector.adapted)
        m.d.comb += [self._detector.history.eq(self.history), self._packets.found.eq(self._detector.found)]
        return ~self._detector.adapting

    def _in_flight(self, m: Module, name: str, out: Any, restart: Signal) -> Signal:
        """Complete frames whose last pixel has gone in, but whose end has not come out."""
        # each frame in flight has at least one window among the corner flags and pending records that wait, but for
        # two
        most = self._parameters.queue_depth + 32
        inside = Signal(range(most), name=name)
        with m.If(restart):
            m.d.sync += inside.eq(0)
        with m.Elif(self._guard.done & ~out):
            m.d.sync += inside.eq(inside + 1)
        with m.Elif(out & ~self._guard.done):
            m.d.sync += inside.eq(inside - 1)
        return inside

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
