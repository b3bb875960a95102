"""Bad input: exit code 2, one line with the value and what is allowed, nothing written."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from PIL import Image

from hdl.build import Build
from tests.support.refusals import check, listing, run

pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.parametrize("command", ["simulate", "detect"])
@pytest.mark.parametrize(
    ("image", "parts"),
    [
        ("missing.png", ["missing.png does not exist; allowed: an image file"]),
        ("text.png", ["text.png is not an image", "allowed: PNG, JPEG"]),
        ("empty.png", ["empty.png is not an image"]),
        ("folder.png", ["folder.png cannot be read: Is a directory"]),
        ("good.png/below.png", ["good.png/below.png cannot be read: Not a directory"]),
        ("cut.png", ["cut.png is damaged", "allowed: a complete image file"]),
        ("deep.png", ["deep.png is 16-bit RGB (PPM)", "allowed: grey of up to 16 bits in PNG, TIFF"]),
        ("narrow.png", ["narrow.png is 12x30 pixels; allowed: 13x13 up to", "32x24"]),
        ("low.png", ["low.png is 30x12 pixels; allowed: 13x13 up to", "32x24"]),
        ("wide.png", ["wide.png is 33x24 pixels; allowed: 13x13 up to", "32x24", "--max-width"]),
        ("high.png", ["high.png is 32x25 pixels; allowed: 13x13 up to", "32x24"]),
    ],
)
def test_image(folder: Path, command: str, image: str, parts: list[str]) -> None:
    before = listing(folder)
    check(run(command, image, "--max-width", "32", "--max-height", "24"), *parts)
    assert listing(folder) == before


@pytest.mark.parametrize("command", ["simulate", "detect"])
@pytest.mark.parametrize("profiles", [("robust", "paper"), ("precise", "robust")])
def test_image_too_small_for_one_profile(folder: Path, command: str, profiles: tuple[str, str]) -> None:
    Image.new("L", (13, 13)).save(folder / "small.png")
    before = listing(folder)
    options = [word for name in profiles for word in ("--profile", name)]
    check(run(command, "small.png", *options), "small.png is 13x13 pixels; allowed: 15x15 up to")
    assert listing(folder) == before


@pytest.mark.parametrize("command", ["simulate", "detect"])
@pytest.mark.parametrize(
    ("option", "value", "parts"),
    [
        ("--sigma1", "1.5", ["sigma1 is 1.5", "allowed"]),
        ("--sigma1", "-0.1", ["sigma1 is -0.1", "allowed"]),
        ("--sigma1", "nan", ["sigma1 is nan", "allowed"]),
        ("--max-corners", "-1", ["max_corners is -1", "allowed: whole numbers from 0 to 65535"]),
        ("--target-corners", "65536", ["target_corners is 65536", "allowed: whole numbers from 0 to 65535"]),
        ("--per-cell", "-1", ["per_cell is -1", "allowed: whole numbers from 0 to 16"]),
        ("--per-cell", "17", ["per_cell is 17", "allowed: whole numbers from 0 to 16"]),
        ("--cell", "64", ["'64' is no size of a cell", "allowed: width and height, such as 64x48"]),
        ("--cell", f"{'9' * 5000}x8", ["is no size of a cell", "allowed: width and height"]),
        ("--cell", "7x64", ["cell_width is 7", "allowed: whole numbers from 8 to 128"]),
        ("--cell", "64x129", ["cell_height is 129", "allowed: whole numbers from 8 to 128"]),
        ("--suppression", "5", ["suppression is 5", "allowed: whole numbers from 1 to 4"]),
        ("--sigma1", "much", ["--sigma1", "'much' is not a valid float"]),
        ("--sigma2", "16", ["sigma2 is 16.0", "allowed"]),
        (
            "--sigma1",
            "1e-6",
            ["sigma1 is 1e-06, less than half of 1/65536", "allowed: 0, or 1/65536 and more"],
        ),
        ("--constant", "0", ["constant is 0", "allowed"]),
        ("--constant", "130051", ["constant is 130051", "allowed", "130050"]),
        ("--floor", "-1", ["floor is -1", "allowed"]),
        ("--reference", "next", ["--reference", "'next' is not one of 'previous', 'constant'"]),
        ("--profile", "best", ["--profile", "'best' is not one of 'paper', 'robust', 'precise'"]),
        ("--gradient", "odd", ["--gradient", "'odd' is not one of 'absolute', 'signed'"]),
        ("--max-width", "12", ["max_width is 12", "allowed: whole numbers from 13 to 8192"]),
        ("--max-height", "8193", ["max_height is 8193", "allowed: whole numbers from 13 to 8192"]),
        ("--output", "good.png/below", ["good.png/below: Not a directory", "allowed: a folder"]),
        ("--output", "good.png", ["good.png: File exists", "allowed: a folder"]),
        ("--colour", "red", ["No such option", "--colour"]),
    ],
)
def test_option(folder: Path, command: str, option: str, value: str, parts: list[str]) -> None:
    before = listing(folder)
    engine = ["--engine", "amaranth"] if command == "simulate" else []
    check(run(command, "good.png", *engine, option, value), *parts)
    assert listing(folder) == before


@pytest.mark.parametrize("value", ["0.1", "1.9", "15"])
def test_sigma2_as_the_weight_of_the_local_mean(folder: Path, value: str) -> None:
    before = listing(folder)
    allowed = "allowed with texture 'mean': 0, or 0.125 to 1.875, in eighths"
    for command in (("detect",), ("simulate", "--engine", "amaranth")):
        check(
            run(*command, "good.png", "--texture", "mean", "--sigma2", value),
            f"sigma2 is {float(value)}; {allowed}",
        )
    assert listing(folder) == before


@pytest.mark.parametrize("value", ["-1", "nan", "inf"])
def test_distance(folder: Path, value: str) -> None:
    before = listing(folder)
    check(
        run("detect", "good.png", "--min-distance", value),
        f"min_distance is {float(value)}; allowed: numbers of",
    )
    assert listing(folder) == before


@pytest.mark.parametrize(
    ("profiles", "lanes", "least"),
    [
        (["robust"], 2, (15, 13)),
        (["robust"], 4, (17, 13)),
        (["robust"], 8, (25, 13)),
        (["robust", "paper"], 4, (19, 15)),
    ],
)
def test_image_narrower_than_several_pixels_per_clock_take(
    folder: Path, profiles: list[str], lanes: int, least: tuple[int, int]
) -> None:
    builds = [Build.profile(profile, pixels_per_clock=lanes) for profile in profiles]
    assert least[0] == max(build.min_width for build in builds)
    before, options = listing(folder), [word for name in profiles for word in ("--profile", name)]
    Image.new("L", (least[0] - 1, 24)).save(folder / "narrow.png")
    check(
        run("simulate", "narrow.png", *options, "--pixels-per-clock", str(lanes)),
        f"narrow.png is {least[0] - 1}x24 pixels; "
        f"allowed with {lanes} pixels per clock: {least[0]}x{least[1]} up to the built maximum",
    )
    assert listing(folder) == before


@pytest.mark.parametrize(
    "line", ["simulate good.png", "verilog -o new.v", "package -o new", "quartus export -o new", "synth"]
)
@pytest.mark.parametrize(
    ("options", "part"),
    [
        ("--pixels-per-clock 3", "pixels_per_clock is 3; allowed: 1, 2, 4, 8"),
        ("--pixels-per-clock 4 --max-width 16", "max_width is 16; allowed: whole numbers from 17 to 8192"),
        ("--pixels-per-clock 8 --max-width 24", "max_width is 24; allowed: whole numbers from 25 to 8192"),
    ],
)
def test_pixels_per_clock(folder: Path, line: str, options: str, part: str) -> None:
    before = listing(folder)
    check(run(*line.split(), *options.split()), part)
    assert listing(folder) == before


@pytest.mark.parametrize(
    ("option", "value", "parts"),
    [
        ("--fit", "printed", ["fit is 'printed'", "allowed in hardware: nine, six"]),
        ("--pixels-per-clock", "0", ["pixels_per_clock is 0; allowed: 1, 2, 4, 8"]),
        ("--pixels-per-clock", "16", ["pixels_per_clock is 16; allowed: 1, 2, 4, 8"]),
        ("--pixels-per-clock", "two", ["--pixels-per-clock", "'two' is not a valid integer"]),
        ("--frames", "0", ["--frames", "0 is not in the range x>=1"]),
        # 32x24 pixels each
        ("--frames", "349526", ["--frames is 349526; allowed with an image of this size: 1 to 349525"]),
        ("--stall-input", "1", ["stall probability of inputs is 1.0; allowed: 0 <= p < 1"]),
        ("--stall-output", "-0.5", ["stall probability of outputs is -0.5; allowed: 0 <= p < 1"]),
        ("--seed", "-1", ["seed is -1; allowed: whole numbers from 0"]),
        ("--engine", "guess", ["--engine", "'guess' is not one of 'compiled', 'amaranth', 'verilog'"]),
        ("--vcd-clocks", "0", ["--vcd-clocks", "0 is not in the range x>=1"]),
        ("--vcd", "good.png/waves.vcd", ["good.png: File exists", "allowed: a folder that can be written"]),
        ("--vcd", "waves.gtkw", ["'waves.gtkw'", "allowed: a file whose name ends in .vcd"]),
        ("--vcd", "", ["'--vcd'", "the path is empty; allowed: that of a file or folder"]),
        ("--vcd", "pipe.vcd", ["'pipe.vcd'", "allowed: a file whose name ends in .vcd"]),
        ("--vcd", "folder.vcd", ["'folder.vcd'", "allowed: a file whose name ends in .vcd"]),
        ("--constant", "0", ["constant is 0; allowed: whole numbers from 1 to 130050"]),
    ],
)
def test_option_of_simulate(folder: Path, option: str, value: str, parts: list[str]) -> None:
    before = listing(folder)
    check(run("simulate", "good.png", "--engine", "amaranth", "-o", ".", option, value), *parts)
    assert listing(folder) == before


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--fit", "printed"], ["fit is 'printed'", "allowed in hardware: nine, six"]),
        (["--pixel-bits", "3"], ["pixel_bits is 3", "allowed: whole numbers from 4 to 10"]),
        (["-o", "good.png/core.v"], ["good.png: File exists", "allowed: a folder that can be written"]),
        (["-o", "folder.png"], ["folder.png: Is a directory", "allowed"]),
        (["-o", "-"], ["the path is '-'; allowed: that of a file or folder, such as /dev/stdout"]),
    ],
)
def test_verilog(folder: Path, arguments: list[str], parts: list[str]) -> None:
    before = listing(folder)
    check(run("verilog", "--max-width", "32", "--max-height", "32", *arguments), *parts)
    assert listing(folder) == before


@pytest.mark.parametrize(
    "line",
    [
        *(f"{command} good.png -o <>" for command in ("detect", "simulate")),
        *(
            f"{command} -o <>"
            for command in ("detect good.png", "verilog", "package", "quartus export", "compare")
        ),
        *("detect <>", "simulate <>", "quartus report <>", "eval -o <>", "eval --images <>"),
        *("eval --boards <>", "eval --pairs <>", "eval --video <>", "eval --hpatches <>"),
        *("synth --no-timing --netlist <>", "synth --no-timing --plot <>"),
    ],
)
def test_empty_path(folder: Path, line: str) -> None:
    before = listing(folder)
    check(run(*("" if word == "<>" else word for word in line.split())), "the path is empty; allowed: that")
    assert listing(folder) == before


ONE = "are one file; allowed: a file of its own for each"


@pytest.mark.parametrize(
    ("line", "part"),
    [
        ("detect kept/corners.png -o kept", f"kept/corners.png and kept/corners.png {ONE}"),
        ("detect link.png -o kept", f"kept/corners.png and link.png {ONE}"),
        ("simulate link.png -o ./kept --engine amaranth", f"kept/corners.png and link.png {ONE}"),
        ("simulate good.png -o new.vcd --vcd new.vcd --engine amaranth", f"new.vcd and new.vcd {ONE}"),
        ("synth --no-timing --netlist a.png --plot folder.png/../a.png", f"a.png {ONE}"),
    ],
)
def test_one_file_for_two_things(folder: Path, line: str, part: str) -> None:
    before, picture = listing(folder), (folder / "kept" / "corners.png").read_bytes()
    check(run(*line.split()), part)
    assert listing(folder) == before and (folder / "kept" / "corners.png").read_bytes() == picture


@pytest.mark.parametrize("command", ["compare", "eval"])
@pytest.mark.parametrize(
    ("place", "part"),
    [
        ("none", "has other figures than the page shows; allowed: what was measured before"),
        ("empty", "has other figures than the page shows"),
        ("other", "has other figures than the page shows"),
        ("new", "cannot read new/"),
        ("line\nbreak", "cannot read line\\nbreak/"),
    ],
)
def test_page_of_no_figures(folder: Path, command: str, place: str, part: str) -> None:
    before = listing(folder)
    check(run(command, "--page", "-o", place), part)
    assert listing(folder) == before


def test_photograph_larger_than_the_built_maximum() -> None:
    check(run("simulate", "--max-width", "300"), "camera", "is 512x512 pixels", "300x1080")


def test_waves_are_those_of_one_profile(folder: Path) -> None:
    before = listing(folder)
    both = ("--profile", "paper", "--profile", "robust")
    check(
        run("simulate", "good.png", "--vcd", "a.vcd", *both), "--profile is paper, robust", "with --vcd: one"
    )
    assert listing(folder) == before


def test_unknown_command() -> None:
    check(run("detekt"), "No such command 'detekt'")


@pytest.mark.parametrize(
    ("line", "message", "name"),
    [
        ("export -o new", "'export' has another name now", "cornerstream quartus export"),
        ("report", "'report' has another name now", "cornerstream quartus report"),
        ("tables --page", "'tables' has another name now", "cornerstream compare"),
        ("verilog --width 32", "No such option", "--max-width"),
        ("simulate --height 32", "No such option", "--max-height"),
    ],
)
def test_names_of_before(folder: Path, line: str, message: str, name: str) -> None:
    before = listing(folder)
    check(run(*line.split()), message, name)
    assert listing(folder) == before


def test_missing_argument() -> None:
    check(run("detect"), "Missing argument 'IMAGE'")


def test_one_result_that_cannot_be_written_keeps_the_others_back(folder: Path) -> None:
    (folder / "out" / "corners.png").mkdir(parents=True)
    before = listing(folder)
    check(run("detect", "good.png", "-o", "out"), "cannot write out/corners.png: Is a directory; allowed")
    assert listing(folder) == before


def test_no_place_to_keep_simulators(folder: Path) -> None:
    result = run("simulate", "good.png", "-o", "out", env={"CORNERSTREAM_CACHE": "good.png"})
    check(result, "cannot keep simulators in good.png: File exists; allowed: a folder", "$CORNERSTREAM_CACHE")


def test_as_a_process(folder: Path) -> None:
    root = Path(__file__).parents[2]
    done = subprocess.run(
        [sys.executable, "-m", "cornerstream", "detect", "missing.png"],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": str(root)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == "Error: missing.png does not exist; allowed: an image file\n"
