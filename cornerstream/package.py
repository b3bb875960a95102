"""``cornerstream package``: the core for other people's designs, tools and programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from cornerstream import console
from cornerstream.errors import bad_input
from cornerstream.files import earlier_files, write_folder
from cornerstream.groups import GroupedCommand
from cornerstream.options import (
    build_from,
    edge_options,
    force_option,
    hardware_options,
    interface_option_of,
    model_options,
    name_option,
    output_option,
    profile_option,
)
from cornerstream.tools import running_tools
from flow.package import MANIFEST, PackageInterface, package_files


@click.command(cls=GroupedCommand, short_help="The core with drivers, descriptions and an example.")
@output_option("build/ip", "Folder of the package.")
@profile_option
@interface_option_of(PackageInterface, "AXI4-Stream and AXI4-Lite, or Avalon-ST and Avalon-MM.")
@name_option
@model_options
@hardware_options
@edge_options
@force_option
def package(
    output: Path, profile: str, interface: PackageInterface, name: str, force: bool, **options: Any
) -> None:
    """Write the core with everything that other designs, tools and programs need.

    Verilog and an example around it; descriptions for FuseSoC and Platform Designer; the registers
    as a page, as CMSIS-SVD, as a C header with an example, and as a Python driver. An earlier
    package in the same folder is replaced.

    \b
    Examples:
      cornerstream package
      cornerstream package -o ip720 --max-width 1280 --max-height 720
      cornerstream package -o ip --interface avalon
      cornerstream package -o ip_b --name corners_b
    """
    parameters = build_from(profile, {"interface": interface, **options})
    old = earlier_files(output, MANIFEST, "package", force=force)
    with console.activity("Generating Verilog"), running_tools(), bad_input():
        files = package_files(parameters, interface, name)
    write_folder(output, files, old)
    console.say(
        f"Written: {output}, {len(files)} files: {interface}, up to {parameters.max_width}x{parameters.max_height} "
        f"pixels. What is what: {output / 'README.md'}"
    )
