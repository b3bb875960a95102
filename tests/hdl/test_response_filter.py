# amaranth: UnusedElaboratable=no
"""Response filter: the middle rows of nine, smoothed, as late as the centre rows are."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from golden.response_filter import response_filter
from hdl.build import Build
from hdl.centre_rows import CentreRows
from hdl.response_filter import ResponseFilter
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
    unpack,
)

SIGNED = Build.profile("paper", gradient="signed", response_filter="binomial", fit="gradient")
FULL = SIGNED.response_max


def check(
    frames: list[Array],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    pixel_bits: int = 8,
    **changes: Any,
) -> Capture:
    parameters = SIGNED.changed(pixel_bits=pixel_bits, **changes)
    size = parameters.algorithm.window_size
    # the suppression sees 3x3 of what is smoothed
    edge = size // 2 - 2
    inner = [response_filter(frame) for frame in frames]
    inner = [frame[edge : len(frame) - edge, edge : frame.shape[1] - edge] for frame in inner]
    return check_block(
        (ResponseFilter, parameters),
        {"i": columns(frames, size)},
        {"o": columns(inner, 3)},
        name,
        stalls,
        # columns past the one that comes out
        window=size - 2,
    )


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_noise(name: EngineName, stalls: Stalls) -> None:
    sizes = [(20, 30), (9, 9), (12, 7), (9, 40), (10, 8), (11, 17)]
    frames = noise(sizes if name == "compiled" else [(9, 9), (10, 12), (11, 7), (9, 10)], FULL)
    check(frames, name, stalls)


def test_five_rows_without_texture_filter() -> None:
    frames = noise([(20, 30), (5, 5), (12, 7), (6, 40)], FULL)
    check(frames, texture="none", fit="nine")
    check(frames, stalls=Stalls(inputs=0.3, outputs=0.4, seed=13), texture="none", fit="nine")


@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
def test_extremes(pixel_bits: int) -> None:
    full = replace(SIGNED, pixel_bits=pixel_bits).response_max
    check(extremes((11, 20), full), pixel_bits=pixel_bits)


def test_every_remainder_is_rounded() -> None:
    """One response of 0 to 31 in the window's corner, weight 1, and in its middle, weight 4."""
    frames = []
    for value in range(32):
        for place in (3, 4):
            frame = np.zeros((9, 9), np.int64)
            frame[place, place] = value
            frames.append(frame)
    check(frames)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """160 counts 4, 2 and 1 sixteenths; so does 16, a row above and a column to the right."""
    frame = np.zeros((9, 9), np.int64)
    frame[4, 4], frame[3, 5] = 160, 16
    layout = ResponseFilter(SIGNED).o.payload.shape()
    seen = unpack(layout, check([frame], name).outputs["o"])
    assert seen["data"]["response"].tolist() == [[10, 20, 10], [22, 41, 20], [14, 22, 10]]


def test_latency() -> None:
    assert ResponseFilter.latency == CentreRows.latency == 2
