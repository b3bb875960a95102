# amaranth: UnusedElaboratable=no
"""Stream parts: nothing is lost, doubled or reordered, at full rate, whoever waits for whom."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from hdl.parts.stream import Beat, Columns, Pipeline, SkidBuffer, WindowCounter
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import RUN_IDS, RUNS, Size, Words, check_block, pack, raster

BITS = 16
HISTORY = data.StructLayout({"now": BITS, "beat_before": BITS, "three_clocks": BITS})
every_run = pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)


def numbers(name: EngineName, seed: int = 0) -> Words:
    count = 3000 if name == "compiled" else 150
    return np.random.default_rng(seed).integers(0, 1 << BITS, count, np.uint64)


@every_run
def test_skid_buffer(name: EngineName, stalls: Stalls) -> None:
    beats = numbers(name)
    check_block((SkidBuffer, BITS), {"i": beats}, {"o": beats}, name, stalls)


def test_skid_buffer_holds_two_and_its_ready_comes_from_a_register() -> None:
    dut = SkidBuffer(BITS)

    async def bench(ctx: Any) -> None:
        ctx.set(dut.i.valid, 1)
        for beat, ready in enumerate((1, 1, 0, 0)):
            ctx.set(dut.i.payload, 100 + beat)
            assert ctx.get(dut.i.ready) == ready
            assert not ctx.get(dut.o.valid) or ctx.get(dut.o.payload) == 100
            ctx.set(dut.o.ready, 1)
            # a ready output must not show at the input before the next clock, nor a valid input at
            # the output
            assert ctx.get(dut.i.ready) == ready
            ctx.set(dut.o.ready, 0)
            assert ctx.get(dut.o.valid) == (beat > 0)
            await ctx.tick()
        ctx.set(dut.i.valid, 0)
        ctx.set(dut.o.ready, 1)
        for beat in (100, 101):
            assert ctx.get(dut.o.valid) and ctx.get(dut.o.payload) == beat
            await ctx.tick()
        assert not ctx.get(dut.o.valid) and ctx.get(dut.i.ready)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()


class Permitted(wiring.Component):
    """A pipeline of three registers that needs permission for each beat."""

    latency = 3

    def __init__(self) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(BITS)),
                "permission": In(stream.Signature(1)),
                "o": Out(stream.Signature(HISTORY)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.permission.valid)
        m.d.comb += self.permission.ready.eq(pipe.valid & pipe.advance)
        now = pipe.register(self.i.payload, "now", when=pipe.valid)
        beat_before = pipe.register(now, "beat_before", when=pipe.valid)
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True)),
            self.o.payload.now.eq(pipe.delay(now, 2, "now")),
            self.o.payload.beat_before.eq(pipe.delay(beat_before, 2, "beat_before")),
            self.o.payload.three_clocks.eq(pipe.delay(self.i.payload, 3, "three_clocks")),
        ]
        return m


@every_run
def test_pipeline(name: EngineName, stalls: Stalls) -> None:
    """Bubbles between beats do not count as beats; the last beats leave although no more come."""
    beats = numbers(name)
    earlier = np.concatenate([np.zeros(1, np.uint64), beats[:-1]])
    expected = {"now": beats, "beat_before": earlier, "three_clocks": beats}
    given = {"i": beats, "permission": np.zeros(len(beats), np.uint64)}
    capture = check_block((Permitted,), given, {"o": expected}, name, stalls)
    assert np.array_equal(capture.input_clocks["i"], capture.input_clocks["permission"])


class Counted(wiring.Component):
    """Marks the columns that complete a window of 1, 3 and 9 columns."""

    sizes = (1, 3, 9)
    o_shape = data.StructLayout({f"complete_{size}": 1 for size in sizes})

    def __init__(self) -> None:
        super().__init__({"i": In(stream.Signature(Beat(1))), "o": Out(stream.Signature(self.o_shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        m.d.comb += self.o.valid.eq(pipe.register(pipe.valid, "valid", reset=True))
        step = pipe.valid & pipe.advance
        for size in self.sizes:
            window = WindowCounter(m, size, step=step, eol=self.i.payload.eol)
            flag = pipe.register(window.complete, f"complete_{size}")
            m.d.comb += self.o.payload[f"complete_{size}"].eq(flag)
        return m


@every_run
def test_window_counter(name: EngineName, stalls: Stalls) -> None:
    sizes: list[Size] = [(3, 12), (2, 9), (4, 8), (1, 1), (2, 10)]
    x = [np.tile(np.arange(width), (height, 1)) for height, width in sizes]
    expected = {f"complete_{size}": raster(x)["data"] >= size - 1 for size in Counted.sizes}
    beats = raster([0 * frame for frame in x])
    check_block((Counted,), {"i": beats}, {"o": expected}, name, stalls, latency=1)


def test_layouts() -> None:
    """The first row of a column is the oldest, in the lowest bits; the tags come last."""
    columns = pack(Columns(8, 3), {"data": np.array([[1, 2, 3]]), "eol": np.array([1]), "eof": np.array([0])})
    assert columns.tolist() == [1 | 2 << 8 | 3 << 16 | 1 << 24]
    beat = pack(Beat(8), {"data": np.array([7]), "eol": np.array([1]), "eof": np.array([1])})
    assert beat.tolist() == [7 | 3 << 8]
