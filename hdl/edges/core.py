# amaranth: UnusedElaboratable=no
"""The core behind its edges: the guarded detector and its registers, before any bus."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.edges.frame_guard import arriving_layout
from hdl.edges.register_bank import RegisterBank, register_bus
from hdl.edges.video_detector import VideoDetector, output_members, report_members
from hdl.edges.watchdog import Watchdog


class Core(wiring.Component):
    """What the AXI and the Avalon top have in common.

    Parameters
    ----------
    build
        What to build.
    detector
        See ``VideoDetector``.
    ends_of_line
        The video has them. Otherwise lines are told apart by counting, whatever software says.

    Members
    -------
    video, records, overlay
        The same as in ``VideoDetector``.
    bus
        ``register_bus()``, seen from the bank.
    irq
        Interrupt; it stays high until software clears its cause.
    """

    def __init__(self, build: Build, *, detector: Any = None, ends_of_line: bool = True) -> None:
        self._build = build
        self._ends_of_line = ends_of_line
        self.video_detector = VideoDetector(build, detector=detector)
        self.bank = RegisterBank(build)
        super().__init__(
            {
                "video": In(stream.Signature(arriving_layout(build))),
                **output_members(build),
                "bus": In(register_bus()),
                "irq": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.video_detector = video = self.video_detector
        m.submodules.registers = bank = self.bank
        wiring.connect(m, wiring.flipped(self.video), video.video)
        wiring.connect(m, wiring.flipped(self.bus), bank.bus)
        m.d.comb += [
            video.control.eq(bank.control),
            *(getattr(bank, name).eq(getattr(video, name)) for name in report_members(self._build)),
            *(bank.events[name].eq(video.events[name]) for name, _ in video.events.shape()),
            self.irq.eq(bank.irq),
        ]
        if not self._ends_of_line:
            m.d.comb += video.control.ignore_eol.eq(1)
        outputs = {name: getattr(self, name) for name in output_members(self._build)}
        for name, output in outputs.items():
            wiring.connect(m, getattr(video, name), wiring.flipped(output))
        stalled = [self._watch(m, name, each.valid & ~each.ready) for name, each in outputs.items()]
        m.d.comb += [
            bank.events.input_idle.eq(self._watch(m, "input", video.idle)),
            bank.events.output_stalled.eq(Cat(stalled).any()),
        ]
        return m

    def _watch(self, m: Module, name: str, waiting: Any) -> Any:
        watchdog = Watchdog()
        m.submodules[f"watchdog_{name}"] = watchdog
        m.d.comb += [watchdog.waiting.eq(waiting), watchdog.limit.eq(self.bank.timeout)]
        return watchdog.expired
