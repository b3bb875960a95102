# amaranth: UnusedElaboratable=no
# the parts are made at once, because ports and register map are theirs, and elaborated perhaps never
"""The core behind its edges: the guarded detector and its registers, before any bus."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.edges.frame_guard import video_layout
from hdl.edges.overlay import overlay_layout
from hdl.edges.register_bank import RegisterBank, register_bus
from hdl.edges.video_detector import VideoDetector
from hdl.edges.watchdog import Watchdog
from hdl.output_constructor import record_layout


class Core(wiring.Component):
    """What the AXI and the Avalon top have in common.

    Parameters
    ----------
    parameters
        What to build.
    detector
        See ``VideoDetector``.
    ends_of_line
        The video marks them; else lines are told apart by counting, whatever software says.

    Members
    -------
    video, records, overlay
        As of ``VideoDetector``.
    bus
        ``register_bus()``, from the other side.
    irq
        Interrupt, high until software clears what caused it.
    """

    def __init__(self, parameters: Build, *, detector: Any = None, ends_of_line: bool = True) -> None:
        self._parameters = p = parameters
        self._ends_of_line = ends_of_line
        self.video_detector = VideoDetector(p, detector=detector)
        self.bank = RegisterBank(p)
        super().__init__(
            {
                "video": In(stream.Signature(video_layout(p))),
                "records": Out(stream.Signature(record_layout())),
                **({"overlay": Out(stream.Signature(overlay_layout(p)))} if p.video_out else {}),
                "bus": In(register_bus()),
                "irq": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.video_detector = video = self.video_detector
        m.submodules.registers = bank = self.bank
        wiring.connect(m, wiring.flipped(self.video), video.video)
        wiring.connect(m, video.records, wiring.flipped(self.records))
        wiring.connect(m, wiring.flipped(self.bus), bank.bus)
        m.d.comb += [
            video.control.eq(bank.control),
            bank.active.eq(video.active),
            bank.results.eq(video.results),
            bank.clocks.eq(video.clocks),
            bank.reset_done.eq(video.reset_done),
            *(bank.events[name].eq(video.events[name]) for name, _ in video.events.shape()),
            self.irq.eq(bank.irq),
        ]
        if self._parameters.budget:
            m.d.comb += bank.history.eq(video.history)
        if not self._ends_of_line:
            m.d.comb += video.control.ignore_eol.eq(1)
        outputs = [self.records]
        if self._parameters.video_out:
            wiring.connect(m, video.overlay, wiring.flipped(self.overlay))
            outputs.append(self.overlay)
        stalled = [self._watch(m, f"output_{k}", o.valid & ~o.ready) for k, o in enumerate(outputs)]
        m.d.comb += [
            bank.events.input_idle.eq(self._watch(m, "input", video.idle)),
            bank.events.output_stalled.eq(stalled[0] | stalled[-1]),
        ]
        return m

    def _watch(self, m: Module, name: str, waiting: Any) -> Any:
        watchdog = Watchdog()
        m.submodules[f"watchdog_{name}"] = watchdog
        m.d.comb += [watchdog.waiting.eq(waiting), watchdog.limit.eq(self.bank.timeout)]
        return watchdog.expired
