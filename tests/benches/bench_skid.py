"""Tests the component of ``tests/sim/test_cocotb_bench.py``, and the drivers of ``common``."""

from __future__ import annotations

import os
import random

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles
from cocotbext.axi import AxiResp
from numpy.typing import NDArray

from tests.benches.common import Dut, Registers, Sink, VideoSource, reset, start, watch_lite, watch_stream

WIDTH, HEIGHT = 12, 5


def image() -> NDArray[np.uint8]:
    return np.frombuffer(random.randbytes(WIDTH * HEIGHT), dtype=np.uint8).reshape(HEIGHT, WIDTH)


async def expect(sink: Sink, frame: NDArray[np.uint8]) -> None:
    for y, row in enumerate(frame):
        packet = await sink.packet()
        assert packet.data == row.tolist()
        assert packet.user == [int(x == y == 0) for x in range(WIDTH)]


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(source_pauses=[0.0, 0.5], sink_pauses=[0.0, 0.5])
async def frames(dut: Dut, source_pauses: float, sink_pauses: float) -> None:
    source, sink = VideoSource(dut, share=source_pauses), Sink(dut, share=sink_pauses)
    watches = [watch_stream(dut, prefix) for prefix in ("s_axis", "m_axis")]
    await start(dut)
    sent = [image() for _ in range(int(os.environ.get("FRAMES", "3")))]
    for frame in sent:
        source.frame(frame)
    for frame in sent:
        await expect(sink, frame)
    await source.done()
    await ClockCycles(dut.clk, 20)
    assert sink.empty
    for watch in watches:
        print(f"frames {len(sent)}, beats {watch.beats}, stalls {watch.stalls}")
        assert watch.beats == len(sent) * HEIGHT * WIDTH
        assert bool(watch.stalls) == bool(sink_pauses)


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def reset_amid_a_frame(dut: Dut) -> None:
    source, sink = VideoSource(dut, share=0.2), Sink(dut, share=0.2)
    watch_stream(dut, "s_axis")
    watch_stream(dut, "m_axis")
    await start(dut)
    for k in range(5):
        source.frame(image())
        await ClockCycles(dut.clk, 20 + 5 * k)
        source.clear()
        await reset(dut, 2)
        while not sink.axi.empty():
            await sink.packet()
        frame = image()
        source.frame(frame)
        await expect(sink, frame)
        await ClockCycles(dut.clk, 20)
        assert sink.empty


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(share=[0.0, 0.5])
async def registers(dut: Dut, share: float) -> None:
    bus = Registers(dut, share=share)
    watches = watch_lite(dut)
    await start(dut)
    values = [random.getrandbits(32) for _ in range(4)]
    for k, value in enumerate(values):
        await bus.write(4 * k, value)
    assert [await bus.read(4 * k) for k in range(4)] == values
    await bus.write(16, 1, expect=AxiResp.SLVERR)
    assert await bus.read(252, expect=AxiResp.SLVERR) == 0
    # a single byte goes by strobes
    await bus.axi.write(6, b"\xab")
    assert await bus.read(4) == values[1] & ~(0xFF << 16) | 0xAB << 16
    await reset(dut)
    assert await bus.read(0) == 0
    assert {name: watch.beats for name, watch in watches.items()} == {
        "aw": 6,
        "w": 6,
        "b": 6,
        "ar": 7,
        "r": 7,
    }


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def unexpected_answer(dut: Dut) -> None:
    """Fails, as it should."""
    bus = Registers(dut)
    await start(dut)
    await bus.read(16)
