"""The commands on good input."""

from __future__ import annotations

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import cornerstream.simulation
from cornerstream.picture import ACCEPTED, REJECTED
from golden import Corners, Parameters, Settings, StreamModel, detect
from golden.version import VERSION
from sim import Mismatch
from tests.support.photographs import photograph
from tests.support.runner import run

WIDTH, HEIGHT = 40, 30
SIZE = ("--max-width", str(WIDTH), "--max-height", str(HEIGHT))
BOTH_KINDS = ("--texture", "mean", "--sigma1", "0.05", "--sigma2", "1")
"""A filter and thresholds with which this image has corners of both kinds."""
FILTERED = Parameters.profile("robust", texture="mean")
SETTINGS = Settings(sigma1=0.05, sigma2=1.0, report_rejected=True)


@pytest.fixture(autouse=True)
def image(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> np.ndarray:
    """``grey.png`` in the working directory: part of a photograph with corners of both kinds."""
    part = photograph("camera")[230 : 230 + HEIGHT, 170 : 170 + WIDTH]
    Image.fromarray(part).save(tmp_path / "grey.png")
    monkeypatch.chdir(tmp_path)
    return part


def table(path: str) -> list[dict[str, float]]:
    with open(path, newline="") as file:
        return [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]


def as_table(corners: Corners) -> list[dict[str, float]]:
    names = ("x", "y", "response", "accepted", "clamped", "not_maximum")
    columns = (
        corners.x,
        corners.y,
        corners.response,
        corners.accepted,
        corners.flags & 1,
        corners.flags >> 1 & 1,
    )
    return [dict(zip(names, map(float, row), strict=True)) for row in zip(*columns, strict=True)]


def test_detect_writes_the_golden_models_corners(image: np.ndarray) -> None:
    result = run("detect", "grey.png", "-o", "out", *BOTH_KINDS)
    corners = detect(image, FILTERED, SETTINGS)
    assert table("out/corners.csv") == as_table(corners)
    accepted, rejected = int(corners.accepted.sum()), int((~corners.accepted).sum())
    assert accepted > 0 and rejected > 0
    assert f"{WIDTH}x{HEIGHT}" in result.stdout and f" {accepted} " in result.stdout
    assert result.stderr == "Written: out/corners.csv, out/corners.png\n"


def test_sigma2_that_is_rounded_is_said(image: np.ndarray) -> None:
    rounded = run("detect", "grey.png", "--texture", "mean", "--sigma2", "0.49", "--json")
    assert rounded.stderr == "sigma2 is 0.49; used: 0.375, since with texture 'mean' it counts in eighths\n"
    exact = run("detect", "grey.png", "--texture", "mean", "--sigma2", "0.375", "--json")
    corners, same = (json.loads(result.stdout)["corners"] for result in (rounded, exact))
    assert exact.stderr == "" and corners == same != []


def test_accepted_corners_are_kept_apart(image: np.ndarray) -> None:
    run("detect", "grey.png", "-o", "out", "--min-distance", "20", *BOTH_KINDS)
    found = detect(image, FILTERED, SETTINGS)
    assert table("out/corners.csv") == as_table(found.apart(20))
    assert 0 < np.count_nonzero(found.apart(20).accepted) < np.count_nonzero(found.accepted)


def test_picture_has_both_colours() -> None:
    run("detect", "grey.png", *BOTH_KINDS)
    with Image.open("build/corners.png") as picture:
        pixels = np.asarray(picture)
    for colour in (ACCEPTED, REJECTED):
        assert (pixels == colour).all(axis=-1).sum() > 20


def test_detect_as_json(image: np.ndarray) -> None:
    result = run("detect", "grey.png", "--json", "--profile", "paper", "--fit", "printed", "--sigma1", "0.3")
    found = json.loads(result.stdout)
    settings = Settings(sigma1=0.3, report_rejected=True)
    corners = detect(image, Parameters.profile("paper", fit="printed"), settings)
    assert (found["image"], found["width"], found["height"]) == ("grey.png", WIDTH, HEIGHT)
    assert [{k: float(v) for k, v in corner.items()} for corner in found["corners"]] == as_table(corners)
    # files only where they are asked for
    assert [path.name for path in Path().iterdir()] == ["grey.png"]


@pytest.mark.parametrize("limit", ["max_corners", "target_corners"])
def test_a_limit_or_a_target_builds_what_it_needs(image: np.ndarray, limit: str) -> None:
    option, apart = "--" + limit.replace("_", "-"), ("--response-filter", "none", "--suppression", "2")
    result = run("detect", "grey.png", "--json", *apart, "--sigma1", "0.01", option, "3")
    settings = Settings(sigma1=0.01, report_rejected=True, **{limit: 3})
    corners = detect(image, Parameters(budget=True).changed(suppression=2, response_filter="none"), settings)
    found = json.loads(result.stdout)["corners"]
    assert [{k: float(v) for k, v in corner.items()} for corner in found] == as_table(corners)
    assert corners.accepted.sum() <= 3 if limit == "max_corners" else len(corners) > 0


def test_cells_build_what_they_need(image: np.ndarray) -> None:
    """Where they choose, what the texture filter rejects is not reported."""
    result = run(
        "detect",
        "grey.png",
        "--json",
        "--profile",
        "paper",
        "--sigma1",
        "0.01",
        "--cell",
        "9x8",
        "--per-cell",
        "1",
    )
    settings = Settings(sigma1=0.01, cell_width=9, cell_height=8, per_cell=1)
    corners = detect(image, Parameters.profile("paper", max_per_cell=1), settings)
    found = json.loads(result.stdout)
    assert [{k: float(v) for k, v in corner.items()} for corner in found["corners"]] == as_table(corners)
    assert len(corners) > 1 and corners.accepted.all()
    assert found["parameters"]["max_per_cell"] == 1 and found["settings"]["report_rejected"] is False


def test_conversion_is_said_in_a_line() -> None:
    Image.new("RGB", (20, 20), "red").save("colour.png")
    result = run("detect", "colour.png", "--json")
    line = "colour image: converted to grey by BT.601 (0.299 R + 0.587 G + 0.114 B)"
    said, advice = result.stderr.splitlines()
    assert said == f"colour.png: {line}" and advice.startswith("robust: no corners: the response is 0")
    assert json.loads(result.stdout)["corners"] == []


@pytest.mark.parametrize("stalls", [[], ["--stall-input", "0.3", "--stall-output", "0.4", "--seed", "9"]])
def test_simulate(image: np.ndarray, stalls: list[str]) -> None:
    result = run("simulate", "grey.png", "--engine", "amaranth", "-o", "out", *SIZE, *BOTH_KINDS, *stalls)
    model = StreamModel(FILTERED)
    corners = [model.process(image, SETTINGS).corners for _ in range(2)][-1]
    assert table("out/corners.csv") == as_table(corners)
    assert Path("out/corners.png").is_file()
    rows = [line.split("│")[1:-1] for line in result.stdout.splitlines() if line.startswith("│")]
    assert [(row[0].strip(), row[1].strip()) for row in rows] == [("robust", "0"), ("robust", "1")]
    for row in rows:
        assert row[2].strip() == f"{WIDTH}x{HEIGHT}" and row[7].strip() == "0"
        assert (row[4].strip() == "1.000") == (not stalls)
    assert rows[1][5].strip() == str(corners.accepted.sum())
    assert "clocks/s" in result.stdout and "Written: out/corners.csv" in result.stderr


def test_simulate_several_pixels_per_clock(image: np.ndarray) -> None:
    """The last beat of a row is not full; there is a list of the lanes for waves."""
    pixels, width = image[:, 1:].copy(), WIDTH - 1
    Image.fromarray(pixels).save("odd.png")
    options = ("--pixels-per-clock", "4", "--frames", "1", "--sigma1", "0.01", "--vcd", "waves.vcd")
    result = run("simulate", "odd.png", "--engine", "amaranth", "-o", "out", *options, *SIZE)
    beats = HEIGHT * WIDTH // 4
    figures = ["robust", "0", f"{width}x{HEIGHT}", str(beats), f"{beats / width / HEIGHT:.3f}"]
    (row,) = (line.split("│")[1:-1] for line in result.stdout.splitlines() if line.startswith("│"))
    assert [cell.strip() for cell in row[:5]] == figures and row[7].strip() == "0"
    corners = detect(pixels, settings=Settings(sigma1=0.01, reference="constant"))
    assert table("out/corners.csv") == as_table(corners) != []
    assert "lane 3" in Path("waves.gtkw").read_text()
    expected, actual = (float(re.search(r"([\d.]+) MB", line)[1]) for line in result.stderr.splitlines()[::2])
    assert actual < expected < 4 * actual


def test_waves_are_written_with_a_signal_list() -> None:
    options = ("--frames", "1", "--vcd", "waves/w.vcd", "--vcd-clocks", "50")
    result = run("simulate", "grey.png", "--engine", "amaranth", *SIZE, *options)
    assert Path("waves/w.vcd").stat().st_size > 0
    assert "i__valid" in Path("waves/w.gtkw").read_text()
    before, written, after, advice = result.stderr.splitlines()
    assert before == "Waves of 50 clocks will take up to about 0.3 MB (an estimate)"
    assert "waves/w.vcd, waves/w.gtkw" in written
    assert after == f"Waves: {Path('waves/w.vcd').stat().st_size / 1e6:.1f} MB"
    # the first frame has none before it
    assert "since the reference is --constant, which is 8192; try a smaller --constant" in advice


def test_mismatches_are_told_and_end_with_code_1(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        cornerstream.simulation, "compare", lambda *_: [Mismatch(0, 3, 5, 6), Mismatch(0, 4, None, 1)]
    )
    result = run("simulate", "grey.png", "--engine", "amaranth", "--frames", "1", *SIZE, code=1)
    rows = [line.split("│")[-2].strip() for line in result.stdout.splitlines() if line.startswith("│")]
    assert rows == ["2"]
    assert (
        "Error: hardware and golden model differ with profile robust: 2 mismatches: 1 wrong, 0 missing, 1 surplus"
        in result.stderr
    )
    assert "frame 0, record 3: expected" in result.stderr


def test_verilog_to_a_file_and_to_stdout() -> None:
    run("verilog", *SIZE, "-o", "sub/core.v")
    text = Path("sub/core.v").read_text()
    assert "\nmodule cornerstream(" in text and f"max_width = {WIDTH}\n" in text
    assert run("verilog", *SIZE).stdout == text


def test_version() -> None:
    assert run("--version").stdout == f"cornerstream, version {VERSION}\n"


@pytest.mark.parametrize("command", [[], ["simulate"], ["detect"], ["verilog"], ["bench"]])
def test_help(command: list[str]) -> None:
    result = run(*command, "--help")
    assert result.stdout.startswith("Usage: cornerstream")
    assert "Examples:\n" in result.stdout


def test_bench() -> None:
    found = json.loads(run("bench", "--no-engines", "--repeats", "1", "--json").stdout)
    assert found["golden"]["frame"] == "1920x1080" and found["golden"]["ratio"] > 0


def test_both_profiles_in_one_picture(image: np.ndarray) -> None:
    result = run("detect", "grey.png", "-o", "out", "--profile", "robust", "--profile", "paper", *BOTH_KINDS)
    rows = [line.split("│")[1:-1] for line in result.stdout.splitlines() if line.startswith("│")]
    for name, row in zip(("robust", "paper"), rows, strict=True):
        corners = detect(image, Parameters.profile(name, texture="mean"), SETTINGS)
        assert table(f"out/corners-{name}.csv") == as_table(corners)
        accepted = int(corners.accepted.sum())
        assert [cell.strip() for cell in row[:4]] == [
            *(name, f"{WIDTH}x{HEIGHT}", str(accepted), str(len(corners) - accepted))
        ]
    written, advice = result.stderr.splitlines()
    assert written == "Written: out/corners-robust.csv, out/corners-paper.csv, out/corners.png"
    assert advice.startswith("paper: the texture filter rejects")
    run("detect", "grey.png", "-o", "one", *BOTH_KINDS)
    with Image.open("out/corners.png") as both, Image.open("one/corners.png") as one:
        assert both.width > 1.9 * one.width


def test_simulate_both_profiles(image: np.ndarray) -> None:
    options = ("--engine", "amaranth", "--frames", "1", "-o", "out", *SIZE)
    result = run("simulate", "grey.png", "--profile", "paper", "--profile", "robust", *options)
    rows = [line.split("│")[1:-1] for line in result.stdout.splitlines() if line.startswith("│")]
    assert [row[0].strip() for row in rows] == ["paper", "robust"]
    for name in ("paper", "robust"):
        model = StreamModel(Parameters.profile(name))
        corners = model.process(image, Settings(report_rejected=True)).corners
        assert table(f"out/corners-{name}.csv") == as_table(corners)
    assert Path("out/corners.png").is_file()


SQUARE = np.zeros((60, 60), np.uint8)
SQUARE[20:40, 20:40] = 255
FIELDS = (np.indices((8, 8)).sum(axis=0) % 2 * 200 + 20).astype(np.uint8)
BOARD = np.kron(FIELDS, np.ones((13, 13), np.uint8))
FAINT = (SQUARE // 25 + 90).astype(np.uint8)
"""A square of 10 steps above its ground."""


def advice_on(pixels: np.ndarray, *options: str) -> list[str]:
    Image.fromarray(pixels).save("drawn.png")
    return run("detect", "drawn.png", "--json", *options).stderr.splitlines()


@pytest.mark.parametrize("pixels", [SQUARE, BOARD])
def test_most_corners_rejected_is_said(pixels: np.ndarray) -> None:
    settings = Settings(report_rejected=True)
    corners = detect(pixels, Parameters.profile("paper", ties="first"), settings)
    rejected = np.count_nonzero(~corners.accepted)
    assert rejected > len(corners) / 2
    told = f"the texture filter rejects {rejected} of {len(corners)} corners"
    (line,) = advice_on(pixels, "--profile", "paper", "--ties", "first")
    assert line == f"paper: {told}; try --profile robust, or a larger --sigma2"
    assert advice_on(pixels) == []
    # what the line proposes helps
    assert detect(pixels, settings=settings).accepted.sum() > len(corners) / 2


def test_most_corners_rejected_by_the_local_mean_is_said() -> None:
    filtered = ("detect", "grey.png", "--json", "--texture", "mean", "--sigma2")
    (line,) = run(*filtered, "1.875").stderr.splitlines()
    assert line == "robust: the texture filter rejects 3 of 4 corners; try a smaller --sigma2"
    assert run(*filtered, "0.5").stderr == ""


def test_why_there_are_no_corners_is_said() -> None:
    assert advice_on(np.full((30, 30), 9, np.uint8)) == [
        "robust: no corners: the response is 0 everywhere: there are no edges, or only straight ones"
    ]
    (line,) = advice_on(FAINT)
    assert "since the reference is never below --floor, which is 1024; try a smaller --floor" in line
    assert advice_on(FAINT, "--floor", "20") == []
    (line,) = advice_on(SQUARE, "--reference", "constant", "--constant", "130050", "--sigma1", "0.9")
    assert line.endswith("since the reference is --constant, which is 130050; try a smaller --constant")
    # its corners lie between four pixels, whose responses are equal
    (line,) = advice_on(BOARD, "--profile", "paper")
    assert line.endswith(
        "neither of two equal neighbouring responses is a corner; try --profile robust, or --ties first"
    )
    assert advice_on(BOARD) == []
    (line,) = advice_on(BOARD, "--ties", "strict")
    assert line.endswith("responses is a corner; try --ties first")
