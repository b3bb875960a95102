# amaranth: UnusedElaboratable=no
"""Beats passed on with a bit for each corner, as many pixels per clock as there are."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.video import framed
from hdl.build import Build
from hdl.candidate_selection import PIXEL_COORDINATE_BITS, corner_flag_layout
from hdl.edges.frame_guard import video_layout
from hdl.edges.lane_overlay import LaneOverlay
from hdl.edges.overlay import overlay_layout
from sim import Stalls, Stimulus
from tests.support.beats import in_words
from tests.support.blocks import engine
from tests.support.builds import each
from tests.support.malformed import Random, packed

LANES = each("lanes", {"2": 2, "4": 4, "8": 8}, quick=("4",))
STALLS = pytest.mark.parametrize(
    "stalls", [Stalls(), Stalls(0.3, 0.3, 1), Stalls(0, 0.8, 2), Stalls(0.8, 0, 3)], ids=str
)


def build(lanes: int) -> Build:
    return Build.profile("paper", pixels_per_clock=lanes, max_width=45, max_height=24, video_out=True)


class PlainOverlay(wiring.Component):
    """``LaneOverlay`` with its streams only."""

    def __init__(self, p: Build) -> None:
        self._dut = LaneOverlay(p)
        super().__init__(
            {
                "i": In(stream.Signature(video_layout(p))),
                "corner_flags": In(stream.Signature(corner_flag_layout(p))),
                "o": Out(stream.Signature(overlay_layout(p))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._dut
        wiring.connect(m, wiring.flipped(self.i), dut.i)
        wiring.connect(m, wiring.flipped(self.corner_flags), dut.corner_flags)
        wiring.connect(m, dut.o, wiring.flipped(self.o))
        return m


def corners_of(random: Random, height: int, width: int, margin: int, share: float) -> np.ndarray:
    """Corners where there can be some; no two of them touch."""
    corners = np.zeros((height, width), bool)
    for y, x in zip(*np.nonzero(random.random((height, width)) < share), strict=True):
        inside = margin <= y < height - margin and margin <= x < width - margin
        corners[y, x] = inside and not corners[y - 1 : y + 1, x - 1 : x + 2].any()
    return corners


def flags_of(corners: np.ndarray, margin: int) -> list[int]:
    """The flags that the detector gives: each corner, and each end of a row of windows."""
    height, words = len(corners), []
    for y in range(margin, height - margin):
        words += [int(x) | 1 << PIXEL_COORDINATE_BITS for x in np.flatnonzero(corners[y])]
        words.append((y == height - margin - 1) << (PIXEL_COORDINATE_BITS + 1))
    return words


def together(*fields: tuple[int, int]) -> int:
    """A word of fields, ``(value, bits)`` each, the first one lowest."""
    word = place = 0
    for value, bits in fields:
        word |= value << place
        place += bits
    return word


@STALLS
@LANES
def test_beats_and_corners(lanes: int, stalls: Stalls) -> None:
    p, random = build(lanes), np.random.default_rng(lanes)
    margin, lane_bits = p.algorithm.margin, lanes.bit_length() - 1
    sent: list[int] = []
    flags: list[int] = []
    expected: list[int] = []
    sizes = [(45, 24), (p.min_width, p.algorithm.support), (32, 16), (45, 15), (33, 24)]
    for number, (width, height) in enumerate(sizes):
        image = random.integers(0, 256, (height, width), np.uint8)
        corners = corners_of(random, height, width, margin, (0.5, 0.2, 0.05, 0, 0.5)[number])
        flags += flags_of(corners, margin)
        shown = packed(
            [(int(c), s, e) for c, (_, s, e) in zip(corners.ravel(), framed(image), strict=True)], lanes
        )
        for (pixels, sof, eol), (marked, _, _) in zip(packed(framed(image), lanes), shown, strict=True):
            # what is not there goes through as it came
            data = together(*((pixel or 0, 8) for pixel in pixels))
            last = sum(pixel is not None for pixel in pixels) - 1
            marks = together(*((mark or 0, 1) for mark in marked))
            sent.append(together((data, 8 * lanes), (last, lane_bits), (sof, 1), (eol, 1)))
            expected.append(
                together((data, 8 * lanes), (marks, lanes), (last, lane_bits), (sof, 1), (eol, 1))
            )
    runner = engine("amaranth", PlainOverlay, p)
    given = {"i": in_words(sent), "corner_flags": np.array(flags, np.uint64)}
    capture = runner.run(Stimulus(given, [], stalls), quiet=100)
    assert np.array_equal(capture.outputs["o"], in_words(expected))
