"""Paths without a register through a design, found in its netlist, so for all inputs."""

from __future__ import annotations

import json
import re
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

from amaranth.back import rtlil

from flow.yowasp import run_yosys

_TO_GATES = """
read_rtlil design.il
hierarchy -top top
proc
flatten
opt_clean
memory_collect
simplemap
opt_clean
write_json design.json
"""
_FLIP_FLOP = re.compile(r"\$_(S|AL)?D?FF.*_|\$(s|a|al)?dffs?r?e?")
_CHECKS = ("$check", "$print", "$scopeinfo")
Net = int


def combinational_paths(component: Any) -> dict[str, set[str]]:
    """For each output port that some input port can change within the clock: these inputs, by name.

    An output of a cell counts as depending on all of its inputs, so the answer errs on the side of
    paths only.
    """
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "design.il").write_text(rtlil.convert(component, name="top"), encoding="utf-8")
        run_yosys(_TO_GATES, folder)
        netlist = json.loads((folder / "design.json").read_text(encoding="utf-8"))
    top = netlist["modules"]["top"]
    drivers = _drivers(top["cells"].values())
    ports = top["ports"]
    given = {
        bit: name for name, port in ports.items() if port["direction"] == "input" for bit in port["bits"]
    }
    paths = {}
    for name, port in ports.items():
        if port["direction"] == "output":
            cone = _cone(port["bits"], drivers)
            if reached := {given[net] for net in cone if net in given}:
                paths[name] = reached
    return paths


def _drivers(cells: Any) -> dict[Net, set[Net]]:
    """What the value of each net that a cell drives depends on in the same clock."""
    drivers: dict[Net, set[Net]] = defaultdict(set)
    for cell in cells:
        if cell["type"] in _CHECKS or _FLIP_FLOP.fullmatch(cell["type"]):
            continue
        if cell["type"].startswith("$mem"):
            assert set(cell["parameters"]["RD_CLK_ENABLE"]) == {"1"}, "a memory is read without a clock"
            continue
        pins: dict[str, set[Net]] = {"input": set(), "output": set()}
        for port, bits in cell["connections"].items():
            pins[cell["port_directions"][port]].update(bit for bit in bits if isinstance(bit, int))
        for net in pins["output"]:
            drivers[net] |= pins["input"]
    return drivers


def _cone(bits: list[Net | str], drivers: dict[Net, set[Net]]) -> set[Net]:
    """All nets that these depend on, themselves included."""
    cone: set[Net] = set()
    found = [bit for bit in bits if isinstance(bit, int)]
    while found:
        net = found.pop()
        if net not in cone:
            cone.add(net)
            found += drivers.get(net, ())
    return cone
