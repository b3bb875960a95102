"""The optional video output: pixels as they went in, corners marked, at full rate, held up or not.

All other benches compare it too (``Bench.check``); here is what concerns it alone.
"""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles

from golden import Settings, decode
from golden.video import Event, VideoSettings
from tests.benches.axi import ROUNDS, Bench, draw
from tests.benches.common import Dut
from tests.support import malformed
from tests.support.filters import strict
from tests.support.malformed import Random

LAST_CORNER = 40
"""Clocks by which it can be later, or sooner, than in another frame."""


async def configure(bench: Bench, random_: Random, width: int, height: int, **changes: int) -> None:
    p = bench.parameters
    settings = Settings.default(p, sigma1=0.02, sigma2=strict(p), report_rejected=True)
    await bench.configure(VideoSettings(width, height, settings, **changes))


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def corners_are_marked(dut: Dut) -> None:
    """Those that the texture filter lets pass, whether or not they are reported, and no other."""
    bench, random_ = Bench(dut), draw()
    await bench.start()
    p = bench.parameters
    for most in (0xFF_FFFF, 0):
        await configure(bench, random_, p.max_width, p.max_height, max_records=0xFF_FFFF)
        images = [bench.image(random_), *(bench.squares(random_) for _ in range(1 + ROUNDS))]
        for image in images:
            bench.send(image)
        records = np.concatenate([packet.records for packet in bench.expected])
        accepted = int(decode(records).accepted.sum())
        marks = sum(
            int(user).bit_count() - (k == 0)
            for shown in bench.shown.expected
            for k, user in enumerate(shown.beats[:, 1])
        )
        rejected = len(decode(records)) - accepted
        assert 0 < accepted == marks and (rejected > 0) == (p.algorithm.texture != "none")
        await bench.check()
        await configure(bench, random_, p.max_width, p.max_height, max_records=most)
        bench.send(images[0])
        await bench.check()


@cocotb.test(timeout_time=5, timeout_unit="ms")
async def full_rate(dut: Dut) -> None:
    """At the built maximum, where most pixels are held back: W·H clocks per frame, in and out.

    Where a gradient step takes long, or noise waits, frames have so few corners that none does.
    """
    bench, random_ = Bench(dut), draw()
    await bench.start()
    p = bench.parameters
    await configure(bench, random_, p.max_width, p.max_height)
    many = not (p.algorithm.fit == "gradient" or bench.noise_waits)
    for _ in range(4):
        bench.send(bench.image(random_) if many else bench.squares(random_, 16))
    assert many or all(packet.found for packet in bench.expected)
    await bench.check()
    beats = bench.beats_of_a_frame
    assert np.diff(bench.input.times[::beats]).tolist() == [beats] * 3
    # some pixels of the very first frame come out at once, because they can have no flag; where a
    # beat has several, a frame's first one waits for the last corner of the frame before
    late = np.diff(bench.video_output.times[::beats][1:]) - beats
    assert (abs(late) <= (bench.lanes > 1) * LAST_CORNER).all(), late
    assert not bench.input.stalls
    assert await bench.read("CLOCKS") == beats


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(idle=[0.0, 0.5], stall=[0.0, 0.9], video_stall=[0.0, 0.6])
async def three_streams(dut: Dut, idle: float, stall: float, video_stall: float) -> None:
    """Each with pauses or not: nothing hangs, nothing is lost."""
    bench, random_ = Bench(dut, idle=idle, stall=stall, video_stall=video_stall), draw()
    await bench.start()
    p = bench.parameters
    for width, height in (
        (bench.narrowest, bench.least),
        (p.max_width, 17),
        (21 * bench.lanes, p.max_height),
    ):
        await configure(bench, random_, width, height)
        for _ in range(1 + ROUNDS):
            bench.send(bench.image(random_))
        await bench.check()


@cocotb.test(timeout_time=10, timeout_unit="ms")
async def one_output_stalled(dut: Dut) -> None:
    """For ever, as it seems, and the other is not; then both are exact."""
    bench, random_ = Bench(dut), draw()
    await bench.start()
    p = bench.parameters
    for sink in (*bench.sinks, *bench.sinks):
        await configure(bench, random_, p.max_width, 20)
        sink.axi.pause = True
        for _ in range(40):
            bench.send(bench.image(random_))
        before = -1
        while bench.input.beats != before:
            before = bench.input.beats
            await ClockCycles(dut.clk, 600)
        assert not bench.source.axi.empty(), "never held up"
        sink.axi.pause = False
        await bench.check()


@cocotb.test(timeout_time=10, timeout_unit="ms")
@cocotb.parametrize(stall=[0.0, 0.3])
async def malformed_video(dut: Dut, stall: float) -> None:
    """What has come of a cut frame is shown up to some pixel, and the next frame whole."""
    bench, random_ = Bench(dut, idle=stall, stall=stall), draw()
    await bench.start()
    p = bench.parameters
    pieces = 0
    await configure(bench, random_, p.max_width - 1, p.max_height)
    for fault in (malformed.early_sof, malformed.short_line, malformed.long_line, malformed.no_eol):
        for _ in range(ROUNDS):
            bench.send(bench.image(random_))
            bench.send(malformed.by_beats(fault, bench.image(random_), bench.lanes, random_))
            bench.send(bench.image(random_))
            await bench.check()
            pieces += bench.shown.pieces
    bench.send(bench.image(random_))
    bench.send(bench.whole(bench.image(random_))[:-1])
    bench.send(bench.image(random_))
    assert bench.model.events == Event.FRAME_DONE | Event.FRAME_CUT | Event.SOF_EARLY
    await bench.check()
    assert bench.shown.pieces == 1
    print(f"{pieces} pieces")
