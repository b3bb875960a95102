# amaranth: UnusedElaboratable=no
"""Every output of the cores is a register: no input reaches one within a clock."""

from __future__ import annotations

from typing import Any

import pytest

import hdl.edges.avalon
import hdl.edges.axi
import hdl.edges.core
import hdl.edges.video_detector
import hdl.parts.stream
from hdl.build import Build
from tests.formal.design import variant
from tests.formal.paths import combinational_paths

SMALL = {"max_width": 32, "max_height": 32}
CORES = {
    "AXI": lambda: hdl.edges.axi.AxiCore(Build.profile("paper", **SMALL)),
    "AXI with pixels": lambda: hdl.edges.axi.AxiCore(Build.profile("paper", **SMALL, video_out=True)),
    "Avalon": lambda: hdl.edges.avalon.AvalonCore(Build.profile("paper", **SMALL)),
}


@pytest.mark.parametrize("core", CORES.values(), ids=CORES)
def test_no_input_of_a_core_reaches_an_output_within_a_clock(core: Any) -> None:
    assert combinational_paths(core()) == {}


def test_no_input_of_a_skid_buffer_reaches_an_output_within_a_clock() -> None:
    assert combinational_paths(hdl.parts.stream.SkidBuffer(4)) == {}


def test_a_path_from_ready_to_ready_is_found() -> None:
    wrong = variant(hdl.parts.stream, {"self.i.ready.eq(ready)": "self.i.ready.eq(ready & self.o.ready)"})
    assert combinational_paths(wrong.SkidBuffer(4)) == {"i__ready": {"o__ready"}}


def test_paths_deep_in_a_core_are_found(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without the skid buffer at its input."""
    skid = "self._skid.i)\n        wiring.connect(m, self._skid.o, guard.i)"
    wrong = variant(hdl.edges.video_detector, {skid: "guard.i)"})
    monkeypatch.setattr(hdl.edges.core, "VideoDetector", wrong.VideoDetector)
    paths = combinational_paths(hdl.edges.axi.AxiCore(Build.profile("paper", **SMALL)))
    assert paths.keys() == {"s_axis_tready"}
    # no valid reaches it, but marks do
    assert paths["s_axis_tready"] == {"s_axis_tuser", "s_axis_tlast"}
