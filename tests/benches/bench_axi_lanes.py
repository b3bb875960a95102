"""Several pixels per clock: beats that lack pixels or have too many, and lines of every width.

What becomes of all else that is malformed, ``bench_axi_malformed`` tries at any number of pixels.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import cocotb

from golden.video import Event
from tests.benches.axi import ROUNDS, Bench, draw
from tests.benches.bench_axi_malformed import CUT, DONE, NONE, configure, frame, happened, row
from tests.benches.common import Dut
from tests.support import malformed
from tests.support.malformed import Beats, Random, hollow

Kept = tuple[bool, ...]
"""Of each place of a beat, whether there is a pixel."""


def keeping(beats: Beats, place: int, kept: Kept) -> Beats:
    """One beat has these pixels; where it had none, they are bright."""
    pixels, sof, eol = beats[place]
    assert isinstance(pixels, tuple)
    changed = tuple((255 if p is None else p) if k else None for p, k in zip(pixels, kept, strict=True))
    return [*beats[:place], (changed, sof, eol), *beats[place + 1 :]]


def ends(bench: Bench, random_: Random) -> list[int]:
    """The last beats of the first line, of the last one, and of one between them."""
    line, height = bench.beats_of_a_line, bench.video.height
    return [line * (y + 1) - 1 for y in (0, int(random_.integers(1, height - 1)), height - 1)]


async def width_that_leaves(bench: Bench, left: int) -> None:
    """Few lines, with so many pixels in their last beat."""
    beats = min(bench.video.width, bench.parameters.max_width - bench.lanes) // bench.lanes
    least = -(-bench.narrowest // bench.lanes)
    width = max(least, beats) * bench.lanes + left
    await bench.configure(replace(bench.video, width=width, height=bench.small))


async def with_one(
    bench: Bench, random_: Random, change: Callable[[Beats], Beats], exactly: Event, perhaps: Event = NONE
) -> None:
    """Such a frame between two that have no fault."""
    whole = frame(bench, random_)
    bench.send(frame(bench, random_))
    bench.send(change(whole))
    bench.send(frame(bench, random_))
    assert happened(bench) & ~perhaps == exactly, happened(bench)
    assert [packet.cut for packet in bench.expected] == [False, bool(exactly & CUT), False]
    await bench.check()


@row
async def pixels_missing(bench: Bench, random_: Random) -> None:
    """A line is short by less than a beat, or by all of its last one, wherever lines end."""
    for ignoring in (False, True):
        await bench.configure(replace(bench.video, ignore_eol=ignoring))
        for left in {1, bench.lanes // 2, bench.lanes}:
            await width_that_leaves(bench, left)
            for place in ends(bench, random_):
                there = int(random_.integers(left))
                kept = tuple(lane < there for lane in range(bench.lanes))
                # the last beat of a frame is followed by nothing that could be dropped
                late = Event.SOF_LATE
                events = DONE | CUT | Event.EOL_EARLY
                await with_one(
                    bench, random_, lambda beats, p=place, k=kept: keeping(beats, p, k), events, late
                )


@row
async def pixels_beyond(bench: Bench, random_: Random) -> None:
    """A line is too long by less than a beat: the surplus is dropped, which ignore_eol allows."""
    for ignoring in (False, True):
        await bench.configure(replace(bench.video, ignore_eol=ignoring))
        for left in {1, bench.lanes // 2, bench.lanes - 1}:
            await width_that_leaves(bench, left)
            for place in ends(bench, random_):
                beyond = random_.integers(2, size=bench.lanes) > 0
                beyond[int(random_.integers(left, bench.lanes))] = True
                kept = tuple(bool(lane < left or beyond[lane]) for lane in range(bench.lanes))
                events = DONE | (NONE if ignoring else Event.EOL_LATE)
                await with_one(bench, random_, lambda beats, p=place, k=kept: keeping(beats, p, k), events)


@row
async def holes(bench: Bench, random_: Random) -> None:
    """A pixel is missing before a line's last beat, at a beat's end or within it."""
    line = bench.beats_of_a_line
    for y in (0, int(random_.integers(1, bench.video.height))):
        for lane in {0, bench.lanes // 2, bench.lanes - 1}:
            place = y * line + int(random_.integers(line - 1))
            kept = tuple(k != lane for k in range(bench.lanes))
            await with_one(
                bench,
                random_,
                lambda beats, p=place, k=kept: keeping(beats, p, k),
                DONE | CUT | Event.EOL_EARLY,
            )


@row
async def one_beat(bench: Bench, random_: Random) -> None:
    """The first line has one beat, whole or not: nothing of its frame is seen but a packet."""

    def first_line(beats: Beats, kept: Kept) -> Beats:
        pixels, sof, _ = keeping(beats, 0, kept)[0]
        return [(pixels, sof, True), *beats[bench.beats_of_a_line :]]

    for there in (1, bench.lanes):
        kept = tuple(lane < there for lane in range(bench.lanes))
        await with_one(
            bench, random_, lambda beats, k=kept: first_line(beats, k), DONE | CUT | Event.EOL_EARLY
        )


@row
async def anything(bench: Bench, random_: Random) -> None:
    """Faults that move pixels, which can be less than a beat, and pixels that are there or not."""
    faults = [*malformed.FAULTS.values()]
    for _ in range(4 * ROUNDS):
        fault = faults[int(random_.integers(len(faults)))]
        beats = malformed.by_pixels(fault, bench.image(random_), bench.lanes, random_)
        bench.send(hollow(beats, random_, 2) if random_.integers(2) else beats)
        # a line that has not ended would take in the next frame's first one
        bench.send(frame(bench, random_))
        bench.send(frame(bench, random_))
        assert not bench.expected[-1].cut
        await bench.check()


@cocotb.test(timeout_time=5, timeout_unit="ms")
@cocotb.parametrize(pauses=[0.0, 0.35])
async def every_width(dut: Dut, pauses: float) -> None:
    """From the narrowest on, whatever is left over for a line's last beat."""
    bench, random_ = Bench(dut, idle=pauses, stall=pauses), draw()
    await bench.start()
    for k in range(2 * bench.lanes + 1):
        await configure(bench, random_)
        await bench.configure(replace(bench.video, width=bench.narrowest + k, height=bench.least + k % 3))
        for _ in range(3):
            bench.send(bench.image(random_))
        assert not any(packet.cut for packet in bench.expected)
        await bench.check()
