"""Frame guard: pixels that pass, events, and no transfer while a frame is cut."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest

from golden import Settings
from golden.video import Event, VideoModel, VideoSettings, framed
from hdl.build import Build
from hdl.edges.frame_guard import GUARD_EVENTS, FrameGuard
from tests.hdl.edges.bench import counted, put, simulate
from tests.support.malformed import FAULTS, Beats, whole

PARAMETERS = Build.profile("paper", max_width=20, max_height=18)
WIDTH, HEIGHT = 17, 15
IMAGE = np.arange(WIDTH * HEIGHT, dtype=np.uint8).reshape(HEIGHT, WIDTH)


class Run:
    """A guard that is fed, and what came of it."""

    def __init__(
        self, beats: Beats, *, resume_after: int = 3, enable: bool = True, ignore_eol: bool = False
    ) -> None:
        self.pixels: list[tuple[int, int, int]] = []
        self.seen: Counter[str] = Counter()
        self.cuts = self.done = 0
        self._beats, self._resume_after = beats, resume_after
        self._dut = dut = FrameGuard(PARAMETERS)
        self._fed = False

        async def feed(context: Any) -> None:
            context.set(dut.width, WIDTH)
            context.set(dut.height, HEIGHT)
            context.set(dut.enable, enable)
            context.set(dut.ignore_eol, ignore_eol)
            context.set(dut.o.ready, 1)
            for pixel, sof, eol in beats:
                await put(context, dut.i, {"pixel": pixel, "sof": sof, "eol": eol})
            await context.tick().repeat(4)
            self._fed = True

        simulate(dut, feed, self._watch)

    async def _watch(self, context: Any) -> None:
        dut, waited = self._dut, 0
        while not self._fed:
            counted(context, dut.events, self.seen)
            self.done += context.get(dut.done)
            if context.get(dut.o.valid):
                payload = context.get(dut.o.payload)
                self.pixels.append((payload.pixel, payload.sof, payload.eol))
            cut = context.get(dut.cut)
            if cut:
                assert not context.get(dut.i.ready) and not context.get(dut.active)
                waited += 1
            context.set(dut.resume, int(waited == self._resume_after))
            if waited == self._resume_after:
                self.cuts, waited = self.cuts + 1, 0
            await context.tick()

    @property
    def events(self) -> Event:
        names = {str(event.name).lower(): event for event in GUARD_EVENTS}
        return Event(sum(names[name] for name in self.seen))


def expected(beats: Beats, **changes: Any) -> tuple[list[int], VideoModel]:
    """Pixels that belong to frames, and the model that says so."""
    model = VideoModel(PARAMETERS)
    video = VideoSettings(WIDTH, HEIGHT, Settings(), **changes)
    packets = model.feed(beats, video)
    pixels = [int(pixel) for packet in packets for pixel in packet.pixels.ravel()]
    return pixels + model._pixels * model.active, model


ONLY_GUARD = Event(sum(GUARD_EVENTS))


@pytest.mark.parametrize("fault", [whole, *FAULTS.values()], ids=lambda fault: fault.__name__)
def test_pixels_and_events(fault: Any) -> None:
    random = np.random.default_rng(7)
    for _ in range(3):
        bad = fault(framed(IMAGE), WIDTH, random)
        beats = [*framed(255 - IMAGE), *bad, *framed(IMAGE // 2)]
        run = Run(beats)
        pixels, model = expected(beats)
        assert [pixel for pixel, _, _ in run.pixels] == pixels
        assert run.events == model.events & ONLY_GUARD
        assert bool(run.cuts) == bool(model.events & Event.FRAME_CUT)


@pytest.mark.parametrize("ignore_eol", [False, True])
def test_an_end_of_line_with_a_frames_first_pixel(ignore_eol: bool) -> None:
    beats = [*framed(IMAGE)[:60], (3, True, True), *framed(IMAGE)[1:], *framed(IMAGE)]
    run = Run(beats, ignore_eol=ignore_eol)
    pixels, model = expected(beats, ignore_eol=ignore_eol)
    assert [pixel for pixel, _, _ in run.pixels] == pixels
    assert run.events == model.events & ONLY_GUARD and run.cuts == (1 if ignore_eol else 2)


def test_frames_come_out_marked_as_they_should_be() -> None:
    beats = [(pixel, sof, False) for pixel, sof, _ in framed(IMAGE)] * 2
    run = Run(beats, ignore_eol=True)
    assert run.pixels == [(p, int(s), int(e)) for p, s, e in framed(IMAGE)] * 2
    assert run.done == 2 and not run.seen


def test_disabled_it_takes_and_drops_everything() -> None:
    run = Run(framed(IMAGE) + [(0, False, False)] * 400, enable=False)
    assert run.pixels == [] and not run.seen


def test_a_cut_waits_for_its_answer() -> None:
    beats = framed(IMAGE)[:50] + framed(IMAGE)
    for wait in (1, 2, 20):
        run = Run(beats, resume_after=wait)
        assert run.cuts == 1 and run.seen == {"sof_early": 1} and len(run.pixels) == 50 + IMAGE.size


def test_restart_takes_nothing_more_until_it_is_resumed() -> None:
    dut = FrameGuard(PARAMETERS)

    async def bench(context: Any) -> None:
        context.set(dut.width, WIDTH)
        context.set(dut.height, HEIGHT)
        context.set(dut.enable, 1)
        context.set(dut.o.ready, 1)
        for pixel, sof, eol in framed(IMAGE)[:40]:
            await put(context, dut.i, {"pixel": pixel, "sof": sof, "eol": eol})
        context.set(dut.restart, 1)
        context.set(dut.i.valid, 1)
        assert not context.get(dut.i.ready)
        await context.tick()
        context.set(dut.restart, 0)
        for _ in range(5):
            assert context.get(dut.cut) and not context.get(dut.i.ready)
            assert not context.get(dut.active) and not context.get(dut.o.valid)
            await context.tick()
        context.set(dut.resume, 1)
        await context.tick()
        context.set(dut.resume, 0)
        assert context.get(dut.i.ready) and not context.get(dut.cut)

    simulate(dut, bench)


def test_a_frame_keeps_its_size() -> None:
    dut = FrameGuard(PARAMETERS)

    async def bench(context: Any) -> None:
        context.set(dut.width, WIDTH)
        context.set(dut.height, HEIGHT)
        context.set(dut.enable, 1)
        context.set(dut.o.ready, 1)
        await context.tick()
        for number, (pixel, sof, eol) in enumerate(framed(IMAGE)):
            await put(context, dut.i, {"pixel": pixel, "sof": sof, "eol": eol})
            context.set(dut.width, 20)
            context.set(dut.height, 18)
            assert context.get(dut.frame_width) == WIDTH and context.get(dut.frame_height) == HEIGHT
            assert context.get(dut.active) == (number < IMAGE.size - 1)
        await put(context, dut.i, {"pixel": 0, "sof": 1, "eol": 0})
        assert context.get(dut.frame_width) == 20 and context.get(dut.frame_height) == 18

    simulate(dut, bench)
