# amaranth: UnusedElaboratable=no
"""Centre rows: the middle rows of a window, as late as its other columns, without outer columns."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from hdl.build import Build
from hdl.centre_rows import CentreRows
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

FULL = Build.profile("paper").response_max


def check(
    frames: list[Array], name: EngineName = "compiled", stalls: Stalls = NO_STALLS, **changes: Any
) -> Capture:
    parameters = Build.profile("paper", **changes)
    size = parameters.algorithm.window_size
    outer = size // 2 - 1
    inner = [frame[outer:-outer, outer:-outer] for frame in frames]
    given, expected = {"i": columns(frames, size)}, {"o": columns(inner, 3)}
    # as many columns past the one that comes out
    return check_block((CentreRows, parameters), given, expected, name, stalls, window=size - 2)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_noise(name: EngineName, stalls: Stalls) -> None:
    sizes = [(20, 30), (9, 9), (12, 7), (9, 40), (10, 8), (11, 17)]
    check(noise(sizes if name == "compiled" else [(9, 9), (10, 12), (11, 7), (9, 10)], FULL), name, stalls)


@pytest.mark.parametrize("suppression", [2, 3])
def test_windows_without_texture_filter(suppression: int) -> None:
    """Five and seven rows."""
    frames = noise([(20, 30), (9, 9), (12, 8), (9, 40)], FULL)
    check(frames, stalls=Stalls(inputs=0.3, outputs=0.4, seed=13), texture="none", suppression=suppression)
    check(frames, texture="none", suppression=suppression)


@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
def test_extremes(pixel_bits: int) -> None:
    check(
        extremes((11, 20), Build.profile("paper", pixel_bits=pixel_bits).response_max), pixel_bits=pixel_bits
    )


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """Row r, column c of 10x9 is 10 r + c. Rows 3 to 5, and 4 to 6, of columns 3 to 5 remain."""
    frame = 10 * np.arange(10)[:, None] + np.arange(9)
    layout = CentreRows(Build.profile("paper")).o.payload.shape()
    seen = unpack(layout, check([frame], name).outputs["o"])
    assert seen["data"]["response"].tolist() == [
        [33, 43, 53],
        [34, 44, 54],
        [35, 45, 55],
        [43, 53, 63],
        [44, 54, 64],
        [45, 55, 65],
    ]
    assert (seen["eol"].tolist(), seen["eof"].tolist()) == ([0, 0, 1, 0, 0, 1], [0, 0, 0, 0, 0, 1])


def test_latency() -> None:
    assert CentreRows.latency == 2
