# amaranth: UnusedElaboratable=no
"""Pins of the cores with several pixels per clock: each pixel comes to the detector in its lane."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In

from hdl.build import Build
from hdl.detector import Detector
from hdl.edges.avalon import AvalonCore
from hdl.edges.axi import AxiCore
from hdl.sample import pixels_shape
from tests.hdl.edges.bench import simulate

HEIGHT = 15
LANES = pytest.mark.parametrize(("lanes", "bits"), [(2, 8), (4, 10), (8, 8)])


class Taker(wiring.Component):
    """In the place of the detector: it takes all that comes, and finds nothing."""

    def __init__(self, p: Build) -> None:
        members = dict(Detector(p).signature.members.items())
        super().__init__({**members, "i": In(stream.Signature(pixels_shape(p)))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.d.comb += self.i.ready.eq(1)
        return m


def build(lanes: int, bits: int, **changes: Any) -> Build:
    return Build.profile(
        *("paper",),
        pixels_per_clock=lanes,
        pixel_bits=bits,
        max_width=32 + lanes // 2,
        max_height=HEIGHT,
        autostart=True,
        **changes,
    )


def rows(p: Build) -> np.ndarray:
    """A frame of the largest size, whose last beats are half full."""
    shape = (p.max_height, p.max_width)
    return np.random.default_rng(p.pixels_per_clock).integers(1, 1 << p.pixel_bits, shape)


def beats(p: Build, image: np.ndarray) -> Iterator[tuple[list[int], bool, bool]]:
    """The pixels of each beat, and whether it is the first of the frame, and the last of a row."""
    for y, row in enumerate(image.tolist()):
        for x in range(0, p.max_width, p.pixels_per_clock):
            yield row[x : x + p.pixels_per_clock], x == y == 0, x + p.pixels_per_clock >= p.max_width


def word(pixels: list[int], bits: int) -> int:
    """The first pixel in the lowest bits."""
    return sum(pixel << k * bits for k, pixel in enumerate(pixels))


async def offer(context: Any, ready: Any, taken: list[list[int]], detector: Taker) -> None:
    """Until what is offered is taken; adds what comes to the detector meanwhile."""
    while True:
        if context.get(detector.i.valid):
            taken.append(list(context.get(detector.i.payload)))
        moves = context.get(ready)
        await context.tick()
        if moves:
            return


def same(p: Build, image: np.ndarray, taken: list[list[int]]) -> bool:
    """What came is the image; lanes beyond its width may hold anything."""
    expected = [pixels for pixels, _, _ in beats(p, image)]
    got = [pixels[: len(given)] for pixels, given in zip(taken, expected, strict=True)]
    return got == expected


@LANES
def test_axi(lanes: int, bits: int) -> None:
    """And the rows that no corner can be in come out as they went in."""
    p = build(lanes, bits, video_out=True)
    detector = Taker(p)
    dut, image, taken = AxiCore(p, detector=detector), rows(p), list[list[int]]()
    shown: list[tuple[int, int, int, int]] = []
    size = -(-lanes * bits // 8)

    async def feed(context: Any) -> None:
        await context.tick().repeat(2)
        context.set(dut.s_axis_tvalid, 1)
        for pixels, sof, eol in beats(p, image):
            kept = -(-len(pixels) * bits // 8)
            context.set(dut.s_axis_tdata, word(pixels, bits))
            context.set(dut.s_axis_tkeep, (1 << kept) - 1)
            context.set(dut.s_axis_tuser, int(sof))
            context.set(dut.s_axis_tlast, int(eol))
            await offer(context, dut.s_axis_tready, taken, detector)
        context.set(dut.s_axis_tvalid, 0)
        for _ in range(8):
            await offer(context, dut.core.records.ready | 1, taken, detector)

    async def watch(context: Any) -> None:
        context.set(dut.m_axis_video_tready, 1)
        pins = (dut.m_axis_video_tdata, dut.m_axis_video_tkeep, dut.m_axis_video_tuser)
        while len(shown) < p.algorithm.margin * p.beats:
            if context.get(dut.m_axis_video_tvalid):
                shown.append((*map(context.get, pins), context.get(dut.m_axis_video_tlast)))
            await context.tick()

    simulate(dut, feed, watch)
    assert len(dut.s_axis_tkeep) == size and len(dut.s_axis_tdata) == 8 * size
    assert same(p, image, taken)
    for (pixels, sof, eol), (data, keep, user, last) in zip(beats(p, image), shown, strict=False):
        kept = len(pixels) * bits
        assert data & (1 << kept) - 1 == word(pixels, bits)
        assert (keep, user, last) == ((1 << -(-kept // 8)) - 1, int(sof), int(eol))


@LANES
def test_avalon(lanes: int, bits: int) -> None:
    """The first pixel is in the highest bits, and a last beat that lacks one cuts its frame."""
    p = build(lanes, bits)
    detector = Taker(p)
    dut, image, taken = AvalonCore(p, detector=detector), rows(p), list[list[int]]()
    events: list[str] = []

    async def packet(context: Any, lacking: int) -> None:
        given = [*beats(p, image)]
        for k, pixels in enumerate([[0] * lanes, *(pixels for pixels, _, _ in given)]):
            places = [*pixels, *[0] * (lanes - len(pixels))]
            context.set(dut.asi_video_data, word(places[::-1], bits))
            context.set(dut.asi_video_startofpacket, int(k == 0))
            context.set(dut.asi_video_endofpacket, int(k == len(given)))
            # elsewhere it means nothing
            empty = lanes - len(pixels) + lacking if k == len(given) else lanes - 1
            context.set(dut.asi_video_empty, empty)
            await offer(context, dut.asi_video_ready, taken, detector)

    async def feed(context: Any) -> None:
        await context.tick().repeat(2)
        context.set(dut.asi_video_valid, 1)
        await packet(context, 0)
        await packet(context, 1 if lanes > 2 else 0)
        context.set(dut.asi_video_valid, 0)
        for _ in range(8):
            await offer(context, dut.core.records.ready | 1, taken, detector)

    async def watch(context: Any) -> None:
        found = dut.core.video_detector.events
        for _ in range(2 * (p.beats * HEIGHT + 1) + 12):
            events.extend(name for name, _ in found.shape() if context.get(found[name]))
            await context.tick()

    simulate(dut, feed, watch)
    whole = p.beats * HEIGHT
    assert same(p, image, taken[:whole])
    assert len(taken) == 2 * whole - (lanes > 2)
    assert events == ["eol_early"] * (lanes > 2)
