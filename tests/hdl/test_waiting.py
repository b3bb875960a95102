# amaranth: UnusedElaboratable=no
"""Which images make the input wait, from responses to records: no photograph, and dense noise."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from golden import Settings
from hdl.build import PIXELS_PER_CLOCK, Build
from tests.support.behind_responses import run
from tests.support.builds import each
from tests.support.detectors import everything
from tests.support.photographs import PHOTOGRAPHS, photograph

PAGE = Path(__file__).parents[2] / "docs/explanation/hardware.md"
BUILDS = {
    f"{profile}, P={lanes}": Build.profile(
        profile, buffering="lean", max_width=640, max_height=672, pixels_per_clock=lanes
    )
    for profile in ("robust", "paper")
    for lanes in PIXELS_PER_CLOCK[1:]
}
# those whose blocks are used most: by peaks of a cell image, and by corners in grass
builds = each("build", BUILDS, quick=("robust, P=8",))


def waits(build: Build, image: NDArray[np.uint8], settings: Settings) -> float:
    """Clocks in which the input waits, by beats, in a frame that follows its like.

    Between frames it may wait for thresholds here: rows without responses take that time.
    """
    clocks = run(build, [(image, settings)] * 2).input_clocks["samples"]
    beats = len(clocks) // 2
    return float((clocks[-1] - clocks[beats] + 1) / beats - 1)


@each("name", {name: name for name in PHOTOGRAPHS}, quick=("grass", "cell"))
@builds
def test_no_photograph_waits(build: Build, name: str) -> None:
    for settings in (Settings.default(build), everything(build)):
        assert waits(build, photograph(name), settings) == 0


@pytest.mark.parametrize("grey", [False, True], ids=["black-and-white", "grey"])
@builds
def test_noise_waits_as_the_page_says(build: Build, grey: bool) -> None:
    """Only where windows of nine columns are read, and from 4 pixels per clock on."""
    rng = np.random.default_rng(0)
    coins = (rng.random((512, 512)) < 0.5).astype(np.uint8) * 255
    noise = rng.integers(0, 256, (512, 512), dtype=np.uint8) if grey else coins
    waiting = waits(build, noise, everything(build))
    if not build.sums_halves or build.pixels_per_clock == 2:
        assert waiting == 0
        return
    row = f"| {'grey' if grey else 'black-and-white'} noise, `paper` | 1.00 | 1.00 |"
    (told,) = (line for line in PAGE.read_text("utf-8").splitlines() if line.startswith(row))
    column = PIXELS_PER_CLOCK.index(build.pixels_per_clock) + 1
    assert told.split("|")[1:-1][column].strip() == f"{1 + waiting:.2f}"
