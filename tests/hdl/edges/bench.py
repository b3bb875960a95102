"""Amaranth's simulator for events, registers and handshakes, clock by clock."""

from __future__ import annotations

from collections import Counter
from collections.abc import Awaitable, Callable
from typing import Any

from amaranth.lib import wiring
from amaranth.sim import Simulator

Bench = Callable[[Any], Awaitable[None]]


def simulate(component: wiring.Component, *benches: Bench) -> None:
    """Run test benches until all have ended."""
    simulator = Simulator(component)
    simulator.add_clock(1e-8)
    for bench in benches:
        simulator.add_testbench(bench)
    simulator.run()


async def put(context: Any, stream: Any, payload: Any) -> None:
    """One beat into a stream, however long that takes."""
    context.set(stream.valid, 1)
    context.set(stream.payload, payload)
    while not context.get(stream.ready):
        await context.tick()
    await context.tick()
    context.set(stream.valid, 0)


def counted(context: Any, events: Any, seen: Counter[str]) -> None:
    """Add the events of this clock."""
    seen.update(name for name, _ in events.shape() if context.get(events[name]))
