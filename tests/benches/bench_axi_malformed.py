"""Malformed video through the core, one test per kind, each with and without pauses on both sides.

Each asserts that STATUS holds exactly what happened, that every packet is closed, and that the next
well-formed frame is exact (``Bench.check``). What may be expected of the frames that are cut, the
golden model says.
"""

from __future__ import annotations

import random
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import replace
from typing import Any

import cocotb
from cocotb.triggers import ClockCycles, RisingEdge, Timer

from golden import Settings
from golden.video import NO_LIMIT, Event, VideoSettings
from tests.benches.axi import ROUNDS, Bench, cells, draw
from tests.benches.common import Dut
from tests.support import malformed
from tests.support.filters import selective
from tests.support.malformed import Beats, Fault, Random

PAUSES = [0.0, 0.35]
NONE, DONE, CUT = Event(0), Event.FRAME_DONE, Event.FRAME_CUT


def row(test: Callable[[Bench, Random], Awaitable[None]]) -> Any:
    """Makes a cocotb test, with and without pauses, called ``ROUNDS`` times with other sizes."""

    async def run(dut: Dut, pauses: float) -> None:
        bench, random_ = Bench(dut, idle=pauses, stall=pauses), draw()
        await bench.start()
        for _ in range(ROUNDS):
            await configure(bench, random_)
            await test(bench, random_)
        print(f"{bench.input.beats} beats, {bench.output.beats} records, {bench.input.clock} clocks")

    run.__name__ = run.__qualname__ = test.__name__
    run.__doc__ = test.__doc__
    return cocotb.test(timeout_time=50, timeout_unit="ms")(cocotb.parametrize(pauses=PAUSES)(run))


async def configure(bench: Bench, random_: Random, **changes: int) -> None:
    p = bench.parameters
    width = int(random_.integers(bench.narrowest, p.max_width + 1))
    height = int(random_.integers(bench.least, p.max_height + 1))
    rejected = bool(random_.integers(2))
    settings = Settings.default(p, sigma1=0.02, sigma2=selective(p), report_rejected=rejected, **cells(p))
    video = VideoSettings(width, height, settings, send_time=bool(random_.integers(2)))
    await bench.configure(replace(video, **changes))


def smallest(bench: Bench, random_: Random) -> VideoSettings:
    """As it is set, but for the size: hardly larger than the smallest that never waits."""
    width = int(random_.integers(bench.small, bench.small + 5)) * bench.lanes - bench.lanes // 2
    return replace(bench.video, width=width, height=bench.small)


def happened(bench: Bench) -> Event:
    """What the model has seen, but for the surplus of cells, which frames may have."""
    surplus = Event.RECORDS_DROPPED if bench.parameters.max_per_cell else NONE
    return bench.model.events & ~surplus


def frame(bench: Bench, random_: Random, fault: Fault = malformed.whole) -> Beats:
    return malformed.by_beats(fault, bench.image(random_), bench.lanes, random_)


async def between(bench: Bench, random_: Random, fault: Fault, exactly: Event, perhaps: Event = NONE) -> None:
    """A frame with such a fault between two that have none."""
    for each in (malformed.whole, fault, malformed.whole):
        bench.send(frame(bench, random_, each))
    assert happened(bench) & ~perhaps == exactly, happened(bench)
    assert not bench.expected[-1].cut
    await bench.check()


@row
async def early_sof(bench: Bench, random_: Random) -> None:
    await between(bench, random_, malformed.early_sof, DONE | CUT | Event.SOF_EARLY)


@row
async def early_sof_right_after_a_frame(bench: Bench, random_: Random) -> None:
    """1, 2, 3 ... pixels after a complete frame, which comes out whole."""
    line = bench.beats_of_a_line
    counts = [*range(1, 12), *(line + k for k in (-1, 0, 1))]
    if ROUNDS > 1:
        counts = list(range(1, 3 * line))
    bench.video = replace(bench.video, height=bench.small)
    await bench.configure(bench.video)
    for count in counts:
        bench.send(frame(bench, random_))
        bench.send(frame(bench, random_)[:count])
    bench.send(frame(bench, random_))
    assert [packet.cut for packet in bench.expected] == [False, True] * len(counts) + [False]
    assert happened(bench) == DONE | CUT | Event.SOF_EARLY
    await bench.check()


