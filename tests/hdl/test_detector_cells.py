# amaranth: UnusedElaboratable=no
"""The whole detector with cells: on photographs, from frame to frame, and at its pace."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden import Settings, StreamModel, decode
from hdl.build import Build
from sim.stimulus import Stalls
from tests.support.builds import each
from tests.support.detectors import MIXTURES, noise, run, run_with_reset
from tests.support.filters import lenient
from tests.support.photographs import PHOTOGRAPHS, photograph

ROBUST = Build.profile("robust", max_width=640, max_height=672, max_per_cell=8)
CELLS = {name: parameters for name, parameters in MIXTURES.items() if parameters.max_per_cell}


def settings_of(parameters: Build, width: int, height: int, most: int, **changes: Any) -> Settings:
    """A small T1, so that cells have to choose."""
    chosen = {"cell_width": width, "cell_height": height, "per_cell": most}
    return Settings.default(parameters, **{"sigma1": 0.002, **chosen, **changes})


@each("name", {name: name for name in PHOTOGRAPHS}, quick=("camera", "brick"))
def test_photographs(name: str) -> None:
    """No clock is lost, whatever the cells; a frame without cells has all its corners."""
    image = photograph(name)
    plain = settings_of(ROBUST, 64, 64, 0)
    each_frame = [
        settings_of(ROBUST, 64, 64, 4),
        settings_of(ROBUST, 32, 48, 8),
        plain,
        settings_of(ROBUST, 80, 60, 1),
        settings_of(ROBUST, 8, 8, 2),
    ]
    result = run(ROBUST, [(image, each) for each in each_frame])
    assert [frame.clocks for frame in result.frames] == [image.size] * 5
    counts = [len(frame.records) - 1 for frame in result.frames]
    assert counts[2] > 2 * counts[0] > 0 and counts[4] > counts[1] > counts[3] > 0


@pytest.mark.parametrize("parameters", CELLS.values(), ids=CELLS)
@pytest.mark.parametrize(
    "stalls", [Stalls(0.2, 0.3, 1), Stalls(outputs=0.98, seed=2)], ids=["both", "clogged"]
)
def test_stalls_lose_nothing(parameters: Build, stalls: Stalls) -> None:
    """Frames of all sizes back to back, so that rows of cells and ends of frames meet stalls."""
    least = parameters.min_cell_width
    sizes = [(64, 64), (19, 19), (19, 64), (64, 19), (40, 60), (64, 64)]
    frames = []
    for number, size in enumerate(sizes):
        width, height = least + 5 * number, 8 + 7 * (number % 3)
        some = settings_of(parameters, width, height, number % (parameters.max_per_cell + 1))
        some = replace(some, sigma2=lenient(parameters), report_rejected=bool(number % 2))
        frames.append((noise(*size, number, parameters), some))
    run(parameters, frames, stalls)


@given(st.data())
@settings(max_examples=25)
def test_limits_of_cells_and_of_frames(data: st.DataObject) -> None:
    """A limit after the cells, a target before them, changed from frame to frame."""
    parameters = MIXTURES["gradient step with budget, suppression"]
    frames = []
    for seed in range(4):
        most, limit, target = (data.draw(st.integers(0, top)) for top in (5, 12, 20))
        some = settings_of(parameters, 16, 16, most, max_corners=limit, target_corners=target)
        frames.append((noise(50, 60, seed), some))
    result = run(parameters, frames)
    for frame, (_, some) in zip(result.frames, frames, strict=True):
        assert not some.max_corners or decode(frame.records).accepted.sum() <= some.max_corners


def test_the_densest_corners() -> None:
    """Where corners come faster than they are refined, cells add a clock a row of them at most."""
    y, x = np.mgrid[:64, :512]
    dots = ((x % 5 == 0) & (y % 5 == 0)) * np.random.default_rng(4).integers(150, 256, x.shape)
    image = dots.astype(np.uint8)
    alone, cells = (settings_of(ROBUST, 8, 8, most, sigma1=0, sigma2=0, floor=1) for most in (0, 8))
    clocks = [frame.clocks for frame in run(ROBUST, [(image, alone)] * 2 + [(image, cells)] * 2).frames]
    assert clocks[1] > 1.15 * image.size and 0 <= clocks[3] - clocks[1] <= 64 // 8


@given(cut=st.integers(1, 40 * 40 - 1), seed=st.integers(0, 99))
@settings(max_examples=25)
def test_a_reset_leaves_no_corner(cut: int, seed: int) -> None:
    """Rows of cells that were not complete are gone, wherever the frame was cut."""
    parameters = MIXTURES["4-bit pixels"]
    some = settings_of(parameters, 8, 9, 1, sigma2=lenient(parameters))
    broken, *frames = [(noise(40, 40, seed + k, parameters), some) for k in range(3)]
    before = run_with_reset(parameters, broken, frames, cut, seed)
    assert np.array_equal(before, StreamModel(parameters).cut(*broken, pixels=cut)[: len(before)])
