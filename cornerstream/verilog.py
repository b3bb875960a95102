"""``cornerstream verilog``: the core as Verilog."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from cornerstream import console
from cornerstream.errors import bad_input
from cornerstream.files import prepare_file, write_all
from cornerstream.groups import MAIN, GroupedCommand, option
from cornerstream.options import (
    GIVEN_PATH,
    build_from,
    edge_options,
    hardware_options,
    interface_option,
    model_options,
    name_option,
    profile_option,
)
from cornerstream.tools import running_tools
from flow.verilog import emit_verilog
from hdl.edges import Interface


@click.command(cls=GroupedCommand, short_help="The core as Verilog.")
@option(MAIN, "--output", "-o", type=GIVEN_PATH, metavar="FILE", help="File to write.  [default: stdout]")
@profile_option
@interface_option
@name_option
@model_options
@hardware_options
@edge_options
def verilog(output: Path | None, interface: Interface, name: str, profile: str, **options: Any) -> None:
    """Write the core as Verilog-2001, one file, top module 'cornerstream' or another name.

    \b
    Examples:
      cornerstream verilog -o cornerstream.v
      cornerstream verilog --max-width 1280 --max-height 720 -o corners720.v
      cornerstream verilog --pixels-per-clock 4 --max-width 1920 -o corners4.v
      cornerstream verilog --interface avalon -o cornerstream.v
      cornerstream verilog --interface stream -o bare.v
      cornerstream verilog --name corners_b -o corners_b.v
    """
    parameters = build_from(profile, {"interface": interface, **options})
    if output is not None:
        prepare_file(output)
    with console.activity("Generating Verilog"), running_tools(), bad_input():
        text = emit_verilog(parameters, interface, name)
    if output is None:
        sys.stdout.write(text)
    else:
        write_all({output: text.encode()})
        console.files_written([output])
