"""The netlist for Cyclone IV with AXI edges, with the same bus models as its Verilog."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from flow.cyclone4.gates import gate_level_verilog
from flow.cyclone4.synthesis import synthesize
from hdl.build import Build
from sim.cocotb_bench import Bench, build_bench, check
from tests.benches.axi import environment
from tests.hdl.edges.test_axi_cocotb import BUILDS, FRAMES

NETLISTS = {
    "robust-lean": (BUILDS["robust-lean"], ("stress", "malformed")),
    "robust-4": (
        Build.profile("robust", pixels_per_clock=4, max_width=96, max_height=24),
        ("stress", "malformed", "lanes"),
    ),
}


@cache
def bench(build: str) -> Bench:
    netlist = synthesize(NETLISTS[build][0], "axi")
    return build_bench(gate_level_verilog(netlist), notify=lambda text: None)


@pytest.mark.verify
@pytest.mark.parametrize(
    ("build", "module"),
    [
        pytest.param(build, module, marks=pytest.mark.xdist_group(f"netlist {build}"), id=f"{build}-{module}")
        for build, (_, modules) in NETLISTS.items()
        for module in modules
    ],
)
def test_netlist(build: str, module: str, tmp_path: Path, record_property: pytest.RecordProperty) -> None:
    settings = environment(NETLISTS[build][0], ROUNDS=1, FRAMES=FRAMES)
    results = bench(build).run(
        f"tests.benches.bench_axi_{module}", folder=tmp_path, environment=settings, timeout=1800
    )
    check(results)
    clocks, seconds = sum(result.clocks for result in results), sum(result.seconds for result in results)
    text = f"netlist {build} {module}: {len(results)} tests, {clocks / 1000:.0f} k clocks, {seconds:.0f} s"
    record_property("verify", text)
