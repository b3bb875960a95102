"""The netlist for Cyclone IV with AXI edges, with the same bus models as its Verilog."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import pytest

from flow.cyclone4.gates import gate_level_verilog
from flow.cyclone4.synthesis import synthesize
from sim.cocotb_bench import Bench, build_bench, check
from tests.benches.axi import environment
from tests.hdl.edges.test_axi_cocotb import BUILDS, FRAMES

PARAMETERS = BUILDS["robust-lean"]


@cache
def bench() -> Bench:
    return build_bench(gate_level_verilog(synthesize(PARAMETERS, "axi")), notify=lambda text: None)


@pytest.mark.verify
@pytest.mark.xdist_group("netlist")
@pytest.mark.parametrize("module", ["stress", "malformed"])
def test_netlist(module: str, tmp_path: Path, record_property: pytest.RecordProperty) -> None:
    settings = environment(PARAMETERS, ROUNDS=1, FRAMES=FRAMES)
    results = bench().run(
        f"tests.benches.bench_axi_{module}", folder=tmp_path, environment=settings, timeout=1800
    )
    check(results)
    clocks, seconds = sum(result.clocks for result in results), sum(result.seconds for result in results)
    text = (
        f"netlist robust-lean {module}: {len(results)} tests, {clocks / 1000:.0f} k clocks, {seconds:.0f} s"
    )
    record_property("verify", text)
