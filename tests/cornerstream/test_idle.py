"""Options that would change nothing are refused: exit code 2, one line, nothing written."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import Result
from PIL import Image

import cornerstream.compare
import cornerstream.detection
import cornerstream.eval
import cornerstream.simulation
import cornerstream.synth
import cornerstream.verilog
from cornerstream.cli import main
from evaluation.sections.registry import SECTIONS
from tests.support.runner import CliRunner

NOT_QUICK = {name for name, section in SECTIONS.items() if section.not_quick}
IDLE = "which changes nothing; allowed: "


class Reached(Exception):
    """The command has gone past its options."""


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with an image; commands stop as soon as they have taken their options."""

    def stop(*_: object, **__: object) -> None:
        raise Reached

    for module, first in (
        (cornerstream.detection, "load"),
        (cornerstream.simulation, "load"),
        (cornerstream.synth, "require"),
        (cornerstream.compare, "prepare_folder"),
        (cornerstream.verilog, "emit_verilog"),
        (cornerstream.eval, "study"),
    ):
        monkeypatch.setattr(module, first, stop)
    monkeypatch.setattr("cornerstream.quartus.project_files", stop)
    monkeypatch.setattr("cornerstream.package.package_files", stop)
    monkeypatch.setattr("evaluation.comparison.speed.opencv", stop)
    Image.new("L", (32, 24)).save(tmp_path / "a.png")
    (tmp_path / "boards").mkdir()
    Image.new("L", (32, 24)).save(tmp_path / "boards" / "a.png")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def run(line: str) -> Result:
    return CliRunner().invoke(main, line.split(), prog_name="cornerstream")


MEAN = "--texture mean --patches pixels"
TEXTURE = f"--patches is pixels, {IDLE}with --texture patches"
SIGMA2 = f"--sigma2 is 1.0, {IDLE}with --texture patches or mean"
STREAM = f"--video-out is set, {IDLE}with --interface axi"
AUTOSTART = f"--autostart is set, {IDLE}with --interface axi or avalon"
NO_PAGE = f"{IDLE}without --page"
AIMED = "--target-corners 9 --reference constant"
CONSTANT = f"{IDLE}from --floor on, which is 1024"
FLOOR = f"--floor is 99, {IDLE}with --reference previous, or above --constant, which is 8192"
VIEWS = "with --only repeatability or hpatches or robustness or downstream or spread or ablation"
PAIRS = "with --only repeatability or hpatches or robustness or ablation"


