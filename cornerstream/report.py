"""``cornerstream report``: what Quartus made of an exported project."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click
from rich.table import Table

from cornerstream import console
from cornerstream.errors import BadInput, Failed, one_line
from cornerstream.options import GIVEN_PATH
from flow.quartus.summaries import QuartusReport, ReportError, read_report


@click.command(short_help="Area and timing that Quartus reports.")
@click.option(
    "--quartus",
    "folder",
    type=GIVEN_PATH,
    default="build/quartus",
    show_default=True,
    metavar="DIR",
    help="Folder of a compiled project.",
)
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of a table.")
def report(folder: Path, as_json: bool) -> None:
    """Show area and timing of a project that Quartus has compiled, from its Fitter's and Timing
    Analyzer's summaries.

    Exit code 1 if timing is not met, or not known for want of the Timing Analyzer's summary.

    \b
    Examples:
      cornerstream report --quartus build/quartus
      cornerstream report --quartus build/quartus --json
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
