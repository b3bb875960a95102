"""The reference engine: Amaranth's own simulator.

It needs no compiler, and runs about two thousand clocks per second.
"""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from amaranth.hdl import Cat, ClockDomain, Module, Signal, Value
from amaranth.lib import wiring
from amaranth.sim import Simulator

from sim.engine import QUIET, VCD_CLOCKS, Progress, SimulationError, broken_rule, hang
from sim.ports import Ports, StreamPort, discover
from sim.stimulus import Capture, Plan, Stimulus, Words, prepare, shaped
from sim.waves import Find, View, views, whole, write_save_file

PERIOD = 1e-8
"""Seconds; shows in waveforms only."""
_PROGRESS_CLOCKS = 1000


@dataclass
class _Source:
    beats: list[int]
    stalls: list[int]
    accepted: list[int]
    next: int = 0
    held: bool = False


@dataclass
class _Sink:
    stalls: list[int]
    always_ready: bool
    payload_mask: int
    ready: bool = False
    held: int | None = None
    payloads: list[int] = field(default_factory=list)
    clocks: list[int] = field(default_factory=list)


def _integers(beats: Words) -> list[int]:
    """(n, words) to one Python integer per beat."""
    if beats.shape[1] == 1:
        return [int(beat) for beat in beats[:, 0]]
    return [int.from_bytes(beat.astype("<u8").tobytes(), "little") for beat in beats]


def _words(port: StreamPort, payloads: list[int]) -> Words:
    text = b"".join(payload.to_bytes(8 * port.words, "little") for payload in payloads)
    return shaped(port, np.frombuffer(text, "<u8").astype(np.uint64))


class _Job:
    """One run of a plan: drives the inputs in each clock, and records the outputs.

    All inputs are driven as one concatenated value and all outputs are read as one, because
    every access costs Amaranth's simulator a walk over its processes.
    """

    def __init__(self, plan: Plan, progress: Progress | None) -> None:
        self.plan = plan
        self.progress = progress
        self.clock = 0
        self.error: SimulationError | None = None
        self.sources = [
            _Source(_integers(beats), stalls.tolist(), [-1] * len(beats))
            for beats, stalls in zip(plan.beats, plan.source_stalls, strict=True)
        ]
        self.sinks = [
            _Sink(stalls.tolist(), not port.has_ready, (1 << port.width) - 1)
            for port, stalls in zip(plan.ports.outputs, plan.sink_stalls, strict=True)
        ]
        self._levels = [0] * len(plan.ports.levels)
        self._payloads = [0] * len(plan.ports.inputs)
        self._changes = iter([*plan.changes, (1 << 63, 0, 0)])
        self._change = next(self._changes)
        self._reset_due = plan.reset_after == 0
        self._reset_done = False
        self._idle = 0
        self._apply_levels(0)

    def _apply_levels(self, beat: int) -> None:
        while self._change[0] <= beat:
            _, port, value = self._change
            self._levels[port] = value
            self._change = next(self._changes)

    def drive(self) -> int:
        """The inputs of this clock, packed in the order of :attr:`AmaranthEngine.driven`."""
        for number, source in enumerate(self.sources):
            if self._reset_due:
                source.next += source.held
                source.held = False
            elif not source.held and source.next < len(source.beats):
                if not source.stalls[self.clock % len(source.stalls)]:
                    source.held = True
                    self._payloads[number] = source.beats[source.next]
                    if number == 0:
                        self._apply_levels(source.next)
        for sink in self.sinks:
            paused = sink.stalls[self.clock % len(sink.stalls)] or self._reset_due
            sink.ready = sink.always_ready or not paused
        return self._pack()

    def _pack(self) -> int:
        packed, at = int(self._reset_due), 1
        for port, source, payload in zip(self.plan.ports.inputs, self.sources, self._payloads, strict=True):
            packed |= source.held << at | payload << (at + 1)
            at += 1 + port.width
        for sink in self.sinks:
            packed |= sink.ready << at
            at += 1
        for level, value in zip(self.plan.ports.levels, self._levels, strict=True):
            packed |= value << at
            at += level.width
        return packed

    def watch(self, seen: int) -> bool:
        """Take the outputs of this clock, packed in the same way; False when the run is over."""
        if self._reset_due:
            self._reset_due, self._reset_done = False, True
            self._idle = 0
            for sink in self.sinks:
                sink.held = None
        else:
            active = self._sample(seen)
            if self.sources and not self._reset_done:
                self._reset_due = self.sources[0].next == self.plan.reset_after
            waiting = any(source.next < len(source.beats) for source in self.sources)
            self._idle = 0 if waiting or active or self._reset_due else self._idle + 1
        self.clock += 1
        if self.progress is not None and self.clock % _PROGRESS_CLOCKS == 0:
            self.report()
        if self._idle >= self.plan.limits.quiet or self.error is not None:
            return False
        if self.clock >= self.plan.limits.max_clocks:
            taken = [sum(clock >= 0 for clock in source.accepted) for source in self.sources]
            self.error = hang(self.plan, taken, [len(sink.clocks) for sink in self.sinks])
        return self.error is None

    def _sample(self, seen: int) -> bool:
        for source in self.sources:
            if seen & 1 and source.held:
                source.accepted[source.next] = self.clock
                source.next += 1
                source.held = False
            seen >>= 1
        active = False
        for number, sink in enumerate(self.sinks):
            valid, payload = seen & 1, seen >> 1 & sink.payload_mask
            seen >>= 1 + sink.payload_mask.bit_length()
            if sink.held is not None and self.error is None and (not valid or payload != sink.held):
                self.error = broken_rule(self.plan, number, self.clock, sink.held, payload if valid else None)
            if not valid:
                continue
            active = True
            sink.held = None if sink.ready else payload
            if sink.ready:
                sink.payloads.append(payload)
                sink.clocks.append(self.clock)
        return active

    def report(self) -> None:
        if self.progress is not None:
            self.progress(sum(source.next for source in self.sources), self.plan.total_beats)

    def capture(self, seconds: float) -> Capture:
        ports = self.plan.ports
        sources = zip(ports.inputs, self.sources, strict=True)
        sinks = list(zip(ports.outputs, self.sinks, strict=True))
        return Capture(
            {port.name: _words(port, sink.payloads) for port, sink in sinks},
            {port.name: np.array(sink.clocks, np.int64) for port, sink in sinks},
            {port.name: np.array(source.accepted, np.int64) for port, source in sources},
            self.clock,
            seconds,
        )


