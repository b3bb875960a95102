"""The registers of the AXI core: addresses, reset values, bytes, refusals, interrupts.

Addresses and contents are written out here, not taken from the map, so that a change of it must be
made twice.
"""

from __future__ import annotations

import random

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge
from cocotbext.axi import AxiResp

from golden.algorithm import PROFILES
from golden.version import VERSION
from golden.video import Event
from sim.cocotb_bench import CLOCK_NS
from tests.benches.axi import ROUNDS, Bench, draw, usual
from tests.benches.common import Dut, watch_lite

ALL = 0xFFFF_FFFF
EVENTS = (1 << 13) - 1
READ_ONLY = (0x00, 0x04, 0x08, 0x0C, 0x40, 0x44, 0x48, 0x4C, 0x50, 0x64, 0x68, 0x6C)
NOW = 0x60
"""The low half: read only, but it never stays."""
WRITABLE = {
    0x10: 0b111101,  # CONTROL without RESET
    0x18: EVENTS,
    0x20: 0xFFFF,
    0x24: 0xF_FFFF,
    0x30: 0xFF_FFFF,
    0x34: 0xFF_FFFF,
}
"""Which bits keep what is written to them, where all values are allowed; REFERENCE_INIT and
REFERENCE_MIN depend on the build.
"""
STATUS, SIZE, CONTROL, IRQ_ENABLE, TIMEOUT = 0x14, 0x1C, 0x10, 0x18, 0x34


def writable(bench: Bench) -> dict[int, int]:
    response = (1 << bench.parameters.response_bits) - 1
    # the rank, and two bits of smoothing
    budget = {0x38: ALL, 0x3C: 0x3FFFF} if bench.parameters.budget else {}
    return {**WRITABLE, **budget, 0x28: response, 0x2C: response}


def reset_values(bench: Bench) -> dict[int, int]:
    p = bench.parameters
    unit = 1 << (2 * p.pixel_bits + 1)
    flags = {
        8: p.algorithm.gradient == "signed",
        9: p.algorithm.ties == "first",
        10: p.algorithm.fit == "six",
        11: p.algorithm.patches == "pixels",
        12: p.buffering == "lean",
        13: p.video_out,
        14: p.algorithm.pixel_filter == "binomial",
        15: p.algorithm.divider == "table",
        19: p.algorithm.texture == "none",
        20: p.algorithm.derivative == "sobel",
        21: p.algorithm.response_filter == "binomial",
        22: p.algorithm.texture == "mean",
        23: p.max_per_cell > 0,
        26: p.algorithm.pixel_filter == "twice",
        31: p.budget,
    }
    profiles = [*PROFILES.values()]
    profile = profiles.index(p.algorithm) + 1 if p.algorithm in profiles else 0
    return {
        0x00: 0x434F_524E,
        0x04: sum(int(part) << 8 * k for k, part in enumerate(reversed(VERSION.split(".")))),
        0x08: p.pixels_per_clock
        | p.pixel_bits << 4
        | sum(flag << bit for bit, flag in flags.items())
        | profile << 16
        | (p.algorithm.suppression * (p.algorithm.suppression > 1)) << 28,
        0x0C: p.max_height << 16 | p.max_width,
        CONTROL: int(p.autostart),
        STATUS: 0,
        IRQ_ENABLE: 0,
        SIZE: p.max_height << 16 | p.max_width,
        0x20: 3277,  # 0.05
        0x24: 32768,  # 0.5
        0x28: unit // 16,
        0x2C: unit // 128,
        0x30: 0xFF_FFFF,
        TIMEOUT: 0xFF_FFFF,
        **dict.fromkeys((0x40, 0x44, 0x48, 0x4C, 0x50, 0x64, 0x68, 0x6C), 0),
        **(dict.fromkeys((0x38, 0x3C, 0x54), 0) if p.budget else {}),
        **({0x58: 0x4040, 0x5C: p.max_per_cell << 16 | p.min_cell_width} if p.max_per_cell else {}),
    }


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(bus=[0.0, 0.5])
async def after_reset(dut: Dut, bus: float) -> None:
    """Each word reads its reset value or is refused; read-only words refuse writes."""
    bench = Bench(dut, bus=bus)
    await bench.start()
    values = reset_values(bench)
    assert sorted((*values, NOW)) == [register.address for register in bench.map.values()]
    for address in set(range(0, 256, 4)) - {NOW}:
        if address in values:
            await bench.hold({address: values[address]})
        else:
            assert await bench.registers.read(address, expect=AxiResp.SLVERR) == 0
            await bench.registers.write(address, ALL, expect=AxiResp.SLVERR)
    for address in READ_ONLY:
        for value in (0, ALL, random.getrandbits(32)):
            await bench.registers.write(address, value, expect=AxiResp.SLVERR)
            await bench.hold({address: values[address]})
    await bench.hold(values)
    assert not bench.irq


