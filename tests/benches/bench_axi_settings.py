"""Settings and results by software while video runs, with register traffic at all times."""

from __future__ import annotations

import random
from collections.abc import Callable

import cocotb
from cocotb.triggers import ClockCycles
from cocotbext.axi import AxiResp

from golden import Settings
from golden.video import Event, VideoSettings
from tests.benches.axi import ROUNDS, Bench, draw, usual
from tests.benches.bench_axi_registers import CONTROL, IRQ_ENABLE, READ_ONLY, SIZE, STATUS, TIMEOUT
from tests.benches.common import Dut
from tests.support.filters import lenient


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def max_records(dut: Dut) -> None:
    """Packets have no more than that, and CORNERS and DROPPED count what was found."""
    bench = Bench(dut, idle=0.05)
    await bench.start()
    await usual(bench)
    image = bench.squares(draw())
    bench.send(image)
    bench.send(image)
    found = bench.expected[-1].found
    packet = bench.expected[-1]
    assert found > 3
    await bench.check()
    await bench.check_results(packet)
    for limit in (0, 1, found - 1, found, found + 1, 0xFF_FFFF):
        await usual(bench, max_records=limit)
        bench.send(image)
        packet = bench.expected[-1]
        assert len(packet.records) - 1 == min(found, limit) and packet.found == found
        assert bool(bench.model.events & Event.RECORDS_DROPPED) == (limit < found)
        await bench.check()
        await bench.check_results(packet)


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def soft_reset(dut: Dut) -> None:
    """Reads 1 until done; forgets frames and results, but no setting and no bit of STATUS."""
    bench = Bench(dut)
    await bench.start()
    p = bench.parameters
    settings = Settings.default(p, sigma1=0.01, sigma2=lenient(p), constant=321, floor=7)
    await bench.configure(VideoSettings(31 * bench.lanes, 23, settings, max_records=1000))
    await bench.registers.write(IRQ_ENABLE, int(Event.FRAME_DONE))
    await bench.registers.write(TIMEOUT, 12345)
    kept = {
        a: await bench.registers.read(a) for a in (CONTROL, IRQ_ENABLE, SIZE, 0x20, 0x24, 0x28, 0x2C, 0x30)
    }
    image = bench.squares(draw())
    for _ in range(2):
        bench.send(image)
        # the next frame's first pixel does not wait
        await bench.quiet()
    packet = bench.expected[-1]
    beats = bench.beats_of_a_frame
    clocks = bench.input.times[-1] - bench.input.times[-beats] + 1
    # a gradient step holds up frames as narrow as these
    assert clocks == beats or (clocks > beats and p.algorithm.fit == "gradient")
    await bench.check_results(packet)
    bench.compare(bench.received())
    assert bench.irq
    await bench.soft_reset()
    await bench.hold({**kept, TIMEOUT: 12345, STATUS: int(Event.FRAME_DONE), 0x4C: clocks})
    await bench.hold(dict.fromkeys((0x40, 0x44, 0x48, 0x50), 0))
    assert bench.irq
    if bench.parameters.video_out:
        bench.shown.check(bench.sinks[1])
    bench.forget()
    # the first frame again: number 0, reference from REFERENCE_INIT
    bench.send(image)
    packet = bench.expected[-1]
    assert packet.frame == 0
    await bench.check()
    await bench.check_results(packet)


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def enable(dut: Dut) -> None:
    """Frames that start while disabled are dropped; one that is under way goes on."""
    bench = Bench(dut, idle=0.2, stall=0.2)
    await bench.start()
    await usual(bench, enabled=False)
    for _ in range(2):
        bench.send(bench.squares(draw()))
    assert not bench.expected
    await bench.check()
    await bench.hold({0x40: 0})
    for _ in range(1 + ROUNDS):
        await usual(bench)
        start = bench.input.beats
        bench.send(bench.squares(draw()))
        await bench.taken(start + random.randrange(10, bench.beats_of_a_frame - 60))
        await bench.enable(False)
        await bench.source.done()
        # these are in the hardware's eyes, and the model's, without beginning
        bench.send(bench.squares(draw()))
        bench.send(bench.squares(draw())[1:])
        await bench.check()
        await usual(bench)
        bench.send(bench.squares(draw()))
        await bench.check()


