# amaranth: UnusedElaboratable=no
"""Corner detection: strict maxima above T1, both tie rules, and the response that goes along."""

from __future__ import annotations

import numpy as np
import pytest

from golden.algorithm import Ties
from golden.corner_detection import corner_detection
from hdl.build import Build
from hdl.corner_detection import CornerDetection
from sim.engine import EngineName, SimulationHang
from sim.stimulus import Capture, Stalls, Stimulus
from tests.support.blocks import (
    ENGINES,
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
FULL = Build.profile("paper").response_max


def check(
    ties: Ties,
    frames: list[Array],
    t1: list[int],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    pixel_bits: int = 8,
) -> Capture:
    """Frames of responses, three rows and columns or more."""
    expected = raster([corner_detection(f, limit, ties) for f, limit in zip(frames, t1, strict=True)])
    responses = raster([frame[1:-1, 1:-1] for frame in frames])
    expected["data"] = {"corner": expected["data"], "response": responses["data"]}
    return check_block(
        (CornerDetection, Build.profile("paper", ties=ties, pixel_bits=pixel_bits)),
        {"i": columns(frames, 3), "t1": np.array(t1)},
        {"o": expected},
        name,
        stalls,
        window=3,
        held={"t1": "i"},
    )


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("ties", TIES)
def test_noise(ties: Ties, name: EngineName, stalls: Stalls) -> None:
    """Few values give ties in plenty; T1 cuts through them and changes from frame to frame."""
    sizes = [(20, 30), (3, 3), (12, 9), (3, 40), (9, 4)]
    sizes = sizes if name == "compiled" else [(3, 3), (5, 13), (4, 5)]
    frames, t1 = [], []
    for seed, largest in enumerate((FULL, 2, 5, 1)):
        frames += noise(sizes, largest, seed)
        t1 += [0, largest // 2, 0, largest - 1, largest][: len(sizes)]
    check(ties, frames, t1, name, stalls)


@pytest.mark.parametrize("ties", TIES)
@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
def test_extremes(ties: Ties, pixel_bits: int) -> None:
    full = Build.profile("paper", pixel_bits=pixel_bits).response_max
    frames = extremes((10, 20), full) + extremes((7, 11), full, full - 1)
    t1 = [(0, full - 1, full)[k % 3] for k in range(len(frames))]
    check(ties, frames, t1, pixel_bits=pixel_bits)


@pytest.mark.parametrize("ties", TIES)
@pytest.mark.parametrize("name", ENGINES)
def test_each_neighbour(ties: Ties, name: EngineName) -> None:
    """A lone peak of 10 with a neighbour of 9, 10 or 11 in each place; T1 is 9 and 10."""
    frames, t1, expected = [], [], []
    for place in (0, 1, 2, 3, 5, 6, 7, 8):
        for neighbour, limit in ((9, 9), (10, 9), (11, 9), (9, 10)):
            patch = np.zeros(9, np.int64)
            patch[4], patch[place] = 10, neighbour
            frames.append(patch.reshape(3, 3))
            t1.append(limit)
            later_tie = neighbour == 10 and place > 4 and ties == "first"
            expected.append(limit == 9 and (neighbour == 9 or later_tie))
    capture = check(ties, frames, t1, name)
    assert (capture.outputs["o"] & np.uint64(1)).tolist() == expected


@pytest.mark.parametrize("ties", TIES)
def test_every_pattern_of_ties(ties: Ties) -> None:
    """The centre against neighbours one less, equal or one more, at both ends of the range."""
    steps = np.array(np.unravel_index(np.arange(3**8), (3,) * 8)).T - 1
    for centre in (1, FULL - 1):
        patches = np.insert(centre + steps, 4, centre, axis=1).reshape(-1, 3, 3)
        check(ties, list(patches), [centre - 1] * len(patches))


def test_a_frame_waits_for_its_threshold() -> None:
    """Without T1 no column is taken."""
    block = CornerDetection, Build.profile("paper")
    given = packed(block, {"i": columns(noise([(4, 5), (3, 6)], FULL), 3), "t1": np.array([7])})
    with pytest.raises(SimulationHang, match=r"i 10 of 16 in, t1 1 of 1 in, .*o 6 out"):
        engine("compiled", *block).run(Stimulus(given), max_clocks=200)


def test_latency() -> None:
    assert CornerDetection.latency == 3
