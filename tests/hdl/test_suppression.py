# amaranth: UnusedElaboratable=no
"""Suppression: maxima of every radius above T1, both tie rules, and their responses."""

from __future__ import annotations

import numpy as np
import pytest

from golden.algorithm import Ties
from golden.corner_detection import corner_detection
from golden.formats import WINDOW_SIZE
from golden.parameters import Parameters
from hdl.build import Build
from hdl.suppression import Suppression
from sim.engine import EngineName, SimulationHang
from sim.stimulus import Capture, Stalls, Stimulus
from tests.support.blocks import (
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    check_block,
    columns,
    engine,
    extremes,
    noise,
    packed,
    raster,
)

TIES: list[Ties] = ["strict", "first"]
RADII = [1, 2, 3, 4]
REACH = WINDOW_SIZE // 2
FULL = Build.profile("paper").response_max


def check(
    parameters: Parameters,
    frames: list[Array],
    t1: list[int],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
) -> Capture:
    """Frames of responses, nine rows and columns or more."""
    ties, radius = parameters.algorithm.ties, parameters.algorithm.suppression
    size = parameters.algorithm.window_size
    reach = size // 2

    def found(frame: Array, limit: int) -> Array:
        edge = reach - radius
        height, width = frame.shape
        return corner_detection(frame[edge : height - edge, edge : width - edge], limit, ties, radius)

    expected = raster([found(frame, limit) for frame, limit in zip(frames, t1, strict=True)])
    responses = raster([frame[reach:-reach, reach:-reach] for frame in frames])
    peaks = raster([found(frame, 0) for frame in frames])
    counted = {"peak": peaks["data"]} if parameters.budget else {}
    expected["data"] = {"corner": expected["data"], "response": responses["data"], **counted}
    return check_block(
        (Suppression, parameters),
        {"i": columns(frames, size), "t1": np.array(t1)},
        {"o": expected},
        name,
        stalls,
        window=size,
        held={"t1": "i"},
    )


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(inputs=0.3, outputs=0.4, seed=13)], ids=str)
@pytest.mark.parametrize("radius", RADII)
def test_windows_without_texture_filter(radius: int, stalls: Stalls) -> None:
    """They are no larger than what is suppressed."""
    parameters = Build.profile("paper", texture="none", suppression=radius, budget=True)
    assert parameters.algorithm.window_size == 2 * radius + 1
    check(parameters, noise([(20, 30), (9, 9), (12, 10)], 40), [20, 0, 39], stalls=stalls)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("ties", TIES)
def test_noise(ties: Ties, radius: int, name: EngineName, stalls: Stalls) -> None:
    """Few values give ties in plenty; T1 cuts through them and changes from frame to frame."""
    sizes = [(20, 30), (9, 9), (12, 10), (9, 40), (15, 11)]
    sizes = sizes if name == "compiled" else [(9, 9), (10, 13)]
    frames, t1 = [], []
    for seed, largest in enumerate((FULL, 2, 5, 40)):
        frames += noise(sizes, largest, seed)
        t1 += [0, largest // 2, 0, largest - 1, largest][: len(sizes)]
    check(Build.profile("paper", ties=ties, suppression=radius, budget=True), frames, t1, name, stalls)


@pytest.mark.parametrize("ties", TIES)
@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
def test_extremes(ties: Ties, radius: int, pixel_bits: int) -> None:
    parameters = Build.profile("paper", ties=ties, suppression=radius, pixel_bits=pixel_bits)
    full = parameters.response_max
    frames = extremes((10, 20), full) + extremes((11, 15), full, full - 1)
    t1 = [(0, full - 1, full)[k % 3] for k in range(len(frames))]
    check(parameters, frames, t1)


@pytest.mark.parametrize("ties", TIES)
@pytest.mark.parametrize("radius", RADII)
def test_each_neighbour(ties: Ties, radius: int) -> None:
    """A lone peak of 10 with one other response of 9, 10 or 11, anywhere in the 9x9 around it."""
    frames, t1, expected = [], [], []
    for place in range(WINDOW_SIZE**2):
        y, x = divmod(place, WINDOW_SIZE)
        if y == x == REACH:
            continue
        for neighbour in (9, 10, 11):
            frame = np.zeros((WINDOW_SIZE, WINDOW_SIZE), np.int64)
            frame[REACH, REACH], frame[y, x] = 10, neighbour
            frames.append(frame)
            t1.append(9)
            far = max(abs(y - REACH), abs(x - REACH)) > radius
            later_tie = neighbour == 10 and ties == "first" and place > WINDOW_SIZE**2 // 2
            expected.append(far or neighbour == 9 or later_tie)
    capture = check(Build.profile("paper", ties=ties, suppression=radius), frames, t1)
    assert (capture.outputs["o"] & np.uint64(1)).tolist() == expected


def test_a_frame_waits_for_its_threshold() -> None:
    """Without T1 no column is taken."""
    block = Suppression, Build.profile("paper", suppression=2)
    frames = noise([(10, 10), (9, 11)], FULL)
    given = packed(block, {"i": columns(frames, WINDOW_SIZE), "t1": np.array([7])})
    with pytest.raises(SimulationHang, match=r"i 20 of 31 in, t1 1 of 1 in, .*o 4 out"):
        engine("compiled", *block).run(Stimulus(given), max_clocks=200)
