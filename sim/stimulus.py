"""What goes into a simulation and what comes out of it, the same for every engine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sim.ports import LevelPort, Ports, StreamPort

Words = NDArray[np.uint64]
Clocks = NDArray[np.int64]

_PERIODS = (65537, 65539, 65543, 65551, 65557, 65563, 65579, 65581)
"""Primes above 2**16: patterns of different streams never fall into step."""


@dataclass(frozen=True)
class Stalls:
    """Random pauses, drawn in advance so that every engine sees the same ones.

    Parameters
    ----------
    inputs
        Probability per clock, 0 <= p < 1, that a source with nothing on offer waits.
    outputs
        Probability per clock, 0 <= p < 1, that a sink is not ready.
    seed
        Seed of the random generator, 0 or more.
    """

    inputs: float = 0.0
    outputs: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("inputs", "outputs"):
            value = getattr(self, name)
            if not 0 <= value < 1:
                raise ValueError(f"stall probability of {name} is {value!r}; allowed: 0 <= p < 1")
        if self.seed < 0:
            raise ValueError(f"stall seed is {self.seed!r}; allowed: whole numbers from 0")

    def patterns(self, ports: Ports) -> tuple[list[NDArray[np.uint8]], list[NDArray[np.uint8]]]:
        """One pattern per stream: element ``t % len`` is 1 where clock ``t`` pauses.

        Streams are numbered inputs first; the seed and the number fix the pattern.
        """
        chances = [self.inputs] * len(ports.inputs)
        chances += [self.outputs if port.has_ready else 0.0 for port in ports.outputs]
        patterns = [self._pattern(number, chance) for number, chance in enumerate(chances)]
        return patterns[: len(ports.inputs)], patterns[len(ports.inputs) :]

    def _pattern(self, number: int, chance: float) -> NDArray[np.uint8]:
        if chance == 0:
            return np.zeros(1, np.uint8)
        random = np.random.default_rng([self.seed, number]).random(_PERIODS[number % len(_PERIODS)])
        return (random < chance).astype(np.uint8)


@dataclass(frozen=True)
class Stimulus:
    """Everything a simulation is fed with.

    Parameters
    ----------
    beats
        Per input stream the payloads, in order: shape (n,) for up to 64 bits, otherwise (n, words)
        of little-endian 64-bit words. Streams that are left out have no beats.
    levels
        ``(k, values)``: values of plain inputs from the clock in which beat ``k`` of the first
        input stream is presented; those for ``k = 0`` hold from the first clock.
    stalls
        Random pauses.
    reset_after
        Assert ``rst`` for one clock after that many beats of the first input stream were accepted.
        No stream transfers in that clock; the beat that another source offers is lost, and that
        source goes on with the next one.
    """

    beats: Mapping[str, Words]
    levels: list[tuple[int, dict[str, int]]] = field(default_factory=list)
    stalls: Stalls = Stalls()
    reset_after: int | None = None


@dataclass(frozen=True)
class Capture:
    """What came out of a simulation.

    Parameters
    ----------
    outputs
        Per output stream the payloads taken, shaped as in :class:`Stimulus`.
    output_clocks
        Per output stream, the clock of each transfer, shape (n,).
    input_clocks
        Per input stream, the clock in which each beat was accepted, shape (n,); -1 if a reset lost
        it.
    clocks
        Clocks simulated, the quiet ones at the end included. The first clock is number 0.
    seconds
        Time that the run took, without building the simulator.
    """

    outputs: dict[str, Words]
    output_clocks: dict[str, Clocks]
    input_clocks: dict[str, Clocks]
    clocks: int
    seconds: float = field(default=0.0, compare=False)


@dataclass(frozen=True)
class Limits:
    """A run ends after ``quiet`` clocks without anything to do, or fails at ``max_clocks``."""

    quiet: int
    max_clocks: int


@dataclass(frozen=True)
class Plan:
    """A stimulus checked against the ports and laid out as the engines want it.

    Parameters
    ----------
    beats
        Per input stream, C-contiguous, shape (n, words).
    source_stalls, sink_stalls
        See :meth:`Stalls.patterns`.
    changes
        ``(beat, number of the level port, value)``, by beat; starts with the initial values at beat
        0.
    reset_after
        -1 for never.
    """

    ports: Ports
    beats: list[Words]
    source_stalls: list[NDArray[np.uint8]]
    sink_stalls: list[NDArray[np.uint8]]
    changes: list[tuple[int, int, int]]
    reset_after: int
    limits: Limits

    @property
    def total_beats(self) -> int:
        return sum(len(beats) for beats in self.beats)


def _names(kind: str, given: object, known: tuple[StreamPort, ...] | tuple[LevelPort, ...]) -> None:
    names = [port.name for port in known]
    if given not in names:
        raise ValueError(f"{kind} {given!r} is not there; allowed: {', '.join(names) or 'none'}")


def _payloads(port: StreamPort, given: Words | None) -> Words:
    if given is None:
        return np.zeros((0, port.words), np.uint64)
    array = np.ascontiguousarray(given)
    if array.dtype.kind not in "ui" or (array.dtype.kind == "i" and array.size and array.min() < 0):
        raise ValueError(f"beats of {port.name} are {array.dtype}; allowed: whole numbers from 0")
    if array.ndim == 1 and port.words == 1:
        array = array.reshape(-1, 1)
    if array.ndim != 2 or array.shape[1] != port.words:
        shape = "(n,)" if port.words == 1 else f"(n, {port.words})"
        raise ValueError(f"beats of {port.name} have shape {given.shape}; allowed: {shape}")
    array = array.astype(np.uint64, copy=False)
    last_bits = port.width - 64 * (port.words - 1)
    if len(array) and int(array[:, -1].max()) >> last_bits:
        raise ValueError(f"beats of {port.name} exceed {port.width} bits")
    return array


def _changes(ports: Ports, levels: list[tuple[int, dict[str, int]]]) -> list[tuple[int, int, int]]:
    numbers = {port.name: number for number, port in enumerate(ports.levels)}
    changes = [(0, number, port.init) for number, port in enumerate(ports.levels)]
    for beat, values in sorted(levels, key=lambda change: change[0]):
        if beat < 0:
            raise ValueError(f"levels change at beat {beat}; allowed: from 0")
        for name, value in values.items():
            _names("plain input", name, ports.levels)
            width = ports.levels[numbers[name]].width
            if not 0 <= value < 1 << width:
                raise ValueError(f"{name} is {value}; allowed: 0 to {(1 << width) - 1}")
            changes.append((beat, numbers[name], int(value)))
    return changes


def default_max_clocks(longest: int, stalls: Stalls, quiet: int) -> int:
    """Eight times what ``longest`` beats take at one per clock, and room for the latency."""
    return 8 * int(longest / ((1 - stalls.inputs) * (1 - stalls.outputs))) + 10 * quiet + 100_000


def prepare(ports: Ports, stimulus: Stimulus, *, quiet: int, max_clocks: int | None, has_reset: bool) -> Plan:
    """Check a stimulus and lay it out; ``ValueError`` names what is wrong and what is allowed."""
    for name in stimulus.beats:
        _names("input stream", name, ports.inputs)
    if quiet < 1:
        raise ValueError(f"quiet is {quiet}; allowed: from 1")
    beats = [_payloads(port, stimulus.beats.get(port.name)) for port in ports.inputs]
    reset_after = -1 if stimulus.reset_after is None else stimulus.reset_after
    if stimulus.reset_after is not None:
        most = len(beats[0]) if beats else 0
        if not has_reset:
            raise ValueError("reset_after is set, but the design has no reset")
        if not 0 <= reset_after <= most:
            raise ValueError(f"reset_after is {reset_after}; allowed: 0 to {most}, the first stream's beats")
    sources, sinks = stimulus.stalls.patterns(ports)
    if max_clocks is None:
        longest = max(map(len, beats), default=0)
        max_clocks = default_max_clocks(longest, stimulus.stalls, quiet)
    changes = _changes(ports, stimulus.levels)
    return Plan(ports, beats, sources, sinks, changes, reset_after, Limits(quiet, max_clocks))


def shaped(port: StreamPort, payloads: Words) -> Words:
    """(n, words) as the callers see it: (n,) where one word is enough."""
    return payloads.reshape(-1) if port.words == 1 else payloads.reshape(-1, port.words)
