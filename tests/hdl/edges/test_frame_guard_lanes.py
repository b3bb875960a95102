"""Frame guard with several pixels per clock: beats that pass, and events, as the model has them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from golden import Settings
from golden.video import Event, Packet, VideoModel, VideoSettings, framed
from hdl.build import Build
from hdl.edges.frame_guard import GUARD_EVENTS, FrameGuard
from tests.hdl.edges.bench import counted, simulate
from tests.support.builds import each
from tests.support.malformed import FAULTS, Beats, Random, hollow, packed, whole

LANES = each("lanes", {"2": 2, "4": 4, "8": 8}, quick=("4",))
HEIGHT = 15


def build(lanes: int, pixel_bits: int = 8) -> Build:
    return Build.profile("paper", pixels_per_clock=lanes, pixel_bits=pixel_bits, max_width=45, max_height=18)


def image(width: int, seed: int = 0) -> Any:
    return np.random.default_rng(seed).integers(1, 256, (HEIGHT, width), np.uint8)


class Run:
    """A guard that is fed with pauses on both sides, and what came of it."""

    def __init__(self, dut: FrameGuard, width: int, beats: Beats, seed: int, **control: int) -> None:
        self.frames: list[list[tuple[tuple[int, ...], int, int]]] = []
        self.seen: Counter[str] = Counter()
        self._dut, self._random, self._waited = dut, np.random.default_rng(seed), 0

        async def bench(context: Any) -> None:
            for name, value in {"width": width, "height": HEIGHT, "enable": 1, **control}.items():
                context.set(getattr(dut, name), value)
            for pixels, sof, eol in beats:
                while self._random.random() < 0.2:
                    await self._clock(context)
                self._offer(context, pixels, sof, eol)
                while not await self._clock(context):
                    pass
                context.set(dut.i.valid, 0)
            for _ in range(30):
                await self._clock(context)

        simulate(dut, bench)

    def _offer(self, context: Any, pixels: Any, sof: bool, eol: bool) -> None:
        i = self._dut.i
        context.set(i.valid, 1)
        # what is not there may hold anything
        shown = [int(self._random.integers(16)) if pixel is None else int(pixel) for pixel in pixels]
        keep = sum((pixel is not None) << k for k, pixel in enumerate(pixels))
        context.set(i.payload, {"pixel": shown, "keep": keep, "sof": sof, "eol": eol})

    async def _clock(self, context: Any) -> bool:
        """A clock: what leaves, what happens, and whether a beat is taken."""
        dut = self._dut
        context.set(dut.o.ready, int(self._random.random() < 0.7))
        self._waited = self._waited + 1 if context.get(dut.cut) else 0
        # nothing is left at the output by then, as where the detector is restarted
        context.set(dut.resume, int(self._waited > 3 and not context.get(dut.o.valid)))
        counted(context, dut.events, self.seen)
        if context.get(dut.o.valid) and context.get(dut.o.ready):
            payload = context.get(dut.o.payload)
            if payload.sof:
                self.frames.append([])
            self.frames[-1].append((tuple(payload.pixel), payload.eol, payload.last_lane))
        taken = bool(context.get(dut.i.valid) and context.get(dut.i.ready))
        await context.tick()
        return taken


def expected(p: Build, beats: Beats, video: VideoSettings) -> tuple[list[Packet], Counter[str], list[int]]:
    """Packets, how often each event comes, and pixels of a frame that has not ended."""
    model, packets, seen = VideoModel(p, p.pixels_per_clock), [], Counter[str]()
    for beat in beats:
        model.events = Event(0)
        packets += model.feed([beat], video)
        seen.update(str(event.name).lower() for event in GUARD_EVENTS if event & model.events)
    return packets, seen, model._pixels * model.active


def compare(p: Build, width: int, beats: Beats, seed: int, **control: Any) -> Counter[str]:
    """Feed these, and compare all that comes out with the model; returns the events."""
    video = VideoSettings(width, HEIGHT, Settings(), **control)
    packets, seen, rest = expected(p, beats, video)
    run = Run(FrameGuard(p), width, beats, seed, **control)
    # of a frame that its first beat cuts nothing passes
    frames = [pixels for packet in packets if (pixels := packet.pixels.ravel().tolist())]
    frames += [rest] * bool(rest)
    assert len(run.frames) == len(frames)
    for pixels, got in zip(frames, run.frames, strict=True):
        rows = [pixels[k : k + width] for k in range(0, len(pixels), width)]
        flat, lanes = [], p.pixels_per_clock
        for row in rows:
            ends = [k + lanes >= width for k in range(0, len(row), lanes)]
            flat += [(row[k * lanes : (k + 1) * lanes], end) for k, end in enumerate(ends)]
        assert len(got) == len(flat)
        for (given, end), (shown, eol, last_lane) in zip(flat, got, strict=False):
            assert list(shown[: len(given)]) == given
            assert eol == end and last_lane == len(given) - 1
    assert run.seen == seen
    return seen


@LANES
@pytest.mark.parametrize("fault", [whole, *FAULTS.values()], ids=lambda fault: fault.__name__)
def test_beats_and_events(fault: Any, lanes: int) -> None:
    random = np.random.default_rng(lanes)
    for width in (32, 33):
        bad = fault(framed(image(width)), width, random)
        beats = [
            beat
            for part in (framed(image(width, 1)), bad, framed(image(width, 2)))
            for beat in packed(part, lanes)
        ]
        compare(build(lanes), width, beats, width)


def last_beat(change: Callable[[list[int | None]], list[int | None]], row: int) -> Any:
    def edit(beats: Beats, per_row: int) -> Beats:
        place = row * per_row + per_row - 1
        pixels, sof, eol = beats[place]
        return [*beats[:place], (tuple(change(list(pixels))), sof, eol), *beats[place + 1 :]]

    return edit


@LANES
@pytest.mark.parametrize("row", [0, 7, HEIGHT - 1])
def test_lines_that_differ_by_less_than_a_beat(lanes: int, row: int) -> None:
    """A pixel too few cuts the frame, one too many is dropped, and both are said."""
    p, width = build(lanes), 32 + lanes // 2
    good = packed(framed(image(width)), lanes)
    per_row, left = -(-width // lanes), lanes // 2

    short = last_beat(lambda pixels: [*pixels[: left - 1], *[None] * (lanes - left + 1)], row)
    long = last_beat(lambda pixels: [*pixels[:left], 5, *pixels[left + 1 :]], row)
    assert compare(p, width, [*short(good, per_row), *good], 1)["eol_early"] == 1
    assert compare(p, width, [*long(good, per_row), *good], 2) == {"eol_late": 1}
    # where lines are counted, more is nobody's concern, but what is lacking is lacking
    assert compare(p, width, [*long(good, per_row), *good], 3, ignore_eol=True) == {}
    assert compare(p, width, [*short(good, per_row), *good], 4, ignore_eol=True)["eol_early"] == 1


@LANES
def test_a_beat_in_the_middle_that_is_not_full(lanes: int) -> None:
    p, width = build(lanes), 33
    good = packed(framed(image(width)), lanes)
    per_row = -(-width // lanes)
    for place in (0, 1, per_row, 3 * per_row + 2, len(good) - 2):
        for lane in {0, 1, lanes - 1}:
            pixels, sof, eol = good[place]
            holed = tuple(None if k == lane else pixel for k, pixel in enumerate(pixels))
            beats = [*good[:place], (holed, sof, eol), *good[place + 1 :], *good]
            seen = compare(p, width, beats, lane)
            assert seen["eol_early"] == 1 and seen["sof_early"] == 0


@LANES
def test_an_end_of_line_with_a_frames_first_beat(lanes: int) -> None:
    p, width = build(lanes), 33
    good = packed(framed(image(width)), lanes)
    pixels, sof, _ = good[0]
    beats = [*good[:9], (pixels, sof, True), *good[1:], *good]
    assert compare(p, width, beats, 1)["eol_early"] == 1
    assert compare(p, width, beats, 2, ignore_eol=True) == {"sof_early": 1}


@LANES
def test_framing_at_random(lanes: int) -> None:
    random: Random = np.random.default_rng(17 * lanes)
    faults = list(FAULTS.values())
    happened: Counter[str] = Counter()
    for number in range(6):
        width = int(random.integers(build(lanes).min_width, 46))
        beats: Beats = []
        for _ in range(6):
            fault = faults[int(random.integers(len(faults)))]
            part = packed(fault(framed(image(width, number)), width, random), lanes)
            beats += hollow(part, random, 3) if random.random() < 0.5 else part
        happened += compare(build(lanes), width, beats, number)
    assert len(happened) == len(GUARD_EVENTS) - ("sof_missing" not in happened), happened


def test_pixels_that_share_a_byte_with_a_lines_last_are_not_looked_at() -> None:
    """With four bits per pixel an even number of pixels comes, whatever the width."""
    p, width = build(4, pixel_bits=4), 33
    small = image(width) & 15
    good = packed(framed(small), 4)
    per_row = -(-width // 4)
    twice = [
        ((*pixels[:1], 3, *pixels[2:]), sof, eol) if k % per_row == per_row - 1 else (pixels, sof, eol)
        for k, (pixels, sof, eol) in enumerate(good)
    ]
    run = Run(FrameGuard(p), width, twice, 1)
    assert not run.seen and [len(frame) for frame in run.frames] == [len(good)]
    thrice = [((*pixels[:2], 3, *pixels[3:]), sof, eol) for pixels, sof, eol in twice]
    assert Run(FrameGuard(p), width, thrice, 1).seen == {"eol_late": HEIGHT}