@row
async def sof_held(bench: Bench, random_: Random) -> None:
    """For some pixels: the frame begins with the last of them, so its first line is too short."""
    await between(bench, random_, malformed.sof_always, DONE | CUT | Event.SOF_EARLY | Event.EOL_EARLY)


@row
async def late_sof(bench: Bench, random_: Random) -> None:
    await between(bench, random_, malformed.late_sof, DONE | Event.SOF_LATE)


@row
async def missing_sof(bench: Bench, random_: Random) -> None:
    """After a frame, and as the very first."""
    await between(bench, random_, malformed.missing_sof, DONE | Event.SOF_LATE | Event.SOF_MISSING)
    await bench.soft_reset()
    bench.forget()
    bench.send(frame(bench, random_, malformed.missing_sof))
    bench.send(frame(bench, random_))
    assert happened(bench) == DONE | Event.SOF_MISSING
    await bench.check()


@row
async def short_line(bench: Bench, random_: Random) -> None:
    await between(bench, random_, malformed.short_line, DONE | CUT | Event.EOL_EARLY)


@row
async def long_line(bench: Bench, random_: Random) -> None:
    await between(bench, random_, malformed.long_line, DONE | Event.EOL_LATE, Event.EOL_MISSING)


@row
async def lost_tlast(bench: Bench, random_: Random) -> None:
    """One line runs into the next: the frame lacks one, or the next frame's first line ends it."""
    perhaps = CUT | Event.SOF_EARLY | Event.EOL_MISSING
    await between(bench, random_, malformed.lost_eol, DONE | Event.EOL_LATE, perhaps)


@row
async def tlast_never(bench: Bench, random_: Random) -> None:
    events = DONE | CUT | Event.SOF_EARLY | Event.EOL_LATE | Event.EOL_MISSING
    await between(bench, random_, malformed.no_eol, events)


@row
async def tlast_ignored(bench: Bench, random_: Random) -> None:
    """With ``ignore_eol``, frames without ends of line, or with wrong ones, are accepted."""
    video = bench.video
    await bench.configure(replace(video, ignore_eol=True))
    bench.send(frame(bench, random_, malformed.no_eol))
    bench.send(frame(bench, random_, malformed.no_eol))
    bench.send([(pixel, sof, random.random() < 0.05) for pixel, sof, _ in frame(bench, random_)])
    bench.send(frame(bench, random_))
    assert [packet.cut for packet in bench.expected] == [False] * 4
    assert happened(bench) == DONE
    await bench.check()


@row
async def framing_at_random(bench: Bench, random_: Random) -> None:
    for _ in range(4):
        bench.send(frame(bench, random_, malformed.noise_marks))
    bench.send(frame(bench, random_))
    await bench.check()


async def amid(bench: Bench, random_: Random) -> None:
    """Queues a frame; returns when a part of it has been taken."""
    start = bench.input.beats
    bench.send(frame(bench, random_))
    await bench.taken(start + int(random_.integers(5, max(6, bench.beats_of_a_frame - 60))))


@row
async def size_changed(bench: Bench, random_: Random) -> None:
    """The new size holds from the next frame on, larger or smaller."""
    for _ in range(3):
        await amid(bench, random_)
        # which holds at once
        await configure(bench, random_, send_time=bench.video.send_time)
        bench.send(frame(bench, random_))
        assert happened(bench) == DONE
        bench.extra = Event.SIZE_CHANGED
        await bench.check()


@row
async def size_out_of_range(bench: Bench, random_: Random) -> None:
    """Neither the frame under way nor the next one takes notice."""
    p, least, narrowest = bench.parameters, bench.least, bench.narrowest
    over = (p.max_width + 1, 20), (narrowest, p.max_height + 1)
    for width, height in ((narrowest - 1, least), (narrowest, least - 1), *over, (0, 0)):
        await amid(bench, random_)
        await bench.write_fields("SIZE", width=width, height=height)
        bench.send(frame(bench, random_))
        bench.extra = Event.SIZE_REFUSED
        await bench.check()


