# amaranth: UnusedElaboratable=no
"""Pixel filter: rows smoothed as the golden model has it, two columns shorter."""

from __future__ import annotations

import numpy as np
import pytest

from golden.pixel_filter import pixel_filter
from hdl.build import Build
from hdl.pixel_filter import PixelFilter
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    check_block,
    columns,
    extremes,
    noise,
    raster,
    unpack,
)


def check(
    frames: list[Array], name: EngineName = "compiled", stalls: Stalls = NO_STALLS, pixel_bits: int = 8
) -> Capture:
    smoothed = [pixel_filter(frame.astype(np.uint16), 1).astype(np.int64) for frame in frames]
    return check_block(
        (PixelFilter, Build.profile("paper", pixel_bits=pixel_bits)),
        {"i": columns(frames, 3)},
        {"o": raster(smoothed)},
        name,
        stalls,
        window=3,
    )


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_noise(name: EngineName, stalls: Stalls) -> None:
    sizes = [(20, 30), (3, 3), (9, 4), (3, 40), (10, 8), (11, 17)]
    check(noise(sizes if name == "compiled" else [(3, 3), (5, 12), (6, 4)], 255), name, stalls)


@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
def test_extremes(pixel_bits: int) -> None:
    check(extremes((7, 20), (1 << pixel_bits) - 1), pixel_bits=pixel_bits)


def test_every_remainder_is_rounded() -> None:
    """A pixel of 0 to 31 in the window's corner, weight 1, beside it, 2, and in the middle, 4."""
    frames = []
    for value in range(32):
        for place in ((0, 0), (0, 1), (1, 2), (1, 1)):
            frame = np.zeros((3, 3), np.int64)
            frame[place] = value
            frames.append(frame)
    check(frames)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """160 counts 4, 2 and 1 sixteenths; so does 24, a row above and a column to the right."""
    frame = np.zeros((5, 5), np.int64)
    frame[2, 2], frame[1, 3] = 160, 24
    layout = PixelFilter(Build.profile("paper")).o.payload.shape()
    seen = unpack(layout, check([frame], name).outputs["o"])
    assert seen["data"].tolist() == [10, 23, 16, 20, 42, 23, 10, 20, 10]
    assert seen["eol"].tolist() == [0, 0, 1] * 3 and seen["eof"].tolist() == [0] * 8 + [1]


@pytest.mark.parametrize(("lanes", "clocks"), [(1, 2), (2, 2), (8, 3)])
def test_latency(lanes: int, clocks: int) -> None:
    build = Build.profile("paper", pixels_per_clock=lanes)
    assert PixelFilter(build).latency == clocks
    assert PixelFilter(build, tags_first=True).latency == clocks - 1
