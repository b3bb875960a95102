"""``cornerstream package``: a folder that is written whole or not at all."""

from __future__ import annotations

import gc
import json
import os
import re
import shlex
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from flow import package as package_module
from flow.command import command
from flow.package import MANIFEST
from hdl.build import Build
from tests.support.runner import contents
from tests.support.runner import run_or_refuse as run

SIZE = ("--max-width", "40", "--max-height", "32")

# each package takes seconds to make
package_files = cache(package_module.package_files)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("cornerstream.package.package_files", package_files)
    return tmp_path


def test_package_writes_the_package() -> None:
    options = ("--profile", "robust", "--pixel-bits", "10", "--video-out", "--autostart")
    result = run("package", "-o", "deep/ip", *SIZE, *options)
    changes = {"max_width": 40, "max_height": 32, "pixel_bits": 10, "video_out": True, "autostart": True}
    assert contents(Path("deep/ip")) == package_files(
        Build.profile("robust", **changes), "axi", "cornerstream"
    )
    assert result.stdout == "" and "Written: deep/ip, " in result.stderr
    assert "What is what: deep/ip/README.md" in result.stderr
    assert [path.name for path in Path("deep").iterdir()] == ["ip"]


@pytest.mark.parametrize(
    "options",
    [
        ("--profile", "robust", "--pixel-bits", "10", "--video-out", "--autostart"),
        ("--interface", "avalon", "--name", "corners_b"),
    ],
)
def test_the_readme_has_the_command_that_writes_the_package(options: tuple[str, ...]) -> None:
    run("package", "-o", "ip", *SIZE, *options)
    (line,) = re.findall(r"^cornerstream (package .*)$", Path("ip/README.md").read_text(), re.MULTILINE)
    run(*shlex.split(line), "-o", "again")
    assert contents(Path("ip")) == contents(Path("again"))


@pytest.mark.parametrize(
    "options",
    [
        (),
        ("--profile", "robust"),
        ("--profile", "paper"),
        ("--buffering", "banked", "--budget"),
        ("--profile", "paper", "--texture", "mean", "--gradient", "signed", "--derivative", "sobel"),
        (
            "--profile",
            "paper",
            "--suppression",
            "3",
            "--patches",
            "pixels",
            "--fit",
            "six",
            "--ties",
            "first",
        ),
        ("--fit", "nine", "--texture", "patches", "--response-filter", "none"),
        ("--queue-depth", "32", "--sqrt-bits-per-stage", "3"),
        (*SIZE, "--name", "Other2", "--autostart", "--interface", "avalon", "--pixel-bits", "4"),
        ("--video-out", "--max-width", "8192", "--max-height", "20"),
    ],
)
def test_any_options_are_found_again(options: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr("cornerstream.package.package_files", lambda *built: asked.append(built) or {})
    run("package", "-o", "ip", *options)
    parameters, interface, name = asked[0]
    words = shlex.split(command("package", parameters, interface=interface, name=name))
    run(*words[1:], "-o", "ip2")
    assert asked[1] == asked[0]
    assert len(words) <= len(options) + 4


def test_a_named_package_is_named_throughout() -> None:
    run("package", "-o", "ip", *SIZE, "--interface", "avalon", "--name", "corners_b")
    found = contents(Path("ip"))
    assert {"rtl/corners_b.v", "corners_b.core", "corners_b_hw.tcl", "corners_b.svd"} <= found.keys()
    assert {"software/corners_b.h", "software/corners_b_registers.py"} <= found.keys()
    assert "name: ::corners_b:" in found["corners_b.core"]
    assert "set_module_property NAME corners_b\n" in found["corners_b_hw.tcl"]
    assert "#ifndef CORNERS_B_H\n" in found["software/corners_b.h"]
    assert "<name>corners_b</name>" in found["corners_b.svd"]
    assert "\n    corners_b corner_detector (" in found["example/corners_b_example.v"]
    assert "\nmodule corners_b_example #(" in found["example/corners_b_example.v"]
    assert "\nmodule corners_b_tb;" in found["example/corners_b_tb.v"]
    assert "\nclass CornersB(Registers):" in found["software/corners_b_registers.py"]
    named = found.keys() - {"README.md", "registers.md", "example/lint.vlt", MANIFEST}
    assert all(Path(name).name.startswith("corners_b") for name in named)
    for name in sorted(named):
        # but for who wrote it
        text = found[name].lower().replace("cornerstream package", "").replace("by cornerstream", "")
        text = text.replace("<vendor>cornerstream<", "")
        assert "cornerstream" not in text, name


def test_another_package_replaces_the_first() -> None:
    run("package", "-o", "ip", *SIZE)
    manifest = json.loads(Path("ip", MANIFEST).read_text())
    manifest["files"] += ["rtl/gone.v", "../outside.v"]
    Path("ip", MANIFEST).write_text(json.dumps(manifest))
    for name in ("ip/rtl/gone.v", "ip/rtl/mine.v", "outside.v"):
        Path(name).write_text("module gone; endmodule\n")
    run("package", "-o", "ip", *SIZE, "--interface", "avalon")
    found = contents(Path("ip"))
    assert found.pop("rtl/mine.v") and Path("outside.v").exists()
    assert found == package_files(Build(max_width=40, max_height=32), "avalon", "cornerstream")


def test_a_foreign_folder_is_left_alone() -> None:
    Path("mine").mkdir()
    Path("mine/thesis.tex").write_text("years of work")
    # a project for Quartus is not a package either
    Path("mine/cornerstream.json").write_text('{"files": []}')
    before = contents(Path("mine"))
    result = run("package", "-o", "mine", *SIZE, code=2)
    assert (
        "mine holds files that are not an earlier package; allowed: an empty or a new folder" in result.stderr
    )
    assert contents(Path("mine")) == before
    run("package", "-o", "mine", *SIZE, "--force")
    assert before.items() <= contents(Path("mine")).items()
    assert Path("mine/cornerstream.core").is_file()


def test_nothing_is_half_written(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    replace, calls = os.replace, 0

    def full(source: Any, target: Any) -> None:
        nonlocal calls
        calls += 1
        if calls > 5:
            raise OSError(28, "No space left on device")
        replace(source, target)

    monkeypatch.setattr(os, "replace", full)
    result = run("package", "-o", "ip", *SIZE, code=2)
    assert calls > 5 and "No space left on device" in result.stderr
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--interface", "stream"), "'stream' is not one of 'axi', 'avalon'"),
        (("--max-width", "12"), "max_width is 12; allowed: whole numbers from 13"),
        (("--fit", "printed"), "fit is 'printed', which only the golden model has"),
        (("-o", "file"), "file is not a folder"),
        (
            ("--name", "a__b"),
            "name is 'a__b'; allowed: a letter, then letters, digits and single underscores",
        ),
    ],
)
def test_bad_input(options: tuple[str, ...], message: str, folder: Path) -> None:
    Path("file").touch()
    result = run("package", "-o", "ip", *SIZE, *options, code=2)
    assert message in result.stderr
    assert [path.name for path in folder.iterdir()] == ["file"]


@pytest.mark.filterwarnings("ignore::amaranth.hdl.UnusedElaboratable")
def test_there_is_no_video_out_with_avalon(folder: Path) -> None:
    options = ("--interface", "avalon", "--video-out")
    message = run("package", "-o", "ip", *SIZE, *options, code=2).stderr
    assert "video_out is True; allowed with Avalon edges: False" in message
    assert list(folder.iterdir()) == []
    # the core that was refused is missed by Amaranth as soon as it is gone: here, not in some later
    # test
    gc.collect()