def places(beats: int, *dense: int) -> Iterator[int]:
    """Some steps of a sweep over so many beats: others each time, and more around some beats."""
    step = 17 if ROUNDS > 1 else 61
    yield from range(random.randrange(step), beats, step)
    for place in dense:
        yield from range(place - random.randrange(8), place + 30, 7)


@row
async def soft_reset_anywhere(bench: Bench, random_: Random) -> None:
    """In either of two frames, the first still inside when the second begins; and after them."""
    bench.video = smallest(bench, random_)
    await bench.configure(bench.video)
    size = bench.beats_of_a_frame
    kinds = set()
    for place in places(2 * size + 300, size, 2 * size):
        start = bench.input.beats
        for _ in range(2):
            bench.send(frame(bench, random_))
        await bench.taken(start + min(place, 2 * size))
        await ClockCycles(bench.dut.clk, max(0, place - 2 * size))
        await bench.soft_reset()
        assert all([await bench.read(name) == 0 for name in ("FRAMES", "CORNERS", "DROPPED", "MAXIMUM")])
        await bench.source.done()
        await bench.quiet()
        # a frame that begins after the reset is whole
        begun = 2 - await bench.read("FRAMES")
        assert begun == 1 if place < size - 100 else begun == 2 if place > size else begun in (1, 2)
        before = bench.interrupt(begun)
        bench.send(frame(bench, random_))
        early, cut = await bench.check_reset(before)
        assert early == begun or cut
        assert cut or place > 2 * size - 40
        kinds.add((begun, early, cut))
    assert kinds >= {(1, 1, True), (2, 1, True), (2, 2, True), (2, 2, False)}, kinds


@row
async def hard_reset_anywhere(bench: Bench, random_: Random) -> None:
    """Reset by the pin, also during accesses to registers."""
    video = smallest(bench, random_)
    bench.video = video
    size = bench.beats_of_a_frame
    for place in places(2 * size + 100):
        await bench.configure(video)
        start = bench.input.beats
        for _ in range(2):
            bench.send(frame(bench, random_))
        await bench.taken(start + min(place, 2 * size))
        if place % 2:
            cocotb.start_soon(bench.registers.axi.read(0, 64))
            cocotb.start_soon(bench.registers.axi.write(0x20, bytes(16)))
            await ClockCycles(bench.dut.clk, random.randrange(20))
        await bench.hard_reset()
        await bench.configure(video)
        bench.send(frame(bench, random_))
        assert bench.expected[0].frame == 0
        await bench.check()


@row
async def input_stopped(bench: Bench, random_: Random) -> None:
    """The input stops for long in a frame; then a new frame comes."""
    await bench.write("TIMEOUT", 900)
    source = bench.source.axi
    generator = source._pause_generator
    for _ in range(4):
        bench.send(frame(bench, random_))
        start = bench.input.beats
        size = bench.beats_of_a_frame
        count = int(random_.integers(5, size - 5))
        bench.send(frame(bench, random_)[:count])
        bench.send(frame(bench, random_))
        # offered, but not taken yet: the source stops behind it
        while bench.input.beats != start + size + count - 1 or not bench.dut.s_axis_tvalid.value:
            await RisingEdge(bench.dut.clk)
            await Timer(1, "ns")
        source.clear_pause_generator()
        source.pause = True
        await ClockCycles(bench.dut.clk, 2000)
        assert bench.input.beats == start + size + count
        assert await bench.read("STATUS") & Event.INPUT_IDLE
        source.pause = False
        source.set_pause_generator(generator)
        assert happened(bench) == DONE | CUT | Event.SOF_EARLY
        bench.extra = Event.INPUT_IDLE
        await bench.check()
    await bench.write("TIMEOUT", 0)