@cocotb.test(timeout_time=2, timeout_unit="ms")
@cocotb.parametrize(bus=[0.0, 0.5])
async def bytes_of_registers(dut: Dut, bus: float) -> None:
    """Any bytes of any register that can be written, alone or several at once; the others stay."""
    bench = Bench(dut, bus=bus)
    await bench.start()
    contents = reset_values(bench)
    masks = writable(bench)
    refused = False
    for _ in range(100 * ROUNDS):
        address = random.choice([SIZE, *masks])
        low = random.randrange(4)
        count = random.randrange(1, 5 - low)
        data = random.randbytes(count)
        lanes = ((1 << (8 * count)) - 1) << (8 * low)
        value = (contents[address] & ~lanes) | int.from_bytes(data, "little") << (8 * low)
        if address == CONTROL:
            # not the reset
            data = bytes(byte & ~(2 if low + k == 0 else 0) for k, byte in enumerate(data))
        if address == SIZE:
            p = bench.parameters
            height = random.randrange(bench.least, p.max_height + 1)
            size = height << 16 | random.randrange(bench.narrowest, p.max_width + 1)
            data = size.to_bytes(4, "little")[low : low + count]
            # of a part nobody can tell whether it is in range
            value = size if count == 4 else contents[address]
            refused |= count < 4
        else:
            value &= masks[address]
        answer = await bench.registers.axi.write(address + low, data)
        assert answer.resp == AxiResp.OKAY
        contents[address] = value
        await bench.hold({address: value})
    assert refused
    await bench.hold({**contents, STATUS: int(Event.SIZE_REFUSED)})
    # several registers in one go: CONSTANT to TIMEOUT
    words = [random.getrandbits(32) & masks[address] for address in (0x28, 0x2C, 0x30, 0x34)]
    answer = await bench.registers.axi.write(0x28, b"".join(word.to_bytes(4, "little") for word in words))
    assert answer.resp == AxiResp.OKAY
    await bench.hold(dict(zip((0x28, 0x2C, 0x30, 0x34), words, strict=True)))


@cocotb.test(timeout_time=1, timeout_unit="ms")
@cocotb.parametrize(bus=[0.0, 0.5])
async def time_goes_on(dut: Dut, bus: float) -> None:
    """NOW is the clock after the one in which its address is taken, whatever else happens."""
    bench = Bench(dut, bus=bus)
    asked = watch_lite(dut, channels=("ar",))["ar"]
    await bench.start()
    await usual(bench)
    bench.send(bench.squares(draw()))
    await bench.check()
    for k in range(60):
        if k == 20:
            await bench.soft_reset()
        if k == 40:
            await bench.registers.write(NOW, ALL, expect=AxiResp.SLVERR)
        now = await bench.registers.read(NOW)
        assert now == asked.times[-1] - bench.reset_at + 1
    await bench.hold({NOW + 4: 0})
    await bench.hard_reset()
    await bench.hold(dict.fromkeys((NOW + 4, NOW + 8, NOW + 12), 0))
    assert await bench.registers.read(NOW) < 100


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def asked_in_reset(dut: Dut) -> None:
    """Reset without the bus and the source: all accesses wait, and are answered afterwards."""
    pins = {name: getattr(dut, f"s_axil_{name}") for name in ("awvalid", "wvalid", "arvalid")}
    pins["tvalid"] = dut.s_axis_tvalid
    for pin in pins.values():
        pin.value = 1
    for name, value in (("awaddr", 0x20), ("wdata", 0x1234), ("wstrb", 15), ("araddr", 0)):
        getattr(dut, f"s_axil_{name}").value = value
    others = (
        "s_axis_tdata",
        "s_axis_tkeep",
        "s_axis_tuser",
        "s_axis_tlast",
        "s_axil_awprot",
        "s_axil_arprot",
    )
    for name in others:
        if hasattr(dut, name):
            getattr(dut, name).value = 0
    for name in ("s_axil_bready", "s_axil_rready", "m_axis_tready", "m_axis_video_tready"):
        if hasattr(dut, name):
            getattr(dut, name).value = 1
    readies = {name: pin._name.replace("valid", "ready") for name, pin in pins.items()}
    dut.rst.value = 1
    Clock(dut.clk, CLOCK_NS, "ns").start()
    await ClockCycles(dut.clk, 2)
    for _ in range(5):
        await RisingEdge(dut.clk)
        assert not any(getattr(dut, ready).value for ready in readies.values())
    dut.rst.value = 0
    taken, answers = set(), []
    for _ in range(12):
        await RisingEdge(dut.clk)
        for name, ready in readies.items():
            if pins[name].value and getattr(dut, ready).value:
                taken.add(name)
                pins[name].value = 0
        if dut.s_axil_bvalid.value:
            answers.append(("b", int(dut.s_axil_bresp.value)))
            # and now what has been written
            dut.s_axil_araddr.value = 0x20
            pins["arvalid"].value = 1
        if dut.s_axil_rvalid.value:
            answers.append(("r", int(dut.s_axil_rdata.value)))
    assert taken == set(pins)
    assert sorted(answers) == [("b", 0), ("r", 0x1234), ("r", 0x434F_524E)]


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def size_refused(dut: Dut) -> None:
    """Out of range in either half: nothing changes, and a bit of STATUS says so."""
    bench = Bench(dut)
    await bench.start()
    p, least, narrowest = bench.parameters, bench.least, bench.narrowest
    good = (p.max_height - 1) << 16 | p.max_width - 1
    await bench.registers.write(SIZE, good)
    await bench.check_events(Event(0))
    bad = [(narrowest - 1, least), (narrowest, least - 1), (p.max_width + 1, least)]
    bad += [(narrowest, p.max_height + 1), (0, 0), (65535, 65535), (0, 20), (narrowest, 0)]
    bad += [(narrowest + 1024, least), (narrowest, least + 1024), (32768, least)]
    for width, height in bad:
        await bench.registers.write(SIZE, height << 16 | width)
        await bench.hold({SIZE: good})
        await bench.check_events(Event.SIZE_REFUSED)
    for width, height in ((narrowest, least), (p.max_width, p.max_height)):
        await bench.registers.write(SIZE, height << 16 | width)
        await bench.hold({SIZE: height << 16 | width})
        await bench.check_events(Event(0))


