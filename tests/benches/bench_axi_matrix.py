"""Well-formed video through the core: {idle or not} x {stalled or not} x sizes, every packet exact.

Without pauses also every clock: frames take one for each beat, and ends come when they are said to.
"""

from __future__ import annotations

from dataclasses import replace

import cocotb
import numpy as np

from golden import Settings
from golden.formats import OFFSET_BITS
from golden.output_constructor import COORDINATE_BITS, Records
from golden.preprocessing import Image
from golden.video import Packet, VideoSettings
from tests.benches.axi import Bench, cells, draw
from tests.benches.common import Dut
from tests.support.filters import selective
from tests.support.malformed import Random
from tests.support.photographs import photograph

SIZES = ["least", "maximum", "odd", "tall", "wide", "photograph"]
FRAMES = 3


def size(name: str, bench: Bench) -> tuple[int, int]:
    p, small, lanes = bench.parameters, bench.small, bench.lanes
    return {
        "least": (small * lanes, small),
        "maximum": (p.max_width, p.max_height),
        "odd": (23 * lanes - lanes // 2, small + 2),
        "tall": (small * lanes + 1, p.max_height - 1),
        "wide": (p.max_width - 1, small + 1),
        "photograph": (p.max_width - 3, p.max_height - 2),
    }[name]


def images(name: str, bench: Bench, random: Random) -> list[Image]:
    """The last one has no corner."""
    width, height = size(name, bench)
    if name == "photograph":
        photo = photograph("camera")
        places = ((min(x, photo.shape[1] - width), y) for x, y in ((200, 60), (150, 230), (230, 100)))
        crops = [photo[y : y + height, x : x + width] for x, y in places]
        shift = bench.parameters.pixel_bits - 8
        return [crop.astype(np.uint16) << shift if shift > 0 else crop >> -shift for crop in crops]
    result = [bench.image(random, width, height) for _ in range(FRAMES)]
    return [*result, np.full_like(result[0], 77)]


@cocotb.test(timeout_time=5, timeout_unit="ms")
@cocotb.parametrize(frame_size=SIZES, idle=[0.0, 0.4], stall=[0.0, 0.5, 0.96])
async def matrix(dut: Dut, frame_size: str, idle: float, stall: float) -> None:
    bench, random = Bench(dut, idle=idle, stall=stall), draw()
    await bench.start()
    frames = images(frame_size, bench, random)
    height, width = frames[0].shape
    p = bench.parameters
    settings = Settings.default(p, sigma1=0.02, sigma2=selective(p), report_rejected=True, **cells(p))
    await bench.configure(VideoSettings(width, height, settings))
    for image in frames:
        bench.send(image)
    packets = list(bench.expected)
    if idle or stall or (bench.noise_waits and frame_size != "photograph"):
        await bench.check()
        await bench.check_results(packets[-1])
        assert await bench.read("CLOCKS") >= bench.beats_of_a_frame
    else:
        await unhindered(bench, packets)
    assert bench.input.beats == bench.beats_of_a_frame * len(frames)
    assert bench.output.beats == sum(len(packet.records) for packet in packets)
    if p.video_out:
        assert bench.video_output.beats == bench.input.beats
    assert bench.output.stalls or not stall or bench.output.beats < 20
    print(f"{len(frames)} frames {width}x{height}, {bench.output.beats} beats, {bench.input.clock} clocks")


async def unhindered(bench: Bench, packets: list[Packet]) -> None:
    """Frames back to back: results while the next frame is under way, and all times."""
    words: list[Records] = []
    for packet in packets:
        words.append(np.array((await bench.sink.packet()).data, np.uint64))
        # the next frame's end cannot be so near that it changes them meanwhile
        await bench.check_results(packet)
        assert await bench.read("CLOCKS") == bench.beats_of_a_frame
    bench.compare(words)
    await bench.check()

    beats = bench.beats_of_a_frame
    first = np.array(bench.input.times[::beats])
    assert (np.diff(first) == beats).all(), f"frames begin after {np.diff(first)} clocks, not {beats}"
    last = np.array(bench.input.times[beats - 1 :: beats])
    ends = np.array(bench.output.times)[np.cumsum([len(packet.records) for packet in packets]) - 1]
    # the row of cells that ends with the frame is turned over
    least = bench.frame_latency(bench.video.width) + (bench.video.settings.per_cell > 0)
    for packet, latency in zip(packets, ends - last, strict=True):
        assert least <= latency <= least + bench.refinement_latency, (latency, least)
        if not waits(packet, bench):
            assert latency == least, f"end of frame after {latency} clocks instead of {least}"
    assert not waits(packets[-1], bench) or len(packets) == FRAMES


def waits(packet: Packet, bench: Bench) -> bool:
    """May corners be under way still when a frame's last pixel comes?"""
    if packet.found < 1 or len(packet.records) < 2:
        return False
    if bench.video.settings.per_cell:
        return True
    records = packet.records[:-1].astype(np.int64)
    x = (records & ((1 << COORDINATE_BITS) - 1)) >> OFFSET_BITS
    y = (records >> COORDINATE_BITS & ((1 << COORDINATE_BITS) - 1)) >> OFFSET_BITS
    # half a pixel either way does not matter
    margin = bench.parameters.algorithm.margin
    decided = (y + 1 + margin) * bench.beats_of_a_line + (x + 1 + margin) // bench.lanes
    return bool((decided > bench.beats_of_a_frame - bench.refinement_latency).any())


@cocotb.test(timeout_time=1, timeout_unit="ms")
async def without_software(dut: Dut) -> None:
    """No register is written: frames of the maximum are taken with ``autostart``, or dropped."""
    bench, random = Bench(dut), draw()
    await bench.start()
    bench.video = replace(bench.video, enabled=bench.parameters.autostart)
    for _ in range(2):
        bench.send(bench.squares(random))
    assert len(bench.expected) == 2 * bench.parameters.autostart
    await bench.check()