async def until(condition: Callable[[], bool], dut: Dut, limit: int) -> int:
    """Clocks until that is so."""
    for clock in range(limit):
        if condition():
            return clock
        await ClockCycles(dut.clk, 1)
    raise AssertionError(f"nothing in {limit} clocks")


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def input_idle(dut: Dut) -> None:
    """After TIMEOUT clocks without a pixel in a frame, once for each wait, not between frames."""
    bench = Bench(dut)
    await bench.start()
    await usual(bench)
    await bench.registers.write(IRQ_ENABLE, int(Event.INPUT_IDLE))
    for timeout in (0, 1, 40, 300):
        await bench.registers.write(TIMEOUT, timeout)
        start = bench.input.beats
        bench.send(bench.squares(draw()))
        for pixels in (50, 120, 200):
            await bench.taken(start + pixels)
            bench.source.axi.pause = True
            await until(lambda: not dut.s_axis_tvalid.value, dut, 10)
            if timeout:
                clocks = await until(lambda: bool(bench.irq), dut, timeout + 10)
                assert timeout <= clocks <= timeout + 5, clocks
                await bench.check_events(bench.model.events & ~Event.FRAME_DONE | Event.INPUT_IDLE)
            # not again for this wait
            await ClockCycles(dut.clk, 2 * timeout + 700)
            await bench.check_events(Event(0))
            bench.source.axi.pause = False
        await bench.check()
        await ClockCycles(dut.clk, timeout + 700)
        await bench.check_events(Event(0))


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def timeout_lowered(dut: Dut) -> None:
    """Below what a wait has lasted already: it is over at once."""
    bench = Bench(dut)
    await bench.start()
    await usual(bench)
    await bench.registers.write(TIMEOUT, 0)
    bench.send(bench.squares(draw()))
    await bench.taken(100)
    bench.source.axi.pause = True
    await ClockCycles(dut.clk, 600)
    await bench.registers.write(TIMEOUT, 5000)
    await bench.hold({STATUS: 0})
    await bench.registers.write(TIMEOUT, 300)
    await bench.hold({STATUS: int(Event.INPUT_IDLE)})
    bench.source.axi.pause = False
    bench.extra = Event.INPUT_IDLE
    await bench.check()


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def ends_wait(dut: Dut) -> None:
    """A frame is done, or cut, when its last beat is taken: not while it is on offer."""
    bench = Bench(dut)
    await bench.start()
    await usual(bench, max_records=0)
    await bench.registers.write(IRQ_ENABLE, int(Event.FRAME_DONE | Event.FRAME_CUT))
    whole = bench.whole(bench.squares(draw()))
    for beats in (whole, [*whole[:10], (bench.pixel(), False, True)]):
        bench.sink.axi.pause = True
        bench.send(beats)
        # corners can hold up the input, but not the end for longer than that after it
        await bench.source.done()
        await until(lambda: bool(dut.m_axis_tvalid.value), dut, bench.longest)
        await ClockCycles(dut.clk, 300)
        assert bool(dut.m_axis_tlast.value) != bench.video.send_time and not bench.irq
        before = Event(await bench.registers.read(STATUS))
        assert before == bench.model.events & ~(Event.FRAME_DONE | Event.FRAME_CUT)
        bench.sink.axi.pause = False
        await until(lambda: bool(bench.irq), dut, 10)
        # whose pixels end the line that a cut frame's have begun, where they are passed on
        bench.send(whole)
        await bench.check()


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def output_stalled(dut: Dut) -> None:
    """After TIMEOUT clocks in which an output beat is not taken, for each output."""
    bench = Bench(dut)
    await bench.start()
    await usual(bench)
    await bench.registers.write(IRQ_ENABLE, int(Event.OUTPUT_STALLED))
    for sink, name in zip(bench.sinks, ("m_axis", "m_axis_video"), strict=False):
        valid = getattr(dut, f"{name}_tvalid")
        for timeout in (0, 30, 200):
            await bench.registers.write(TIMEOUT, timeout)
            sink.axi.pause = True
            bench.send(bench.squares(draw()))
            # the first beat: nothing holds up the input before it
            most = bench.beats_of_a_frame + bench.longest
            await until(lambda valid=valid: bool(valid.value), dut, most)
            if timeout:
                clocks = await until(lambda: bool(bench.irq), dut, timeout + 10)
                assert timeout <= clocks <= timeout + 5, clocks
            await ClockCycles(dut.clk, timeout + 500)
            assert bool(bench.irq) == bool(timeout)
            sink.axi.pause = False
            bench.extra = Event.OUTPUT_STALLED if timeout else Event(0)
            await bench.check()


@cocotb.test(timeout_time=3, timeout_unit="ms")
@cocotb.parametrize(bus=[0.0, 0.4])
async def traffic_while_video_runs(dut: Dut, bus: float) -> None:
    """Reads and writes at once do not change any record, and each is answered rightly."""
    bench = Bench(dut, idle=0.1, stall=0.1, bus=bus)
    await bench.start()
    await usual(bench)
    constant = {
        address: await bench.registers.read(address) for address in (0x00, 0x08, 0x0C, SIZE, 0x20, 0x2C)
    }
    accesses = 0

    async def reads() -> None:
        nonlocal accesses
        while True:
            address = random.randrange(0, 256, 4)
            mapped = any(register.address == address for register in bench.map.values())
            value = await bench.registers.read(address, AxiResp.OKAY if mapped else AxiResp.SLVERR)
            assert value == constant.get(address, value)
            accesses += 1

    async def writes() -> None:
        nonlocal accesses
        while True:
            value = random.getrandbits(13)
            await bench.registers.write(IRQ_ENABLE, value)
            assert await bench.registers.read(IRQ_ENABLE) == value
            await bench.registers.write(random.choice(READ_ONLY), value, expect=AxiResp.SLVERR)
            await bench.registers.write(STATUS, 0)
            accesses += 4

    for _ in range(6 * ROUNDS):
        bench.send(bench.squares(draw()))
    tasks = [cocotb.start_soon(reads()), cocotb.start_soon(writes())]
    await bench.source.done()
    await ClockCycles(dut.clk, 100)
    for task in tasks:
        task.cancel()
    await ClockCycles(dut.clk, 50)
    assert accesses > 200
    print(f"{accesses} accesses")
    await bench.check()
