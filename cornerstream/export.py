"""``cornerstream export``: a project for Quartus."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from cornerstream import console
from cornerstream.errors import bad_input
from cornerstream.files import earlier_files, write_folder
from cornerstream.options import (
    build_from,
    detector_options,
    name_option,
    output_option,
    pixel_bits_option,
)
from cornerstream.tools import running_tools
from flow.quartus.project import DEVICE, MANIFEST, project_files


@click.command(short_help="Quartus project.")
@output_option("build/quartus", "Folder of the project.")
@detector_options
@pixel_bits_option
@name_option
@click.option(
    "--clock",
    type=float,
    default=100.0,
    show_default=True,
    metavar="MHZ",
    help="Clock frequency that Quartus is asked to reach.",
)
@click.option("--force", is_flag=True, help="Write into a folder that holds other files, too.")
def export(output: Path, clock: float, name: str, force: bool, **options: Any) -> None:
    """Write the core as a Quartus project: Verilog, settings, constraints, and a script that
    compiles it.

    An earlier export in the same folder is replaced; what Quartus made of it stays.

    \b
    Examples:
      cornerstream export
      cornerstream export -o q720 --profile robust --width 1280 --height 720 --clock 150
      cd build/quartus && quartus_sh -t compile.tcl
    """
    parameters = build_from(options)
    old = earlier_files(output, MANIFEST, "export", force=force)
    with console.activity("Generating Verilog"), running_tools(), bad_input():
        files = project_files(parameters, clock_mhz=clock, name=name)
    write_folder(output, files, old)
    console.say(
        f"Written: {output}, {len(files)} files: {DEVICE}, up to {parameters.max_width}x{parameters.max_height} "
        f"pixels, {clock:g} MHz. Next, in that folder: quartus_sh -t compile.tcl"
    )
