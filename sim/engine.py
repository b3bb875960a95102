"""One interface for every engine: Amaranth's simulator, compiled C++, emitted Verilog.

All engines obey the same rules, so that even the clock of each transfer agrees between them:

- In every clock a source presents its next beat unless its pattern pauses it; once presented, a
  beat stays, unchanged, until it is accepted. A sink is ready unless its pattern pauses it.
- What is driven takes effect at once; valid, ready and payload are sampled when the combinational
  logic has settled, just before the rising edge that ends the clock.
- A run starts from power-on, with all plain inputs at their initial values. It ends after ``quiet``
  clocks in which all inputs were consumed and no output was valid.
- An output must keep valid and payload until it is taken; otherwise, :class:`StreamError`.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Literal, Protocol

from sim.ports import Ports
from sim.stimulus import Capture, Plan, Stimulus

EngineName = Literal["compiled", "amaranth", "verilog"]
Progress = Callable[[int, int], None]
"""Called from time to time with the accepted beats and their total, over all input streams."""

QUIET = 1000
"""Clocks without any work after which a run ends, unless told otherwise."""
VCD_CLOCKS = 10_000
"""Clocks written to a waveform file, unless told otherwise."""


class SimulationError(Exception):
    """Base of all errors while a design runs."""


class SimulationHang(SimulationError):
    """The design has not finished within ``max_clocks``."""


class StreamError(SimulationError):
    """An output stream has broken the stream rules."""


class Engine(Protocol):
    """A component, elaborated once, that can be run any number of times."""

    name: str
    """Name of the engine in reports, such as ``"compiled (g++ 12.2.0)"``."""
    ports: Ports

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
        """Run from power-on until all is done.

        Parameters
        ----------
        stimulus
            What to feed.
        progress
            See :data:`Progress`.
        vcd
            File for the waves of the first ``vcd_clocks`` clocks. A GTKWave save file of the same
            name, ending in ``.gtkw``, is written beside it.
        vcd_clocks
            Length of the waves.
        quiet
            The run ends after that many clocks with all inputs consumed and no output valid.
        max_clocks
            Limit; None: several times what one beat per clock takes.

        Raises
        ------
        SimulationHang
            The limit was reached.
        StreamError
            An output broke the stream rules.
        ValueError
            The stimulus does not fit the ports.
        """
        ...


def hang(plan: Plan, accepted: list[int], delivered: list[int]) -> SimulationHang:
    """The error that says how far each stream had come."""
    inputs = [
        f"{port.name} {done} of {len(beats)} in"
        for port, done, beats in zip(plan.ports.inputs, accepted, plan.beats, strict=True)
    ]
    outputs = [f"{port.name} {done} out" for port, done in zip(plan.ports.outputs, delivered, strict=True)]
    return SimulationHang(
        f"the design has not finished after {plan.limits.max_clocks} clocks; beats: "
        + ", ".join(inputs + outputs)
    )


def broken_rule(plan: Plan, stream: int, clock: int, held: int, seen: int | None) -> StreamError:
    """The error for output number ``stream``; ``seen`` is None where valid was withdrawn."""
    name = plan.ports.outputs[stream].name
    what = "withdrew valid" if seen is None else f"changed the payload from {held:#x} to {seen:#x}"
    return StreamError(f"stream {name} {what} at clock {clock} before the beat {held:#x} was taken")