def _key(view: View, name: str) -> str:
    return f"{view.module}/{name}"


def _find_in(save: str) -> Find:
    """Where the signals are in the waves, read from a save file with one group, a key, for each."""
    paths = dict(re.findall(r"^-(\S+)\n@\w+\n([^-\s]\S*)$", save, re.MULTILINE))
    return lambda view, name: paths.get(_key(view, name))


class AmaranthEngine:
    """See :class:`sim.engine.Engine`."""

    def __init__(self, component: wiring.Component) -> None:
        self.ports: Ports = discover(component)
        self.name = "amaranth"
        self._component = component
        self._reset = Signal(name="rst")
        self._job: _Job | None = None
        module = Module()
        module.submodules.dut = component
        domain = ClockDomain("sync")
        module.domains.sync = domain
        module.d.comb += domain.rst.eq(self._reset)
        self._simulator = Simulator(module)
        self._simulator.add_clock(PERIOD)
        self._simulator.add_testbench(self._testbench)
        self._fresh = True

    @property
    def driven(self) -> Value:
        """All inputs: reset; valid and payload of input streams; ready of outputs; plain inputs."""
        parts: list[Any] = [self._reset]
        for port in self.ports.inputs:
            member = getattr(self._component, port.name)
            parts += [member.valid, Value.cast(member.payload).as_unsigned()]
        # A stream without a ready signal still takes its bit.
        parts += [
            getattr(self._component, port.name).ready if port.has_ready else Signal(name="unused")
            for port in self.ports.outputs
        ]
        parts += [
            Value.cast(getattr(self._component, level.name)).as_unsigned() for level in self.ports.levels
        ]
        return Cat(*parts)

    @property
    def watched(self) -> Value:
        """All outputs: ready of each input stream; valid and payload of each output stream."""
        parts: list[Any] = [getattr(self._component, port.name).ready for port in self.ports.inputs]
        for port in self.ports.outputs:
            member = getattr(self._component, port.name)
            parts += [member.valid, Value.cast(member.payload)]
        return Cat(*parts)

    async def _testbench(self, context: Any) -> None:
        job = self._job
        assert job is not None
        driven, watched = self.driven, self.watched
        before = 0
        while True:
            packed = job.drive()
            if packed != before or job.clock == 0:
                context.set(driven, packed)
                before = packed
            if not job.watch(context.get(watched)):
                break
            await context.tick()
        job.report()

    @contextmanager
    def _waves(self, path: Path) -> Iterator[None]:
        """Write waves meanwhile, and the list of signals at the end, except beside a pipe."""
        # names in the waves are Amaranth's own, which it tells in a save file only
        shown, save = views(self._component, self.ports), StringIO()
        traces = {_key(view, name): part for view in shown for name, part in view.signals.items()}
        with whole(path) as file, file.open("w", encoding="utf-8") as waves:
            listed = None if file == path else save
            with self._simulator.write_vcd(waves, listed, traces=traces):
                yield
        if listed is not None:
            write_save_file(path, shown, _find_in(save.getvalue()))

    def run(
        self,
        stimulus: Stimulus,
        progress: Progress | None = None,
        vcd: str | Path | None = None,
        *,
        vcd_clocks: int = VCD_CLOCKS,
        quiet: int = QUIET,
        max_clocks: int | None = None,
    ) -> Capture:
        """See :meth:`sim.engine.Engine.run`."""
        plan = prepare(self.ports, stimulus, quiet=quiet, max_clocks=max_clocks, has_reset=True)
        self._job = job = _Job(plan, progress)
        if not self._fresh:
            self._simulator.reset()
        self._fresh = False
        start = time.perf_counter()
        with ExitStack() as stack:
            running = True
            if vcd is not None:
                stack.enter_context(self._waves(Path(vcd)))
                while running and job.clock < vcd_clocks:
                    running = self._simulator.advance()
                stack.close()
            if running:
                self._simulator.run()
        if job.error is not None:
            raise job.error
        return job.capture(time.perf_counter() - start)
