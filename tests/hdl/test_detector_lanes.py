"""Whole detectors with several pixels per clock: the records are golden's."""

from __future__ import annotations

import pytest

from hdl.build import Build
from sim.stimulus import Stalls
from tests.support.detectors import SMALL, both_kinds, noise, run


@pytest.mark.parametrize("stalls", [None, Stalls(0.3, 0.4, 3)], ids=["unstalled", "both-stall"])
@pytest.mark.parametrize(("profile", "lanes"), [("robust", 4), ("paper", 2)])
def test_noise(profile: str, lanes: int, stalls: Stalls | None) -> None:
    """Frames back to back, whose last beats hold different numbers of columns."""
    build = Build.profile(profile, **SMALL, buffering="lean", pixels_per_clock=lanes)
    sizes = [(40, 61), (30, 64), (build.algorithm.support, build.min_width), (33, 47)]
    frames = [(noise(*size, k, build), both_kinds(build)) for k, size in enumerate(sizes)]
    run(build, frames, stalls)
