"""The committed page and figures: complete, from the generator, and of this hardware."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from statistics import median

import pytest

from cornerstream.compare import LONGEST
from evaluation.comparison import page as comparison
from evaluation.comparison.figures import AREA_FIELDS, clocks, structure
from evaluation.comparison.variants import SIZES, Variant, all_builds, builds
from evaluation.figures import Figures
from evaluation.report.compact import compact
from tests.support.builds import each

DOCS = Path(__file__).parents[3] / "docs" / "results"
QUICK = builds(SIZES[-1:])
SMALLEST = QUICK[0]


def committed() -> Figures:
    return json.loads((DOCS / comparison.FIGURES_NAME).read_text(encoding="utf-8"))


def test_committed_page_is_written_from_the_committed_figures() -> None:
    assert (DOCS / comparison.PAGE_NAME).read_text(encoding="utf-8") == comparison.page(committed())


def test_committed_figures_are_a_build_a_line() -> None:
    text = (DOCS / comparison.FIGURES_NAME).read_text(encoding="utf-8")
    assert text == compact(committed(), LONGEST)
    assert len(text.splitlines()) == len(committed()["builds"]) + 5


def test_committed_figures_are_complete() -> None:
    found = committed()["builds"]
    assert [{name: figure[name] for name in asdict(SMALLEST)} for figure in found] == list(
        map(asdict, all_builds())
    )
    for build, figure in zip(all_builds(), found, strict=True):
        counted = (*AREA_FIELDS, "blocks", "clocks_per_frame", "end_of_frame_clocks")
        assert all(figure[field] is not None for field in counted)
        assert sum(figure["blocks"].values()) == figure["le_packed"]
        if figure["fmax_by_seed"] is None:
            # the others have too many blocks of RAM for any ECP5
            assert not build.seeds or (build.profile, build.pixels_per_clock) == ("precise", 8)
        else:
            assert tuple(map(int, figure["fmax_by_seed"])) == build.seeds
            assert figure["fmax_mhz"] == median(figure["fmax_by_seed"].values())
        assert figure["le_lower"] <= figure["le_packed"] <= figure["le_upper"]


@pytest.mark.parametrize(
    ("buffering", "elements", "memory_bits", "mhz"),
    [("lean", 5000, 270_000, 150), ("banked", 6500, 803_104, 100)],
)
def test_committed_figures_reach_the_targets(
    buffering: str, elements: int, memory_bits: int, mhz: float
) -> None:
    """In the size of Table 1: less than the paper's 6,507 elements and 803,104 bits, at 100 MHz."""
    size = {"width": 1200, "height": 720}
    wanted = {"profile": "paper", "buffering": buffering, **size, "pixels_per_clock": 1, "multiplied": 0}
    (build,) = (found for found in committed()["builds"] if wanted.items() <= found.items())
    assert build["le_packed"] <= elements and build["memory_bits"] <= memory_bits
    assert build["fmax_mhz"] >= mhz and build["multipliers"] == 0
    assert build["clocks_per_frame"] == 1200 * 720


@pytest.mark.slow
@each(
    "build",
    {build.name: build for build in QUICK},
    quick=[build.name for build in QUICK if build.profile == "paper" and build.buffering == "banked"],
)
def test_cheap_figures_are_measured_anew(build: Variant) -> None:
    (kept,) = (
        found
        for found in committed()["builds"]
        if {name: found[name] for name in asdict(build)} == asdict(build)
    )
    fresh = structure(build.parameters) | clocks(build.parameters)
    for field in ("declared_memory_bits", "port_bits", "clocks_per_frame", "end_of_frame_clocks", "corners"):
        assert kept[field] == fresh[field], f"{field} has changed: run cornerstream compare"
