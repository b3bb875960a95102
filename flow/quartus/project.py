"""The folder for Quartus: Verilog, project, constraints, and one script that compiles it."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

from flow.command import command
from flow.device import Device, MemoryBlock
from flow.devices import device_names
from flow.quartus.memories import Memory, find_memories, with_attributes
from flow.templates import render
from flow.verilog import END_OF_WAIVERS, MODULE, emit_verilog
from flow.verilog_ports import ports_of, split_modules
from golden.version import VERSION
from hdl.build import Build

MANIFEST = "cornerstream.json"
"""The file that marks a folder as exported; it says what was built, and lists the files."""
SOURCES = "rtl"

_TEMPLATES = Path(__file__).parent / "templates"
_PROJECT = ("{}.qpf", "{}.qsf", "{}.sdc", "compile.tcl", "README.md")


def project_files(
    build: Build, device: Device, *, clock_mhz: float = 100.0, name: str = MODULE
) -> dict[str, str]:
    """All files of the Quartus project, by path relative to its folder.

    Parameters
    ----------
    build
        The detector.
    device
        One that Quartus knows.
    clock_mhz
        Clock frequency that Quartus is asked to reach; the .sdc file has it as a period.
    name
        Name of the core and of the project.

    Raises
    ------
    ValueError
        The clock is not a positive number, Quartus does not know the device, there is no such
        detector in hardware, or the core cannot be called so.
    flow.verilog.VerilogError
        Yosys refused the design.
    """
    if not 0 < clock_mhz < 1e5:
        raise ValueError(f"clock is {clock_mhz!r}; allowed: MHz, more than 0 and less than 100000")
    if device.tool != "quartus":
        raise ValueError(f"device is {device.name!r}; allowed: {', '.join(device_names(['quartus']))}")
    heading, modules = split_modules(emit_verilog(build, name=name))
    sources = {
        f"{SOURCES}/{module}.v": _title(heading, module, name)
        + with_attributes(body, device.memory)
        + END_OF_WAIVERS
        for module, body in modules.items()
    }
    memories = [memory for module, body in modules.items() for memory in find_memories(module, body)]
    ports = ports_of(modules[name])
    facts: dict[str, Any] = {
        "clock_mhz": clock_mhz,
        "device": device.part,
        "family": device.family,
        "manifest": MANIFEST,
        "memories": _grouped(memories, device.memory),
        "memory_bits": sum(memory.bits for memory in memories),
        "modules": sorted(modules),
        "command": command("quartus export", build, device=device.part, clock=clock_mhz, name=name),
        "name": name,
        "parameters": build.as_dict(),
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
        "parameters": build.as_dict(),
        "clock_mhz": float(clock_mhz),
        "device": device.part,
        "files": sorted([*files, MANIFEST]),
    }
    return files | {MANIFEST: json.dumps(manifest, indent=2) + "\n"}


def _title(heading: str, module: str, name: str) -> str:
    if module == name:
        return heading
    _, _, rest = heading.partition("\n")
    return f"// {module}: a block of {name}, the streaming corner detector\n{rest}"


def _grouped(memories: list[Memory], block: MemoryBlock) -> list[dict[str, Any]]:
    # banks of one buffer differ in name only
    groups: dict[Memory, list[str]] = {}
    for memory in memories:
        groups.setdefault(replace(memory, name=""), []).append(memory.name)
    return [
        asdict(one) | {"names": names, "attribute": one.attribute(block)} for one, names in groups.items()
    ]
