# amaranth: UnusedElaboratable=no
"""The Quartus project, as far as it can be checked without Quartus."""

from __future__ import annotations

import json
import os
import re
import subprocess
from pathlib import Path
from typing import Any

import pytest
from amaranth.build import Clock, Pins, Resource
from amaranth.hdl import Elaboratable, Module
from amaranth.lib import io
from amaranth.vendor import AlteraPlatform

from flow.devices import DEFAULT_DEVICE, DEVICES, find_device
from flow.quartus import project_files
from flow.quartus.project import MANIFEST
from flow.verilog_ports import ports_of
from hdl.build import Build
from hdl.detector import Detector
from hdl.identifiers import plain_port
from sim.ports import signals
from sim.verilator import verilator_root
from tests.support.quartus import SMALL, VARIANTS, exported, settings, sources


@pytest.mark.parametrize(("name", "buffering"), VARIANTS)
def test_sources_are_verilog_2001(tmp_path: Path, name: str, buffering: Any) -> None:
    files = sources(exported(name, buffering))
    for path, text in files.items():
        (tmp_path / Path(path).name).write_text(text)
        # readable: one module per file, of its name, no escaped names, no products
        assert re.findall(r"^module (\w+)\(", text, re.MULTILINE) == [Path(path).stem]
        assert "\\" not in text and " * " not in text and "$mul" not in text
        assert text.startswith(f"// {Path(path).stem}: ") and "//   max_width = 40\n" in text
    root = verilator_root()
    # what all generated Verilog has; none of these is an error in any tool
    waived = ("PROCASSINIT",)
    done = subprocess.run(
        [
            *(str(root / "bin" / "verilator_bin"), "--lint-only", "--language", "1364-2001", "-Wall"),
            *("--quiet", "--top-module", "cornerstream", *(f"-Wno-{name}" for name in waived)),
            *(str(tmp_path / Path(path).name) for path in files),
        ],
        env={**os.environ, "VERILATOR_ROOT": str(root)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stderr) == (0, "")


def test_multipliers_are_products_that_are_told_of() -> None:
    build = Build.profile("robust", **SMALL, multipliers=4)
    files = project_files(build, DEVICES[DEFAULT_DEVICE], clock_mhz=125)
    assert sum(text.count(" * ") for text in sources(files).values()) == 4
    told = "multiplier, no PLL, and no vendor's primitive"
    assert told not in files["README.md"] and "squares are products" in files["README.md"]
    assert told in exported("robust", "lean")["README.md"]


@pytest.mark.parametrize(("name", "buffering"), VARIANTS)
def test_settings_list_what_there_is(name: str, buffering: Any) -> None:
    files = exported(name, buffering)
    found = settings(files)
    assert ("FAMILY", "Cyclone IV GX") in found and ("DEVICE", "EP4CGX150CF23C8") in found
    assert ("TOP_LEVEL_ENTITY", "cornerstream") in found
    assert ("VERILOG_INPUT_VERSION", "VERILOG_2001") in found
    listed = [value for key, value in found if key in ("VERILOG_FILE", "SDC_FILE")]
    assert sorted(listed) == sorted([*sources(files), "cornerstream.sdc"])
    assert json.loads(files[MANIFEST])["files"] == sorted(files)


def test_virtual_pins_are_the_ports_of_the_component() -> None:
    detector = Detector(Build.profile("paper", **SMALL))
    expected = {"rst"}
    for port in signals(detector):
        bits = len(port)
        name = plain_port(port.name)
        expected |= {name} if bits == 1 else {f"{name}[{bit}]" for bit in range(bits)}
    qsf = exported("paper", "banked")["cornerstream.qsf"]
    pins = re.findall(r"^set_instance_assignment -name VIRTUAL_PIN ON -to (\S+)$", qsf, re.MULTILINE)
    assert len(pins) == len(set(pins)) and set(pins) == expected
    ports = ports_of(exported("paper", "banked")["rtl/cornerstream.v"])
    assert {pin for port in ports for pin in port.pins} == expected | {"clk"}


class Blinker(Elaboratable):
    """The least that Amaranth makes a project of."""

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.led = led = io.Buffer("o", platform.request("led", dir="-"))
        m.d.sync += led.o.eq(~led.o)
        return m


class Board(AlteraPlatform):
    device, package, speed, suffix = "EP4CGX150C", "F23", "C8", ""
    default_clk = "clk"
    resources = (
        Resource("clk", 0, Pins("A1", dir="i"), Clock(125e6)),
        Resource("led", 0, Pins("B1", dir="o")),
    )
    connectors = ()


def amaranths_project() -> dict[str, str]:
    """The same kind of project as Amaranth writes it for the same device."""
    plan = Board().build(Blinker(), name="cornerstream", do_build=False)
    return {
        name: content if isinstance(content, str) else content.decode()
        for name, content in plan.files.items()
    }


def test_settings_are_in_the_form_that_amaranth_writes() -> None:
    theirs = dict(settings(amaranths_project()))
    ours = dict(settings(exported("paper", "banked")))
    for name in ("DEVICE", "TOP_LEVEL_ENTITY"):
        assert ours[name] == theirs[name]
    assert "VERILOG_FILE" in theirs and theirs["DEVICE"] == "EP4CGX150CF23C8"


class Tcl:
    """A Tcl interpreter whose unknown commands are Quartus', recorded instead of run."""

    def __init__(self, commands: tuple[str, ...], failing: tuple[str, ...] = ()) -> None:
        self.interpreter = pytest.importorskip("tkinter").Tcl()
        self.calls: list[tuple[str, ...]] = []
        for command in commands:

            def record(*arguments: str, command: str = command) -> str:
                self.calls.append((command, *arguments))
                if command in failing:
                    raise RuntimeError(f"{command} failed")
                return f"<{' '.join((command, *arguments))}>"

            self.interpreter.createcommand(command, record)

    def run(self, path: Path) -> list[tuple[str, ...]]:
        self.interpreter.call("source", str(path))
        return self.calls


SDC_COMMANDS = (
    *("create_clock", "derive_clock_uncertainty", "set_false_path"),
    *("get_ports", "all_inputs", "all_outputs", "remove_from_collection"),
)


def test_constraints_run_and_name_the_clock_as_amaranth_does(tmp_path: Path) -> None:
    clocks = []
    texts = (exported("paper", "banked")["cornerstream.sdc"], amaranths_project()["cornerstream.sdc"])
    for number, text in enumerate(texts):
        path = tmp_path / f"{number}.sdc"
        path.write_text(text.replace("clk_0__io", "clk"))
        calls = Tcl(SDC_COMMANDS).run(path)
        (clock,) = (call for call in calls if call[0] == "create_clock")
        clocks.append([*clock[:4], float(clock[4]), *clock[5:]])
    assert clocks[0] == clocks[1]
    assert clocks[0][4] == 8.0


SCRIPT_COMMANDS = ("load_package", "project_open", "execute_flow", "project_close", "puts", "exit")


def test_script_compiles_and_prints_both_summaries(tmp_path: Path) -> None:
    script = tmp_path / "compile.tcl"
    script.write_text(exported("paper", "banked")["compile.tcl"])
    (tmp_path / "output_files").mkdir()
    for kind in ("fit", "sta"):
        (tmp_path / "output_files" / f"cornerstream.{kind}.summary").write_text(f"the {kind} summary")
    before = os.getcwd()
    try:
        calls = Tcl(SCRIPT_COMMANDS).run(script)
    finally:
        os.chdir(before)
    assert calls == [
        ("load_package", "flow"),
        ("project_open", "-revision", "cornerstream", "cornerstream"),
        ("execute_flow", "-compile"),
        ("project_close",),
        ("puts", "the fit summary"),
        ("puts", "the sta summary"),
    ]


def test_script_fails_when_the_compilation_does(tmp_path: Path) -> None:
    script = tmp_path / "compile.tcl"
    script.write_text(exported("paper", "banked")["compile.tcl"])
    before = os.getcwd()
    try:
        tcl = Tcl(SCRIPT_COMMANDS, failing=("execute_flow", "exit"))
        with pytest.raises(pytest.importorskip("tkinter").TclError):
            tcl.run(script)
    finally:
        os.chdir(before)
    assert ("project_close",) in tcl.calls and tcl.calls[-1] == ("exit", "1")


def test_clock_must_be_positive() -> None:
    for clock in (0, -1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match=r"clock is .*; allowed: MHz, more than 0"):
            project_files(Build.profile("paper", **SMALL), DEVICES[DEFAULT_DEVICE], clock_mhz=clock)


def test_another_device_is_named_wherever_quartus_and_readers_look() -> None:
    files = project_files(Build.profile("paper", **SMALL), find_device("EP4CE115F29C7"))
    found = settings(files)
    assert ("FAMILY", "Cyclone IV E") in found and ("DEVICE", "EP4CE115F29C7") in found
    assert "EP4CE115F29C7" in files["README.md"] and "--device EP4CE115F29C7" in files["README.md"]
    assert json.loads(files[MANIFEST])["device"] == "EP4CE115F29C7"
    assert "--device" not in exported("paper", "banked")["README.md"]
    # the core itself is the same
    assert sources(files) == sources(exported("paper", "banked"))


def test_devices_that_quartus_does_not_know_are_refused() -> None:
    with pytest.raises(ValueError, match=r"device is 'lfe5u-45f'; allowed: ep4ce6, .*, ep4cgx150$"):
        project_files(Build.profile("paper", **SMALL), find_device("lfe5u-45f"))
