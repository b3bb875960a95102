"""The folder that an engineer opens with Quartus: Verilog, project, constraints, and one script
that compiles it.
"""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from flow.command import command
from flow.quartus.memories import Memory, find_memories, with_attributes
from flow.templates import render
from flow.verilog import END_OF_WAIVERS, MODULE, emit_verilog
from flow.verilog_ports import ports_of, split_modules
from golden.version import VERSION
from hdl.build import Build

FAMILY = "Cyclone IV GX"
DEVICE = "EP4CGX150CF23C8"
"""The paper's device."""
MANIFEST = "cornerstream.json"
"""By this file a folder is known as exported: what was built, and the files that belong to it."""
SOURCES = "rtl"

_TEMPLATES = Path(__file__).parent / "templates"
_PROJECT = ("{}.qpf", "{}.qsf", "{}.sdc", "compile.tcl", "README.md")


def project_files(parameters: Build, *, clock_mhz: float = 100.0, name: str = MODULE) -> dict[str, str]:
    """All files of the Quartus project, by path relative to its folder.

    Parameters
    ----------
    parameters
        The detector.
    clock_mhz
        The clock that is asked for; it stands in the .sdc as a period, and nowhere else.
    name
        Of the core and the project.

    Raises
    ------
    ValueError
        The clock is no positive number, the parameters are not to be built, or the core cannot be
        called so.
    flow.verilog.VerilogError
        Yosys refused the design.
    """
    if not 0 < clock_mhz < 1e5:
        raise ValueError(f"clock is {clock_mhz!r}; allowed: MHz, more than 0 and less than 100000")
    heading, modules = split_modules(emit_verilog(parameters, name=name))
    sources = {
        f"{SOURCES}/{module}.v": _title(heading, module, name) + with_attributes(body) + END_OF_WAIVERS
        for module, body in modules.items()
    }
    memories = [memory for module, body in modules.items() for memory in find_memories(module, body)]
    ports = ports_of(modules[name])
    facts: dict[str, Any] = {
        "clock_mhz": clock_mhz,
        "device": DEVICE,
        "family": FAMILY,
        "manifest": MANIFEST,
        "memories": _grouped(memories),
        "memory_bits": sum(memory.bits for memory in memories),
        "modules": sorted(modules),
        "command": command("quartus export", parameters, clock=clock_mhz, name=name),
        "name": name,
        "parameters": parameters.as_dict(),
        "period": 1000 / clock_mhz,
        "ports": ports,
        "sources": sorted(sources),
        "version": VERSION,
        "virtual_pins": [pin for port in ports if port.name != "clk" for pin in port.pins],
    }
    files = sources | {file.format(name): render(_TEMPLATES, file.format(MODULE), facts) for file in _PROJECT}
    manifest = {
        "generator": f"cornerstream {VERSION}",
        "amaranth": version("amaranth"),
        "name": name,
        "parameters": parameters.as_dict(),
        "clock_mhz": float(clock_mhz),
        "device": DEVICE,
        "files": sorted([*files, MANIFEST]),
    }
    return files | {MANIFEST: json.dumps(manifest, indent=2) + "\n"}


def _title(heading: str, module: str, name: str) -> str:
    if module == name:
        return heading
    _, _, rest = heading.partition("\n")
    return f"// {module}: a block of {name}, the streaming corner detector\n{rest}"


def _grouped(memories: list[Memory]) -> list[dict[str, Any]]:
    # banks of one buffer differ in name only
    groups: dict[Memory, list[str]] = {}
    for memory in memories:
        groups.setdefault(replace(memory, name=""), []).append(memory.name)
    return [asdict(one) | {"names": names, "attribute": one.attribute} for one, names in groups.items()]
