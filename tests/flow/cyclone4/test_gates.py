"""The mapped netlist on a photograph, in Verilator: every record is the golden model's."""

from __future__ import annotations

import re
from collections import Counter
from functools import cache

import pytest

from flow.cyclone4.gates import gate_level_verilog
from flow.cyclone4.synthesis import Synthesis, synthesize
from golden import Settings, StreamModel
from hdl.build import Buffering, Build
from hdl.detector import Detector
from sim import Stalls, compare, make_engine, simulate_frames, summarize
from sim.compiler import FLAGS_VARIABLE
from tests.support.builds import each
from tests.support.photographs import photograph

WIDTH, HEIGHT = 96, 64
SETTINGS = Settings(sigma1=0.01, sigma2=0.2, report_rejected=True)


@cache
def synthesized(buffering: Buffering) -> Synthesis:
    return synthesize(Build.profile("paper", max_width=WIDTH, max_height=HEIGHT, buffering=buffering))


@pytest.mark.slow
@each("buffering", {name: name for name in ("lean", "banked")}, quick=[])
def test_netlist_is_bit_exact_on_a_photograph(
    buffering: Buffering, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> None:
    # optimized, so many gates take a minute to compile, and these frames a second
    monkeypatch.setenv(FLAGS_VARIABLE, "-O0")
    synthesis = synthesized(buffering)
    parameters = synthesis.build
    path = tmp_path_factory.mktemp("gates") / "gates.v"
    path.write_text(gate_level_verilog(synthesis))
    engine = make_engine("verilog", Detector(parameters), verilog=path)
    region = photograph("camera")[200 : 200 + HEIGHT, 150 : 150 + WIDTH]
    # back to back, so that the second frame's thresholds come from the first; then one of another
    # size
    frames = [(region, SETTINGS), (region, SETTINGS), (region[:50, 20:91], SETTINGS)]
    model = StreamModel(parameters)
    expected = [model.process(*frame).records for frame in frames]
    assert all(len(records) > 10 for records in expected)
    for stalls in (Stalls(), Stalls(inputs=0.3, outputs=0.4, seed=3)):
        result = simulate_frames(engine, frames, parameters, stalls=stalls)
        assert summarize(compare(result, expected)) == ""


def test_netlist_is_what_was_counted() -> None:
    synthesis = synthesized("lean")
    modules = set(re.findall(r"^module (\S+)", synthesis.verilog, re.MULTILINE))
    instances = re.findall(r"^  ([\w\\$.]+) (?:#\(|\S+ +\()", synthesis.verilog, re.MULTILINE)
    found = Counter(kind for kind in instances if kind not in modules)
    total = synthesis.total
    assert found == {"cycloneiv_lcell_comb": total.lut4, "dffeas": total.ff, "altsyncram": total.m9k}
    assert sum(area.lut4 for area in synthesis.blocks.values()) == total.lut4
    assert total.le_lower <= total.le_packed <= total.le_upper
    assert total.multipliers == 0
