# amaranth: UnusedElaboratable=no
"""Squares by embedded multipliers in the whole detector: the same records, less block RAM."""

from __future__ import annotations

from typing import Any

import pytest
from amaranth.back import rtlil

from golden import Settings, StreamModel
from hdl.build import MAX_MULTIPLIERS, Build
from hdl.convolution import Convolution, square_pairs
from hdl.detector import Detector
from hdl.responses.shi_tomasi import PARTS, Response
from sim import Stalls, compare, make_engine, simulate_frames, summarize
from tests.support.photographs import photograph

SIZE = {"max_width": 80, "max_height": 48}


def multiplications(build: Build) -> int:
    blocks = (Convolution(build), Response(build))
    return sum(rtlil.convert(block, name="top").count("cell $mul ") for block in blocks)


def memory_bits(build: Build) -> int:
    return Convolution(build).memory_bits + Response(build).memory_bits


def most(build: Build) -> int:
    """Multipliers for all pairs of squares."""
    return 2 * (square_pairs(build) + len(PARTS) * build.pixels_per_clock)


@pytest.mark.parametrize(
    ("profile", "lanes", "multipliers"),
    [
        ("paper", 1, 18),
        pytest.param("robust", 4, MAX_MULTIPLIERS, marks=pytest.mark.verify),
    ],
)
def test_records_are_the_same(profile: str, lanes: int, multipliers: int) -> None:
    build = Build.profile(profile, **SIZE, pixels_per_clock=lanes, multipliers=multipliers)
    image = photograph("camera")[200:240, 150:227]
    settings = Settings(sigma1=0.01, report_rejected=True)
    frames = [(image, settings)] * 2
    model = StreamModel(build)
    expected = [model.process(*frame).records for frame in frames]
    assert len(expected[1]) > 5
    engine = make_engine("compiled", Detector(build))
    for stalls in (Stalls(), Stalls(inputs=0.3, outputs=0.4, seed=3)):
        result = simulate_frames(engine, frames, build, stalls=stalls)
        assert summarize(compare(result, expected)) == ""


@pytest.mark.parametrize("lanes", [1, 2])
@pytest.mark.parametrize("changes", [{}, {"gradient": "signed"}])
def test_each_two_take_the_place_of_a_table(lanes: int, changes: dict[str, Any]) -> None:
    build = Build.profile("paper", **SIZE, pixels_per_clock=lanes, **changes)
    before, all_of_them = memory_bits(build), most(build)
    for number in (0, 2, 2 * square_pairs(build), 2 * square_pairs(build) + 2, all_of_them):
        some = build.changed(multipliers=number)
        assert multiplications(some) == number
        bits = memory_bits(some)
        assert bits < before or number == 0
        before = bits
    # what is beyond is not used
    assert multiplications(build.changed(multipliers=all_of_them + 2)) == all_of_them
    assert memory_bits(build.changed(multipliers=MAX_MULTIPLIERS)) == before


def test_latencies_are_the_same() -> None:
    build = Build.profile("robust", pixels_per_clock=4)
    assert Detector(build).latency == Detector(build.changed(multipliers=MAX_MULTIPLIERS)).latency


def test_odd_numbers_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^multipliers is 3; allowed: even numbers, 0 to 1024$"):
        Build(multipliers=3)
