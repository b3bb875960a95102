"""``cornerstream quartus``: a project for Quartus, and the report of its compilation."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
from rich.table import Table

from cornerstream import console
from cornerstream.errors import BadInput, Failed, OneLineGroup, bad_input, one_line
from cornerstream.files import earlier_files, write_folder
from cornerstream.groups import MAIN, GroupedCommand, option
from cornerstream.options import (
    GIVEN_PATH,
    build_from,
    device_option,
    force_option,
    hardware_options,
    model_options,
    name_option,
    output_option,
    profile_option,
)
from cornerstream.tools import running_tools
from flow.device import Device
from flow.quartus.project import MANIFEST, project_files
from flow.quartus.summaries import QuartusReport, ReportError, read_report


@click.group(cls=OneLineGroup, short_help="Quartus project, and Quartus' report.")
def quartus() -> None:
    """Write a project for Quartus, and show Quartus' report on it.

    \b
    Examples:
      cornerstream quartus export
      cd build/quartus && quartus_sh -t compile.tcl
      cornerstream quartus report build/quartus
    """


@quartus.command(cls=GroupedCommand, short_help="Write a Quartus project.")
@output_option("build/quartus", "Folder of the project.")
@profile_option
@name_option
@device_option("quartus")
@option(
    MAIN,
    "--clock",
    type=float,
    default=100.0,
    show_default=True,
    metavar="MHZ",
    help="Clock frequency that Quartus is asked to reach.",
)
@model_options
@hardware_options
@force_option
def export(
    output: Path, profile: str, clock: float, name: str, device: Device, force: bool, **options: Any
) -> None:
    """Write the core as a Quartus project: Verilog, settings, constraints and a script.

    An earlier export in the same folder is replaced; files that Quartus made stay.

    \b
    Examples:
      cornerstream quartus export
      cornerstream quartus export --device EP4CE115F29C7
      cornerstream quartus export --max-width 1280 --max-height 720 --clock 150
      cd build/quartus && quartus_sh -t compile.tcl
    """
    parameters = build_from(profile, options)
    old = earlier_files(output, MANIFEST, "export", force=force)
    with console.activity("Generating Verilog"), running_tools(), bad_input():
        files = project_files(parameters, device, clock_mhz=clock, name=name)
    write_folder(output, files, old)
    console.say(
        f"Written: {output}, {len(files)} files: {device.part}, up to {parameters.max_width}x{parameters.max_height} "
        f"pixels, {clock:g} MHz. Next, in that folder: quartus_sh -t compile.tcl"
    )


@quartus.command(short_help="Area and timing that Quartus reports.")
@click.argument("folder", type=GIVEN_PATH, default="build/quartus", metavar="[DIR]")
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
def report(folder: Path, as_json: bool) -> None:
    """Show area and timing of the project in DIR that Quartus has compiled.

    DIR is build/quartus unless it is given. The figures are those of the Fitter's and the Timing
    Analyzer's summaries.

    Exit code 1 if timing is not met, or not known because there is no summary of the Timing
    Analyzer.

    \b
    Examples:
      cornerstream quartus report build/quartus
      cornerstream quartus report build/quartus --json
    """
    try:
        found = read_report(folder)
    except ReportError as error:
        raise BadInput(one_line(error)) from error
    if as_json:
        click.echo(json.dumps(_figures(found)))
    else:
        console.show(_table(found))
    if found.no_timing is not None:
        raise Failed(f"timing is not known: {found.no_timing}")
    if found.missed:
        raise Failed(f"timing is not met: {', '.join(found.missed)}")
    if found.no_fmax is not None:
        console.say(f"No Fmax: {found.no_fmax}")


def _figures(found: QuartusReport) -> dict[str, Any]:
    derived = {name: getattr(found, name) for name in ("fmax_mhz", "no_fmax", "timing_met")}
    figures = asdict(found)
    # the reason why there is no Fmax says the same
    del figures["no_timing"]
    return {**figures, **derived}


def _table(found: QuartusReport) -> Table:
    table = Table(title=f"{found.revision} in {found.device}\n{found.version}", title_justify="left")
    figures = {
        "LUT4": f"{found.lut4:,}",
        "FF": f"{found.ff:,}",
        "LE": f"{found.le:,}",
        "M9K": "-" if found.m9k is None else f"{found.m9k:,}",
        "memory bits": f"{found.memory_bits:,}",
        "9x9 mult.": f"{found.multipliers:,}",
        "setup": _nanoseconds(found.setup_slack),
        "hold": _nanoseconds(found.hold_slack),
        "Fmax": "-" if found.fmax_mhz is None else f"{found.fmax_mhz:.1f} MHz",
    }
    for heading in figures:
        table.add_column(heading, justify="right")
    table.add_row(*figures.values())
    table.caption = "setup, hold: the smallest slack of all operating conditions"
    if found.fmax_mhz is not None:
        table.caption += f"; Fmax from that of setup, at a period of {found.period:g} ns"
    return table


def _nanoseconds(slack: float | None) -> str:
    return "-" if slack is None else f"{slack:.3f} ns"
