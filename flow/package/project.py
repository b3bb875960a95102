"""The folder that brings the core into other designs: Verilog, descriptions, drivers, example."""

from __future__ import annotations

import json
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

from flow.command import command
from flow.package.platform_designer import hw_interfaces
from flow.package.registers import driver_source, facts, svd
from flow.templates import render
from flow.verilog import MODULE, emit_verilog
from flow.verilog_ports import ports_of, split_modules
from golden import Settings
from golden import output_constructor as record
from golden.formats import COORDINATE_BITS, OFFSET_BITS
from golden.subpixel import FITS
from golden.version import VERSION
from hdl.build import Build
from hdl.edges.avalon import VIDEO_PACKET

PackageInterface = Literal["axi", "avalon"]
"""Edges with buses that other cores use; the bare detector has neither registers nor a guard."""

MANIFEST = "cornerstream-package.json"
"""This file marks a folder as a package: it says what was built, and which files belong to it."""
REGISTERS_PAGE = "registers.md"
EXAMPLE_WIDTH, EXAMPLE_HEIGHT = 64, 48
"""Size of the frames of the example, where the core is built for such large ones."""
EXAMPLE_CELL = 16
"""Side of the example's cells, where the core is built for such small ones."""

_TEMPLATES = Path(__file__).parent / "templates"
_SOFTWARE = {"software/{}.h": "cornerstream.h", "software/{}_example.c": "example.c"}
_RENDERED = {
    "README.md": "README.md",
    REGISTERS_PAGE: "registers.md",
    "{}.core": "cornerstream.core",
    "{}_hw.tcl": "hw.tcl",
    "example/{}_example.v": "example.v",
    "example/{}_tb.v": "tb.v",
    "example/lint.vlt": "lint.vlt",
}


def package_files(build: Build, interface: PackageInterface, name: str = MODULE) -> dict[str, str]:
    """All files of the package, by path relative to its folder.

    The names of the core, of its files and of all in them begin with ``name``.

    Raises
    ------
    ValueError
        This build cannot have such edges, or the name is not allowed.
    flow.verilog.VerilogError
        Yosys refused the design.
    """
    verilog = emit_verilog(build, interface, name)
    ports = ports_of(split_modules(verilog)[1][name])
    known = _facts(build, name) | {
        "command": command("package", build, interface=interface, name=name),
        "interface": interface,
        "interfaces": hw_interfaces(interface, ports),
        "ports": ports,
        "port": {port.name: port for port in ports},
    }
    files = {
        known["verilog"]: verilog,
        f"{name}.svd": svd(build, name),
        **software_files(build, name),
        **{path.format(name): render(_TEMPLATES, template, known) for path, template in _RENDERED.items()},
    }
    manifest = {
        "generator": f"cornerstream {VERSION}",
        "amaranth": version("amaranth"),
        "name": name,
        "interface": interface,
        "parameters": build.as_dict(),
        "files": sorted([*files, MANIFEST]),
    }
    return files | {MANIFEST: json.dumps(manifest, indent=2) + "\n"}


def registers_page(build: Build) -> str:
    """The register map as a page, the same for all edges."""
    return render(_TEMPLATES, "registers.md", _facts(build, MODULE))


def software_files(build: Build, name: str = MODULE) -> dict[str, str]:
    """What programs need, by path in the package: C header, C example and Python driver.

    They are the same for all edges.
    """
    known = _facts(build, name)
    c_files = {path.format(name): render(_TEMPLATES, template, known) for path, template in _SOFTWARE.items()}
    return {f"software/{name}_registers.py": driver_source(build, name), **c_files}


def _facts(build: Build, name: str) -> dict[str, Any]:
    return {
        **facts(build),
        "defaults": Settings.default(build),
        "example_cell": max(EXAMPLE_CELL, build.min_cell_width),
        "example_height": min(EXAMPLE_HEIGHT, build.max_height),
        "example_width": min(EXAMPLE_WIDTH, build.max_width),
        "margin": build.algorithm.margin,
        "manifest": MANIFEST,
        "module": name,
        "named": name != MODULE,
        "reach": f"{FITS[build.algorithm.fit].limit / (1 << OFFSET_BITS):g}",
        "p": build,
        "parameters": build.as_dict(),
        "record": {
            "bits": record.RECORD_BITS,
            "coordinate_bits": COORDINATE_BITS,
            "count_bits": record.COUNT_BITS,
            "cut_shift": record.CUT_SHIFT,
            "flags": {str(flag.name): int(flag) for flag in record.Flag},
            "flag_bits": record.RECORD_BITS - record.FLAG_SHIFT,
            "flag_shift": record.FLAG_SHIFT,
            "frame_bits": record.FRAME_BITS,
            "time": record.TIME_RECORD,
            "time_bits": record.TIME_BITS,
            "end": int(record.END_OF_FRAME),
            "offset_bits": OFFSET_BITS,
            "response_bits": record.RESPONSE_FIELD_BITS,
            "response_shift": record.RESPONSE_SHIFT,
        },
        "smallest": build.algorithm.support,
        "verilog": f"rtl/{name}.v",
        "version": VERSION,
        "video_packet": VIDEO_PACKET,
    }