@pytest.mark.parametrize(
    ("line", "message"),
    [
        *((f"{command} {MEAN}", TEXTURE) for command in ("verilog", "quartus export", "package", "synth")),
        *((f"{command} a.png {MEAN}", TEXTURE) for command in ("detect", "simulate")),
        ("detect a.png --patches pixels", TEXTURE),
        ("verilog --interface stream --video-out", STREAM),
        ("verilog --interface stream --autostart", AUTOSTART),
        ("synth --interface stream --video-out", STREAM),
        ("synth --interface stream --autostart --no-timing", AUTOSTART),
        ("synth --no-timing --seed 7", f"--seed is 7, {IDLE}without --no-timing"),
        ("simulate a.png --seed 7", f"--seed is 7, {IDLE}with --stall-input or --stall-output"),
        ("simulate a.png --vcd-clocks 9", f"--vcd-clocks is 9, {IDLE}with --vcd"),
        ("simulate a.png --frames 1 --target-corners 9", f"{IDLE}with --frames 2 or more"),
        ("simulate a.png --reference constant --constant 99", f"--constant is 99, {CONSTANT}"),
        ("simulate a.png --reference constant --floor 99", FLOOR),
        ("detect a.png --reference constant --floor 99", FLOOR),
        ("detect a.png --constant 2000", f"--constant is 2000, {IDLE}with --reference constant"),
        (f"detect a.png {AIMED}", f"--reference is constant, {IDLE}without --target-corners"),
        ("detect a.png --smoothing 2", f"--smoothing is 2, {IDLE}with --target-corners or --reference-rank"),
        ("detect a.png --cell 32x48", f"--cell is 32x48, {IDLE}with --per-cell"),
        ("simulate a.png --cell 32x48", f"--cell is 32x48, {IDLE}with --per-cell"),
        ("detect a.png --buffering lean", "No such option"),
        ("detect a.png --max-per-cell 4", "No such option"),
        ("verilog --min-cell-width 16", f"--min-cell-width is 16, {IDLE}with --max-per-cell"),
        ("simulate a.png --min-cell-width 16", f"--min-cell-width is 16, {IDLE}with --max-per-cell"),
        ("detect a.png --profile robust --profile precise --sigma2 1", SIGMA2),
        ("detect a.png --budget", "No such option"),
        ("bench --no-engines --turns 9", f"--turns is 9, {IDLE}without --no-engines"),
        ("compare --page --quick", f"--quick is set, {NO_PAGE}"),
        ("compare --page --no-synthesis", f"--no-synthesis is set, {NO_PAGE}"),
        ("compare --page --jobs 99", f"--jobs is 99, {NO_PAGE}"),
        ("eval --page --quick", f"--quick is set, {NO_PAGE}"),
        ("eval --page --json", f"--json is set, {NO_PAGE}"),
        ("eval --page --only accuracy --only table5", f"--only is accuracy, table5, {NO_PAGE}"),
        ("eval --page --boards boards", f"--boards is boards, {NO_PAGE}"),
        ("eval --only accuracy --images boards", f"--images is boards, {IDLE}{VIEWS}"),
        ("eval --only accuracy --pairs boards", f"--pairs is boards, {IDLE}{PAIRS}"),
        ("eval --only repeatability --video a.mp4", f"{IDLE}with --only robustness"),
        ("eval --only accuracy --boards boards", f"--boards is boards, {IDLE}with --only chessboards"),
        ("eval --only limits --hpatches boards", f"--hpatches is boards, {IDLE}with --only hpatches"),
        ("eval --board-size 9x6", f"--board-size is 9x6, {IDLE}with --boards"),
        ("eval --json --only ablation --profile paper", f"--profile is paper, {IDLE}with --only accuracy"),
        (
            "eval --json --quick --only adaptation",
            "--only is adaptation, which --quick leaves out: its video",
        ),
    ],
)
def test_refused(folder: Path, line: str, message: str) -> None:
    before = sorted(folder.rglob("*"))
    result = run(line)
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    (error,) = result.stderr.splitlines()
    assert error.startswith("Error: ") and message in error
    assert sorted(folder.rglob("*")) == before


@pytest.mark.parametrize(
    "line",
    [
        # with what they are for
        "detect a.png --texture patches --patches pixels",
        "detect a.png --profile robust --texture patches --patches pixels",
        "detect a.png --reference constant --constant 2000",
        "detect a.png --reference constant --floor 9000",
        f"detect a.png --texture patches {AIMED}",
        f"detect a.png --texture patches {AIMED} --floor 99",
        "simulate a.png --constant 2000",
        "simulate a.png --stall-output 0.1 --seed 7",
        "simulate a.png --vcd w.vcd --vcd-clocks 9",
        "simulate a.png --target-corners 9 --buffering lean --budget",
        "detect a.png --cell 32x48 --per-cell 4",
        "simulate a.png --per-cell 4 --max-per-cell 8 --min-cell-width 64",
        "simulate a.png --per-cell 4 --min-cell-width 64",
        "verilog --min-cell-width 8",
        # one of the profiles takes it
        "detect a.png --profile robust --profile paper --sigma2 1",
        "detect a.png --profile robust --profile paper --patches pixels",
        "verilog --video-out --autostart",
        "verilog --interface avalon --autostart",
        "synth --interface axi --video-out --seed 7",
        "eval --only chessboards --boards boards --board-size 9x6",
        "eval --json --only word_lengths --profile robust",
        # with what they are by default
        "detect a.png --profile robust --patches regions --constant 8192",
        "detect a.png --cell 064x64",
        "simulate a.png --seed 0 --vcd-clocks 10000",
        "synth --no-timing --seed 1",
        "bench --no-engines --turns 3",
    ],
)
def test_taken(line: str) -> None:
    assert isinstance(run(line).exception, Reached)


@pytest.mark.parametrize(
    ("line", "sections"),
    [
        ("eval", set(SECTIONS)),
        ("eval --quick", set(SECTIONS) - NOT_QUICK),
        ("eval --quick --json", set(SECTIONS) - NOT_QUICK),
        ("eval --json", set(SECTIONS)),
        ("eval --only table5", {"table5"}),
    ],
)
def test_nothing_is_measured_that_is_not_shown(
    monkeypatch: pytest.MonkeyPatch, line: str, sections: set[str]
) -> None:
    asked: list[str] = []
    monkeypatch.setattr(cornerstream.eval, "study", lambda names, _: asked.extend(names) or {})
    assert run(line).exit_code == 0
    assert set(asked) == sections and len(asked) == len(sections)
