"""The folder that carries the core into other people's designs: Verilog, descriptions, drivers, an
example.
"""

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
from golden.formats import COORDINATE_BITS, MARGIN, OFFSET_BITS, SUPPORT
from golden.subpixel import FITS
from golden.version import VERSION
from hdl.build import Build
from hdl.edges.avalon import VIDEO_PACKET

PackageInterface = Literal["axi", "avalon"]
"""Edges that other people's cores speak; the bare detector has neither registers nor a guard."""

MANIFEST = "cornerstream-package.json"
"""By this file a folder is known as a package: what was built, and the files that belong to it."""
REGISTERS_PAGE = "registers.md"
EXAMPLE_WIDTH, EXAMPLE_HEIGHT = 64, 48
"""Of the example's frames, where the core is built for as large ones."""

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


def package_files(parameters: Build, interface: PackageInterface, name: str = MODULE) -> dict[str, str]:
    """All files of the package, by path relative to its folder; the core, its files and macros are
    called ``name``.

    Raises
    ------
    ValueError
        There is no such core, or it cannot be called so.
    flow.verilog.VerilogError
        Yosys refused the design.
    """
    verilog = emit_verilog(parameters, interface, name)
    ports = ports_of(split_modules(verilog)[1][name])
    known = _facts(parameters, name) | {
        "command": command("package", parameters, interface=interface, name=name),
        "interface": interface,
        "interfaces": hw_interfaces(interface, ports),
        "ports": ports,
        "port": {port.name: port for port in ports},
    }
    files = {
        known["verilog"]: verilog,
        f"{name}.svd": svd(parameters, name),
        **software_files(parameters, name),
        **{path.format(name): render(_TEMPLATES, template, known) for path, template in _RENDERED.items()},
    }
    manifest = {
        "generator": f"cornerstream {VERSION}",
        "amaranth": version("amaranth"),
        "name": name,
        "interface": interface,
        "parameters": parameters.as_dict(),
        "files": sorted([*files, MANIFEST]),
    }
    return files | {MANIFEST: json.dumps(manifest, indent=2) + "\n"}


def registers_page(parameters: Build) -> str:
    """The register map as a page, the same whatever the edges are."""
    return render(_TEMPLATES, "registers.md", _facts(parameters, MODULE))


def software_files(parameters: Build, name: str = MODULE) -> dict[str, str]:
    """What programs need, by path in the package: the C header with an example and the Python
    driver. They are the same whatever the edges are.
    """
    known = _facts(parameters, name)
    c_files = {path.format(name): render(_TEMPLATES, template, known) for path, template in _SOFTWARE.items()}
    return {f"software/{name}_registers.py": driver_source(parameters, name), **c_files}


def _facts(parameters: Build, name: str) -> dict[str, Any]:
    return {
        **facts(parameters),
        "defaults": Settings.default(parameters),
        "example_height": min(EXAMPLE_HEIGHT, parameters.max_height),
        "example_width": min(EXAMPLE_WIDTH, parameters.max_width),
        "margin": MARGIN,
        "manifest": MANIFEST,
        "module": name,
        "named": name != MODULE,
        "reach": f"{FITS[parameters.algorithm.fit].limit / (1 << OFFSET_BITS):g}",
        "p": parameters,
        "parameters": parameters.as_dict(),
        "record": {
            "bits": record.RECORD_BITS,
            "coordinate_bits": COORDINATE_BITS,
            "count_bits": record.COUNT_BITS,
            "cut_shift": record.CUT_SHIFT,
            "flags": {str(flag.name): int(flag) for flag in record.Flag},
            "flag_bits": record.RECORD_BITS - record.FLAG_SHIFT,
            "flag_shift": record.FLAG_SHIFT,
            "frame_bits": record.FRAME_BITS,
            "end": int(record.END_OF_FRAME),
            "offset_bits": OFFSET_BITS,
            "response_bits": record.RESPONSE_FIELD_BITS,
            "response_shift": record.RESPONSE_SHIFT,
        },
        "smallest": SUPPORT,
        "verilog": f"rtl/{name}.v",
        "version": VERSION,
        "video_packet": VIDEO_PACKET,
    }