@cocotb.test(timeout_time=3, timeout_unit="ms")
async def interrupts(dut: Dut) -> None:
    """High exactly while an enabled bit is set: each bit alone, with several bits set."""
    bench = Bench(dut, idle=0.1)
    await bench.start()
    await usual(bench)
    for _ in range(ROUNDS):
        image = bench.squares(draw())
        beats, last, dark = bench.whole(image), bench.beats_of_a_line - 1, bench.pixel()
        # a long line; a frame, and another cut by the end of a line; pixels that belong to none
        pixels, sof, _ = beats[last]
        bench.send([*beats[:last], (pixels, sof, False), (dark, False, True), *beats[last + 1 :]])
        bench.send([*beats[: last // 2], (dark, False, True)])
        bench.send(image)
        bench.send([(dark, False, True)])
        await bench.registers.write(SIZE, 0)
        await bench.quiet()
        happened = Event.FRAME_DONE | Event.FRAME_CUT | Event.SOF_LATE | Event.EOL_EARLY | Event.EOL_LATE
        happened |= Event.SIZE_REFUSED
        assert bench.model.events == happened ^ Event.SIZE_REFUSED
        left = happened
        for event in Event:
            await bench.registers.write(IRQ_ENABLE, int(event))
            await ClockCycles(dut.clk, 2)
            assert bench.irq == bool(left & event), event
            # others being cleared does not matter
            await bench.registers.write(STATUS, EVENTS & ~int(event) & ~int(left))
            assert bench.irq == bool(left & event), event
            await bench.registers.write(STATUS, int(event))
            left &= ~event
            assert await bench.registers.read(STATUS) == int(left)
            assert not bench.irq
            await bench.registers.write(IRQ_ENABLE, EVENTS)
            await ClockCycles(dut.clk, 2)
            assert bench.irq == bool(left)
        await bench.registers.write(IRQ_ENABLE, 0)
        bench.model.events = Event(0)
        await bench.check()


@cocotb.test(timeout_time=2, timeout_unit="ms")
async def status_is_cleared_by_bytes(dut: Dut) -> None:
    """Ones clear, zeros do not, and only in bytes that are written."""
    bench = Bench(dut)
    await bench.start()
    await usual(bench, max_records=0)
    bench.send(bench.squares(draw()))
    await bench.registers.write(SIZE, 0)
    await bench.quiet()
    both = int(Event.FRAME_DONE | Event.RECORDS_DROPPED | Event.SIZE_REFUSED)
    await bench.hold({STATUS: both})
    await bench.registers.write(STATUS, 0)
    await bench.registers.write(STATUS, ALL & ~both)
    await bench.hold({STATUS: both})
    await bench.registers.axi.write(STATUS, b"\xff")
    await bench.hold({STATUS: both & ~0xFF})
    await bench.registers.axi.write(STATUS + 2, b"\xff\xff")
    await bench.hold({STATUS: both & ~0xFF})
    await bench.registers.axi.write(STATUS + 1, bytes([1]))
    await bench.hold({STATUS: int(Event.SIZE_REFUSED)})
    bench.model.events, bench.extra = Event(0), Event.SIZE_REFUSED
    await bench.check()
