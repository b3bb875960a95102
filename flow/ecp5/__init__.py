"""What ECP5's block RAM offers and Yosys does not use: output registers, and freedom about simultaneous accesses.

Cyclone IV's M9K has both, and Quartus uses them; without them the stand-in would be slow where the device is not.
"""

from __future__ import annotations

import re
from typing import Any

from flow.verilog import without_zeros

Module = dict[str, Any]
Bit = int | str

SCRIPT = """
read_rtlil design.il
synth_ecp5 -top {top} -run begin:map_ram
memory_libmap -lib memory.txt t:$mem_v2 r:WR_PORTS>0 %i r:SIZE>64 %i
techmap -map memory.v
synth_ecp5 -top {top} -run map_ram:
write_json mapped.json
"""
"""From ``design.il`` to ``mapped.json``, with the files :data:`RULES` beside."""
RULES = ("memory.txt", "memory.v")

_COLLISION = re.compile(r"(parameter \\COLLISION_X_MASK \d+')([01]+)")
_PORTS = {"A": [f"DOA{k}" for k in range(18)], "B": [f"DOB{k}" for k in range(18)]}


def relaxed(design: str) -> str:
    """RTLIL in which memories start with anything, and a read of what is being written may give anything.

    For timing only: no result depends on such reads (a test gives them noise), but Yosys would put multiplexers
    behind wide memories to make them right on this device.
    """
    return _COLLISION.sub(lambda match: match[1] + "1" * len(match[2]), without_zeros(design))


def use_output_registers(module: Module) -> int:
    """Move flip-flops that take nothing but the output of a block RAM into it; returns how many.

    All outputs in use must go to one flip-flop each, with the same clock enable and no reset.
    """
    cells: dict[str, Any] = module["cells"]
    sinks = _sinks(module)
    moved = 0
    for ram in [cell for cell in cells.values() if cell["type"] == "DP16KD"]:
        outputs = {
            name: ram["connections"][name][0]
            for names in _PORTS.values()
            for name in names
            if name in ram["connections"] and sinks.get(ram["connections"][name][0])
        }
        registers = {name: _register(cells, sinks[bit]) for name, bit in outputs.items()}
        enables = {_enable(cells[cell]) for cell in registers.values() if cell}
        if not registers or None in registers.values() or len(enables) != 1:
            continue
        (enable,) = enables
        for name, cell in registers.items():
            assert cell is not None
            ram["connections"][name] = cells.pop(cell)["connections"]["Q"]
        for port, names in _PORTS.items():
            if any(name in registers for name in names):
                ram["parameters"][f"REGMODE_{port}"] = "OUTREG"
                ram["connections"][f"OCE{port}"] = [enable]
        moved += len(registers)
    return moved


def _sinks(module: Module) -> dict[Bit, list[tuple[str, str]]]:
    """Who reads each net: (cell, port), or ("", port) for the module's own outputs."""
    sinks: dict[Bit, list[tuple[str, str]]] = {}
    for name, cell in module["cells"].items():
        for port, bits in cell["connections"].items():
            if cell["port_directions"][port] != "output":
                for bit in bits:
                    sinks.setdefault(bit, []).append((name, port))
    for name, port in module["ports"].items():
        for bit in port["bits"]:
            sinks.setdefault(bit, []).append(("", name))
    return sinks


def _register(cells: dict[str, Any], readers: list[tuple[str, str]]) -> str | None:
    """The one flip-flop without reset that reads a net, if it is its only reader."""
    if len(readers) != 1 or readers[0][1] != "DI":
        return None
    name = readers[0][0]
    return name if cells[name]["connections"].get("LSR", ["0"]) == ["0"] else None


def _enable(cell: dict[str, Any]) -> Bit:
    enable: Bit = cell["connections"]["CE"][0] if cell["parameters"].get("CEMUX") == "CE" else "1"
    return enable
