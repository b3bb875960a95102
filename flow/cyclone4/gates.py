"""Gate-level simulation: the mapped netlist and the behaviour of its cells, under Verilator."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from flow.cyclone4.synthesis import Synthesis, synthesize
from flow.rules import rule_text
from hdl.build import Build
from hdl.detector import Detector
from sim.engine import Engine
from sim.engines import make_engine


def gate_level_verilog(synthesis: Synthesis) -> str:
    """The netlist, and before it our own models of the cells that it is made of."""
    return rule_text("cyclone4", "cells.v") + "\n" + synthesis.verilog


def gate_level_engine(
    build: Build,
    *,
    notify: Callable[[str], None] | None = None,
    cache: str | Path | None = None,
) -> Engine:
    """An engine for a detector mapped to Cyclone IV: about 200,000 clocks per second.

    Raises
    ------
    ToolNotFoundError, ToolError, VerilatorNotFoundError
        Yosys is missing or fails, or Verilator is missing.
    """
    if notify is not None:
        notify("mapping the design to Cyclone IV")
    verilog = gate_level_verilog(synthesize(build))
    with TemporaryDirectory(prefix="cornerstream-") as folder:
        path = Path(folder) / "gates.v"
        path.write_text(verilog, encoding="utf-8")
        engine = make_engine("verilog", Detector(build), verilog=path, notify=notify, cache=cache)
    engine.name = engine.name.replace("verilog", "gates", 1)
    return engine
