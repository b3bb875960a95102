"""``cornerstream package``: the core for other people's designs, tools and programs."""

from __future__ import annotations

from pathlib import Path
from typing import Any, get_args

import click

from cornerstream import console
from cornerstream.errors import bad_input
from cornerstream.files import earlier_files, write_folder
from cornerstream.options import (
    build_from,
    detector_options,
    edge_options,
    name_option,
    output_option,
    pixel_bits_option,
)
from cornerstream.tools import running_tools
from flow.package import MANIFEST, PackageInterface, package_files


@click.command(short_help="The core with drivers, descriptions and an example.")
@output_option("build/ip", "Folder of the package.")
@click.option(
    "--interface",
    type=click.Choice(get_args(PackageInterface)),
    default="axi",
    show_default=True,
    help="AXI4-Stream and AXI4-Lite, or Avalon-ST and Avalon-MM.",
)
@detector_options
@pixel_bits_option
@edge_options
@name_option
@click.option("--force", is_flag=True, help="Write into a folder that holds other files, too.")
def package(output: Path, interface: PackageInterface, name: str, force: bool, **options: Any) -> None:
    """Write the core with all that other designs, tools and programs need of it.

    Verilog and an example around it; descriptions for FuseSoC and Platform Designer; the registers
    as a page, as CMSIS-SVD, as a C header with an example, and as a Python driver. An earlier
    package in the same folder is replaced.

    \b
    Examples:
      cornerstream package
      cornerstream package -o ip720 --profile robust --max-width 1280 --max-height 720
      cornerstream package -o ip --interface avalon
      cornerstream package -o ip_b --name corners_b
    """
    parameters = build_from({"interface": interface, **options})
    old = earlier_files(output, MANIFEST, "package", force=force)
    with console.activity("Generating Verilog"), running_tools(), bad_input():
        files = package_files(parameters, interface, name)
    write_folder(output, files, old)
    console.say(
        f"Written: {output}, {len(files)} files: {interface}, up to {parameters.max_width}x{parameters.max_height} "
        f"pixels. What is what: {output / 'README.md'}"
    )
