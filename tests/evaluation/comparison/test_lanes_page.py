"""The section on several pixels per clock: figures, what follows from them, targets, peers."""

from __future__ import annotations

import re
from typing import Any

import pytest

from evaluation.comparison import page as comparison
from evaluation.comparison.parts import frame_clocks
from evaluation.comparison.peers import PEERS, SOURCES
from evaluation.comparison.targets import TARGETS, targets_table
from evaluation.comparison.variants import UHD, Variant, all_builds, builds, lanes_builds
from evaluation.figures import Figures
from golden import PROFILES
from hdl.build import PIXELS_PER_CLOCK
from tests.evaluation.comparison.invented import TOOLS, UNMEASURED, invented, row

SECTION = "Several pixels per clock"


def figures(build: Variant, **changes: Any) -> Figures:
    """A thousand logic elements for each pixel of a beat, and 200 for the rest."""
    lanes = build.pixels_per_clock
    elements = 200 + 1000 * lanes
    blocks = {"response": elements - 200, "records": 200}
    beats = -(-build.width // lanes) * build.height
    if build.multiplied:
        elements, blocks = elements - 10, {}
    known = {
        "le_packed": elements,
        "blocks": blocks,
        "clocks_per_frame": beats + 3,
        "multipliers": 84 if build.multiplied else 0,
    }
    return invented(build, **{**known, "fmax_mhz": 150.0, **changes})


def page(**changes: Any) -> str:
    return comparison.page({"tools": TOOLS, "builds": [figures(build, **changes) for build in all_builds()]})


def rows(text: str, first: str) -> list[list[str]]:
    """Cells of all rows that begin with these, in the section."""
    section = text.partition(f"## {SECTION}")[2].partition("\n## ")[0]
    lines = [line for line in section.splitlines() if line.startswith(f"| {first}")]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_every_profile_has_every_number_of_pixels_per_clock() -> None:
    several = {(build.profile, build.pixels_per_clock) for build in lanes_builds()}
    assert several == {(profile, lanes) for profile in PROFILES for lanes in PIXELS_PER_CLOCK[1:]}
    large = [build for build in lanes_builds() if (build.width, build.height) == UHD]
    assert {build.pixels_per_clock for build in large} == {4}


def test_what_it_costs() -> None:
    first, second = rows(page(), "`robust` | 4")[:2]
    # 4,200 elements are 3.5 times 1,200; four pixels at 150 MHz are 0.6 Gpixel/s
    assert first[2:] == ["4,200", "3.50", "262,146", "37", "150.0", "0.600", "7,000", "48"]
    # 150 MHz over 480, 960 and 1,920 beats of 1,080, 2,160 and 4,320 rows
    assert second[2:] == ["150.0", "289.4", "72.3", "18.1", "216,003", "216,000"]
    assert rows(page(), "`paper`, `banked` | 1")[0][2] == "1,200"


def test_a_row_that_is_no_whole_number_of_beats_takes_one_more() -> None:
    clocks = [frame_clocks((1201, 10), lanes) for lanes in (1, 2, 4, 8)]
    assert clocks == [12_010, 6010, 3010, 1510]


def test_blocks_and_paths() -> None:
    text = page()
    (response,) = rows(text, "`response`")
    (total,) = rows(text, "all |")
    lanes = [1, 2, 4, 8]
    assert response[1:5] == [f"{1000 * each:,}" for each in lanes]
    assert total[1:5] == [f"{200 + 1000 * each:,}" for each in lanes]
    assert ["`here`", "`there`"] in [cells[2:4] for cells in rows(text, "`paper` | 3840×2160")]


def test_what_was_not_measured_is_a_dash() -> None:
    text = page(**dict.fromkeys((*UNMEASURED, "le_packed", "memory_bits", "m9k")))
    assert "None" not in text
    assert rows(text, "`robust` | 4")[0][2:] == ["–"] * 7 + ["48"]


def test_without_several_pixels_per_clock_there_is_no_section() -> None:
    alone = [figures(build) for build in all_builds() if build in builds()]
    text = comparison.page({"tools": TOOLS, "builds": alone})
    assert SECTION not in text and "## Table 1" in text


def test_the_papers_tables_have_one_pixel_per_clock_only() -> None:
    """They are the same, whether there are builds of several or not."""
    alone = [figures(build) for build in all_builds() if build in builds()]
    single = comparison.page({"tools": TOOLS, "builds": alone})
    tables = [text.partition("## Table 1")[2].partition("## Every build")[0] for text in (page(), single)]
    assert tables[0] == tables[1] != ""


@pytest.mark.parametrize("target", TARGETS)
def test_targets_are_reached_or_missed(target: Any) -> None:
    measured = [figures(build) for build in (*builds(), *lanes_builds())]
    wanted = (target.profile, "lean", *target.size, target.pixels_per_clock)
    fields = ("profile", "buffering", "width", "height", "pixels_per_clock")
    (build,) = (each for each in measured if tuple(each[field] for field in fields) == wanted)
    limit = 1200 * target.limit if target.times else target.limit
    beginning = f"| `{target.profile}`, {target.pixels_per_clock} pixels per clock, {target.size[0]}×"
    sign = "≥" if target.at_least else "≤"

    def verdict(value: float | None) -> str:
        build[target.field] = value
        lines = [line for line in targets_table(measured).splitlines() if line.startswith(beginning)]
        (line,) = (line for line in lines if f"| {sign} " in line)
        return line.split("|")[-2].strip()

    assert verdict(limit) == "reached" and verdict(None) == "–"
    worse = limit - 2 if target.at_least else limit + 2
    assert re.fullmatch(r"\*\*missed by 2(\.0)?\*\*", verdict(worse))


def test_builds_with_multipliers_are_in_a_table_of_their_own() -> None:
    text = page()
    section = text.partition("### With embedded multipliers")[2].partition("\n### ")[0]
    lines = [line for line in section.splitlines() if line.startswith("| `robust` | 4")]
    assert [line.strip("| ").split(" | ")[2:] for line in lines] == [
        ["0", "4,200", "37", "262,146"],
        ["84", "4,190", "37", "262,146"],
    ]
    assert "4,190" not in text.replace(section, "")


def test_peers_are_told_with_their_sources() -> None:
    text = page()
    section = text.partition("### Peers of several pixels per clock")[2].partition("\n## ")[0]
    for peer in PEERS:
        assert f"| {peer.name} | {peer.result} | {peer.pixels_per_clock} |" in section
    for source in SOURCES:
        assert source.url in section
    # 24,594 are 4.32 times 5,695; eight pixels at 150 MHz are 1.2 Gpixel/s
    vitis = row(text, SECTION, "AMD Vitis Vision cornerHarris | mask image | 8")
    assert vitis[3:] == ["24,594 LUT6", "4.32", "90 of 18 Kbit", "80", "150", "1.200", "20,495"]
    tone = row(text, SECTION, "Intel Tone Mapping Operator, 8 bits | video | 4")
    assert tone[3:] == ["18,068 ALM", "2.39", "114 M20K", "203", "–", "–", "–"]
    assert row(text, SECTION, "DOSLAM")[2:] == ["8", *["–"] * 7]
    assert row(text, SECTION, "Wasala")[2:] == ["4", *["–"] * 4, "150", "0.600", "–"]
    ours = row(text, SECTION, "cornerstream, `paper` | list of corners | 8")
    assert ours[3:] == ["8,200 LE", "6.83", "37 M9K", "0", "150", "1.200", "6,833"]
