# amaranth: UnusedElaboratable=no
"""The mapped netlist on a photograph, in Verilator: every record is the golden model's.

Of every profile, also with four pixels per clock, and of the divider alone, whose table is the
narrowest memory with contents.
"""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from flow.cyclone4.gates import gate_level_verilog
from flow.cyclone4.synthesis import Synthesis, map_component, synthesize
from flow.rules import rule_text
from golden import Settings, StreamModel
from hdl.build import Buffering, Build
from hdl.detector import Detector
from hdl.table_divider import TableDivider
from sim import Stalls, compare, make_engine, simulate_frames, summarize
from sim.compiler import FLAGS_VARIABLE
from tests.hdl.test_candidate_ring import Windows, check_windows
from tests.support.blocks import packed, run
from tests.support.builds import each
from tests.support.dividing import FORMATS, Dividing, Format, operands, quotients
from tests.support.photographs import photograph

WIDTH, HEIGHT = 96, 64
BUILDS: dict[str, tuple[str, Buffering, int]] = {
    "lean": ("paper", "lean", 1),
    "banked": ("paper", "banked", 1),
    "robust": ("robust", "lean", 1),
    "precise": ("precise", "lean", 1),
    "paper, P=4": ("paper", "banked", 4),
    "robust, P=4": ("robust", "lean", 4),
}


@cache
def synthesized(name: str, buffering: Buffering, lanes: int) -> Synthesis:
    size = {"max_width": WIDTH, "max_height": HEIGHT}
    return synthesize(Build.profile(name, **size, buffering=buffering, pixels_per_clock=lanes))


@pytest.mark.slow
@each("build", BUILDS, quick=[])
def test_netlist_is_bit_exact_on_a_photograph(
    build: tuple[str, Buffering, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # optimized, so many gates take a minute to compile, and these frames a second
    monkeypatch.setenv(FLAGS_VARIABLE, "-O0")
    synthesis = synthesized(*build)
    parameters = synthesis.build
    settings = Settings(sigma1=0.01, report_rejected=True)
    if parameters.algorithm.texture != "none":
        settings = replace(settings, sigma2=0.2)
    path = tmp_path / "gates.v"
    path.write_text(gate_level_verilog(synthesis))
    engine = make_engine("verilog", Detector(parameters), verilog=path)
    region = photograph("camera")[200 : 200 + HEIGHT, 150 : 150 + WIDTH]
    # back to back, so that the second frame's thresholds come from the first; then one of another
    # size
    frames = [(region, settings), (region, settings), (region[:50, 20:91], settings)]
    model = StreamModel(parameters)
    expected = [model.process(*frame).records for frame in frames]
    assert all(len(records) > 5 for records in expected)
    for stalls in (Stalls(), Stalls(inputs=0.3, outputs=0.4, seed=3)):
        result = simulate_frames(engine, frames, parameters, stalls=stalls)
        assert summarize(compare(result, expected)) == ""


def test_netlist_is_what_was_counted() -> None:
    synthesis = synthesized("paper", "lean", 1)
    modules = set(re.findall(r"^module (\S+)", synthesis.verilog, re.MULTILINE))
    instances = re.findall(r"^  ([\w\\$.]+) (?:#\(|\S+ +\()", synthesis.verilog, re.MULTILINE)
    found = Counter(kind for kind in instances if kind not in modules)
    total = synthesis.total
    assert found == {"cycloneiv_lcell_comb": total.lut4, "dffeas": total.ff, "altsyncram": total.m9k}
    assert sum(area.lut4 for area in synthesis.blocks.values()) == total.lut4
    assert total.le_lower <= total.le_packed <= total.le_upper
    assert total.multipliers == 0


@pytest.mark.parametrize("form", FORMATS.values(), ids=FORMATS)
def test_divider_finds_its_reciprocals_in_block_ram(form: Format, tmp_path: Path) -> None:
    divider = TableDivider(*form)
    tree, netlist = map_component(Dividing("table", *form), "dividing")
    assert tree.area.memory_bits == divider.memory_bits
    path = tmp_path / "gates.v"
    path.write_text(rule_text("cyclone4", "cells.v") + netlist)
    runner = make_engine("verilog", Dividing("table", *form), verilog=path)
    beats = quotients("table", form, *operands(form, 3000))
    given, expected = (packed((Dividing, "table", *form), each_way) for each_way in beats)
    run(runner, given, expected, Stalls(inputs=0.3, outputs=0.4, seed=3), clocks=divider.clocks + 1)


@pytest.mark.verify
def test_candidates_of_four_pixels_per_clock(tmp_path: Path) -> None:
    """Their queue, and the ring that their windows are read from: memories with registers."""
    build = Build.profile("paper", pixel_bits=4, pixels_per_clock=4)
    _, netlist = map_component(Windows(build), "windows")
    path = tmp_path / "netlist.v"
    path.write_text(rule_text("cyclone4", "cells.v") + netlist)
    check_windows(build, make_engine("verilog", Windows(build), verilog=path))
