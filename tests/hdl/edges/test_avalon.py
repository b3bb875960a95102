# amaranth: UnusedElaboratable=no
"""Avalon edges: packets of Avalon-ST Video in, packets of records out, registers of Avalon-MM."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from golden import Settings
from golden.output_constructor import encode_frame_time
from golden.preprocessing import Image
from golden.video import Event, VideoModel, VideoSettings, framed
from hdl.build import Build
from hdl.edges.avalon import AvalonCore
from hdl.edges.register_map import IDENTITY, register_map
from sim import Stalls, Stimulus
from sim.engine import EngineName
from tests.hdl.edges.bench import simulate
from tests.hdl.edges.components import PlainAvalonCore, packets
from tests.support.blocks import ENGINES, NO_STALLS, engine
from tests.support.photographs import photograph

WIDTH, HEIGHT = 33, 24
PARAMETERS = Build.profile("paper", max_width=WIDTH, max_height=HEIGHT, autostart=True)
CONTROL_PACKET = [0xF, 0, 0, 2, 1, 0, 0, 1, 8, 3]
SIGMA1 = Settings.default(PARAMETERS).sigma1_fixed
ADDRESSES = {register.name: register.address >> 2 for register in register_map(PARAMETERS)}


def packet(symbols: list[int]) -> list[int]:
    """Beats of one Avalon-ST packet."""
    last = len(symbols) - 1
    return [symbol | (k == 0) << 8 | (k == last) << 9 for k, symbol in enumerate(symbols)]


def video_packet(image: Image, kind: int = 0) -> list[int]:
    return packet([kind, *image.ravel().tolist()])


IMAGES = [photograph(name)[50 : 50 + HEIGHT, 80 : 80 + WIDTH] for name in ("brick", "grass", "text", "coins")]


def run(
    beats: list[int],
    frames: list[list[tuple[int, bool, bool]]],
    stalls: Stalls = NO_STALLS,
    name: EngineName = "compiled",
) -> Any:
    """Compare what comes of these beats with what the model makes of these frames."""
    runner = engine(name, PlainAvalonCore, PARAMETERS)
    model = VideoModel(PARAMETERS)
    video = VideoSettings(WIDTH, HEIGHT, Settings.default(PARAMETERS), ignore_eol=True)
    expected = [packet for frame in frames for packet in model.feed(frame, video)]
    capture = runner.run(Stimulus({"video": np.array(beats, np.uint64)}, [], stalls), quiet=2000)
    got = packets(capture)
    assert len(got) == len(expected)
    for one, words in zip(expected, got, strict=True):
        assert one.matches(words)
    # a packet starts with the beat after the last one's end
    starts = capture.outputs["starts"].tolist()
    assert starts == [int(k == 0) for words in got for k in range(len(words))]
    return capture


@pytest.mark.parametrize("stalls", [Stalls(), Stalls(0.4, 0.4, 1)], ids=["flowing", "both stall"])
def test_frames_among_other_packets(stalls: Stalls) -> None:
    beats: list[int] = []
    for image in IMAGES:
        beats += packet(CONTROL_PACKET) + video_packet(image) + packet([4, 1, 2, 3])
    run(beats, [framed(image) for image in IMAGES], stalls)


@pytest.mark.parametrize("name", ENGINES)
def test_only_the_low_four_bits_tell_the_type(name: EngineName) -> None:
    beats = packet([4, 1, 2, 3]) + video_packet(IMAGES[0], 0xA0) + video_packet(IMAGES[1], 0x01)
    run(beats, [framed(IMAGES[0])], name=name)


def test_one_pixel_per_clock() -> None:
    beats = [beat for image in IMAGES for beat in video_packet(image)]
    clocks = run(beats, [framed(image) for image in IMAGES]).input_clocks["video"]
    assert clocks[-1] - clocks[0] + 1 == len(beats) == 4 * (WIDTH * HEIGHT + 1)


def test_a_packet_that_is_too_short_is_cut_by_the_next() -> None:
    short = framed(IMAGES[1])[:400]
    beats = video_packet(IMAGES[0]) + packet([0, *(pixel for pixel, _, _ in short)]) + video_packet(IMAGES[2])
    run(beats, [framed(IMAGES[0]), short, framed(IMAGES[2])])


def test_a_packet_that_is_too_long_loses_its_surplus() -> None:
    beats = packet([0, *IMAGES[0].ravel().tolist(), *[9] * 50]) + video_packet(IMAGES[2])
    run(beats, [framed(IMAGES[0]), [(9, False, False)] * 50, framed(IMAGES[2])])


def test_pixels_between_packets_are_dropped() -> None:
    stray = [7, 8, 9]
    run(stray + video_packet(IMAGES[0]) + stray + video_packet(IMAGES[1]), [framed(i) for i in IMAGES[:2]])


async def write(context: Any, dut: AvalonCore, name: str, value: int, enable: int = 0xF) -> None:
    context.set(dut.avs_registers_address, ADDRESSES[name])
    context.set(dut.avs_registers_writedata, value)
    context.set(dut.avs_registers_byteenable, enable)
    context.set(dut.avs_registers_write, 1)
    await context.tick()
    context.set(dut.avs_registers_write, 0)


async def read(context: Any, dut: AvalonCore, names: list[str]) -> list[int]:
    """Reads in clock after clock: so are the answers, two clocks late."""
    got, valid = [], []
    for clock in range(len(names) + 4):
        context.set(dut.avs_registers_read, int(clock < len(names)))
        if clock < len(names):
            context.set(dut.avs_registers_address, ADDRESSES[names[clock]])
        valid.append(context.get(dut.avs_registers_readdatavalid))
        if valid[-1]:
            got.append(context.get(dut.avs_registers_readdata))
        await context.tick()
    assert valid == [0, 0, *[1] * len(names), 0, 0]
    return got


def test_registers() -> None:
    dut = AvalonCore(PARAMETERS)

    async def bench(context: Any) -> None:
        # asked for in reset, it waits; afterwards nothing does
        context.set(dut.avs_registers_read, 1)
        context.set(dut.avs_registers_write, 1)
        context.set(dut.avs_registers_byteenable, 0xF)
        context.set(dut.avs_registers_address, ADDRESSES["SIGMA1"])
        assert context.get(dut.avs_registers_waitrequest) and not context.get(dut.asi_video_ready)
        await context.tick()
        assert not context.get(dut.avs_registers_waitrequest) and context.get(dut.asi_video_ready)
        context.set(dut.avs_registers_read, 0)
        context.set(dut.avs_registers_write, 0)
        assert await read(context, dut, ["ID", "SIGMA1", "ID"]) == [IDENTITY, SIGMA1, IDENTITY]
        assert await read(context, dut, ["ID", "SIZE", "ID"]) == [IDENTITY, WIDTH | HEIGHT << 16, IDENTITY]
        await write(context, dut, "SIZE", 20 | 18 << 16)
        await write(context, dut, "SIGMA1", 0x1234)
        await write(context, dut, "SIGMA1", 0xFFFFFF56, 0b0001)
        await write(context, dut, "SIZE", 2000 | 18 << 16)
        await write(context, dut, "ID", 0)
        got = await read(context, dut, ["SIZE", "SIGMA1", "STATUS", "ID"])
        assert got == [20 | 18 << 16, 0x1256, Event.SIZE_REFUSED, IDENTITY]
        assert not context.get(dut.ins_irq_irq)
        await write(context, dut, "IRQ_ENABLE", Event.SIZE_REFUSED)
        await context.tick()
        assert context.get(dut.ins_irq_irq)

    simulate(dut, bench)


def test_times() -> None:
    """A frame's time is the clock in which its first pixel is taken, after the packet's type."""
    dut, image = AvalonCore(PARAMETERS), IMAGES[0][:16, :20]
    words: list[int] = []
    starts: list[int] = []
    clock, over = 0, False

    async def bench(context: Any) -> None:
        nonlocal over
        context.set(dut.aso_records_ready, 1)
        await context.tick()
        await write(context, dut, "SIZE", 20 | 16 << 16)
        await write(context, dut, "CONTROL", 0b100001)
        for _ in range(3):
            for number, beat in enumerate(video_packet(image)):
                context.set(dut.asi_video_valid, 1)
                context.set(dut.asi_video_data, beat & 0xFF)
                context.set(dut.asi_video_startofpacket, beat >> 8 & 1)
                context.set(dut.asi_video_endofpacket, beat >> 9)
                while not context.get(dut.asi_video_ready):
                    await context.tick()
                if number == 1:
                    starts.append(clock)
                await context.tick()
                context.set(dut.asi_video_valid, 0)
                if number == 0:
                    # the type came earlier
                    await context.tick().repeat(5)
        while len(words) < 3:
            await context.tick()
        now = clock
        names = ["NOW_LOW", "NOW_HIGH", "FRAME_TIME_LOW", "FRAME_TIME_HIGH", "NOW_LOW"]
        assert await read(context, dut, names) == [now + 1, 0, starts[-1], 0, now + 5]
        over = True

    async def take(context: Any) -> None:
        nonlocal clock
        while not over:
            if context.get(dut.aso_records_valid) and context.get(dut.aso_records_endofpacket):
                words.append(context.get(dut.aso_records_data))
            await context.tick()
            clock += 1

    # in this order within each clock
    simulate(dut, take, bench)
    assert words == [encode_frame_time(start) for start in starts]


def test_no_video_out() -> None:
    with pytest.raises(ValueError, match="video_out is True; allowed with Avalon edges: False"):
        AvalonCore(Build.profile("paper", video_out=True))
