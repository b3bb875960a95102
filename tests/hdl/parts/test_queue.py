# amaranth: UnusedElaboratable=no
"""Queue: in order and at full rate, and nothing is lost where room is heeded."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from hdl.parts.queue import ROOM, Queue
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import RUN_IDS, RUNS, Words, check_block, latency, run_block

BITS = 16
every_run = pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)


def numbers(name: EngineName) -> Words:
    count = 3000 if name == "compiled" else 150
    return np.random.default_rng(0).integers(0, 1 << BITS, count, np.uint64)


class Heeding(wiring.Component):
    """A source that reads ``room`` a clock late, and with ``twice`` has one more beat each time."""

    def __init__(self, depth: int, twice: bool, registered: bool = False) -> None:
        self._depth, self._registered = depth, registered
        self._twice = twice
        port = stream.Signature(BITS)
        super().__init__({"i": In(port), "o": Out(port)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.queue = queue = Queue(BITS, self._depth, registered=self._registered)
        room, step, again, repeated = Signal(init=1), Signal(), Signal(), Signal(BITS)
        m.d.sync += room.eq(queue.room)
        m.d.comb += [
            self.i.ready.eq(room & ~again),
            step.eq(self.i.valid & self.i.ready),
            queue.i.valid.eq(step | again),
            queue.i.payload.eq(Mux(again, repeated, self.i.payload)),
        ]
        if self._twice:
            m.d.sync += [again.eq(step), repeated.eq(~self.i.payload)]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m


@every_run
@pytest.mark.parametrize("registered", [False, True])
@pytest.mark.parametrize("depth", [4, 5, 16])
def test_queue(depth: int, registered: bool, name: EngineName, stalls: Stalls) -> None:
    beats = numbers(name)
    late = Queue(BITS, depth, registered=registered).latency
    assert late == Queue.latency + registered
    block = (Heeding, depth, False, registered)
    capture = check_block(block, {"i": beats}, {"o": beats}, name, stalls, latency=late)
    if not stalls.outputs:
        assert (latency(capture) == late).all()


@every_run
@pytest.mark.parametrize(("depth", "registered"), [(3, False), (4, False), (5, False), (9, False), (5, True)])
def test_nothing_is_lost_with_one_more_to_come(
    depth: int, registered: bool, name: EngineName, stalls: Stalls
) -> None:
    beats = numbers(name)
    both = np.stack([beats, ~beats & np.uint64((1 << BITS) - 1)], axis=1).reshape(-1)
    run_block((Heeding, depth, True, registered), {"i": beats}, {"o": both}, name, stalls, clocks=4)


@pytest.mark.parametrize("depth", [3, 4, 5, 16, 20])
def test_room_falls_when_three_places_are_left_and_all_of_them_hold(depth: int) -> None:
    dut = Queue(BITS, depth)

    async def bench(ctx: Any) -> None:
        assert ctx.get(dut.room) and ctx.get(dut.i.ready)
        put = 0

        async def fill(until: int) -> None:
            nonlocal put
            ctx.set(dut.i.valid, 1)
            while put < until:
                ctx.set(dut.i.payload, 100 + put)
                put += 1
                await ctx.tick()
            ctx.set(dut.i.valid, 0)
            await ctx.tick()

        # one moves on to the output
        await fill(1 + depth - ROOM)
        assert ctx.get(dut.room)
        await fill(put + 1)
        assert not ctx.get(dut.room)
        await fill(1 + depth)
        ctx.set(dut.o.ready, 1)
        rooms = []
        for beat in range(put):
            assert ctx.get(dut.o.valid) and ctx.get(dut.o.payload) == 100 + beat
            rooms.append(ctx.get(dut.room))
            await ctx.tick()
        assert not ctx.get(dut.o.valid)
        # room as soon as three have left the memory
        assert rooms == [0] * ROOM + [1] * (put - ROOM)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()


def test_too_short_for_room() -> None:
    with pytest.raises(ValueError, match="depth is 2; allowed: whole numbers from 3"):
        Queue(BITS, 2)