async def block(bench: Bench, random_: Random, frames: int) -> None:
    """No output is taken any more, until no input is either."""
    for sink in bench.sinks:
        sink.axi.clear_pause_generator()
        sink.axi.pause = True
    for _ in range(frames):
        bench.send(frame(bench, random_))
    stalls = bench.input.stalls
    while bench.input.stalls < stalls + 800:
        stalls = bench.input.stalls
        await ClockCycles(bench.dut.clk, 800)
    assert not bench.source.axi.empty(), "never blocked"
    await bench.write("IRQ_ENABLE", 0x1FFF)
    assert await bench.read("IRQ_ENABLE") == 0x1FFF
    await bench.write("IRQ_ENABLE", 0)
    assert await bench.read("ID") == 0x434F524E


def release(bench: Bench) -> None:
    for sink in bench.sinks:
        sink.axi.pause = False


@row
async def output_stalled(bench: Bench, random_: Random) -> None:
    """For ever, as it seems: registers answer; and nothing is lost when it goes on."""
    await bench.write("TIMEOUT", 1500)
    bench.video = smallest(bench, random_)
    await bench.configure(bench.video)
    await block(bench, random_, 60)
    await ClockCycles(bench.dut.clk, 1500)
    assert await bench.read("STATUS") & Event.OUTPUT_STALLED
    release(bench)
    bench.extra = Event.OUTPUT_STALLED
    # where the source pauses, the frame may have waited for pixels as long
    await bench.check()
    await bench.write("TIMEOUT", 0)


@row
async def soft_reset_while_stalled(bench: Bench, random_: Random) -> None:
    """Done when the output goes on; frames whose start had not come yet are the first again.

    It is done when the last beat of the cut frame's packet is on offer, so that it waits for what
    comes before: a beat that was on offer, or the end-of-frame record where a time record follows.
    """
    bench.video = smallest(bench, random_)
    await bench.configure(bench.video)
    start = bench.input.beats
    await block(bench, random_, 60)
    # the last two beats wait outside of all that is reset
    size = bench.beats_of_a_frame
    begun = -(-(bench.input.beats - start - 2) // size)
    # the pixels' output alone can block the first frame before it has a record
    offered = int(bench.dut.m_axis_tvalid.value)
    assert offered or bench.parameters.video_out
    waits = int(offered or bench.video.send_time)
    await bench.soft_reset(wait=False)
    await ClockCycles(bench.dut.clk, 300)
    assert (await bench.fields("CONTROL"))["reset"] == waits
    assert bench.dut.m_axis_tvalid.value
    assert offered or bool(bench.dut.m_axis_tlast.value) != bench.video.send_time
    release(bench)
    while (await bench.fields("CONTROL"))["reset"]:
        pass
    before = bench.interrupt(begun)
    assert bench.expected
    assert await bench.check_reset(before) != (begun, False)


@row
async def records_overflow(bench: Bench, random_: Random) -> None:
    """Also where MAX_RECORDS changes from frame to frame."""
    bench.send(frame(bench, random_))
    most = bench.expected[-1].found
    await bench.check()
    video = bench.video
    image = bench.image(random_)
    for limit in (0, 1, max(most - 1, 0), most, NO_LIMIT):
        await bench.configure(replace(video, max_records=limit))
        bench.send(image)
        bench.send(frame(bench, random_))
        assert happened(bench) & ~Event.RECORDS_DROPPED == DONE
        packet = bench.expected[-1]
        await bench.check()
        await bench.check_results(packet)


@row
async def disabled(bench: Bench, random_: Random) -> None:
    """Disabled in a frame, which goes on; later ones are dropped, which is not an error."""
    for _ in range(2):
        await amid(bench, random_)
        await bench.enable(False)
        await bench.source.done()
        bench.send(frame(bench, random_))
        bench.send(frame(bench, random_, malformed.short_line))
        await bench.source.done()
        await bench.enable(True)
        bench.send(frame(bench, random_))
        assert [packet.cut for packet in bench.expected] == [False, False]
        assert happened(bench) == DONE
        await bench.check()
