"""``cornerstream verilog``: the core as Verilog."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import click

from cornerstream import console
from cornerstream.errors import bad_input
from cornerstream.files import prepare_file, write_all
from cornerstream.options import (
    GIVEN_PATH,
    build_from,
    detector_options,
    edge_options,
    interface_option,
    name_option,
    pixel_bits_option,
)
from cornerstream.tools import running_tools
from flow.verilog import emit_verilog
from hdl.edges import Interface


@click.command(short_help="The core as Verilog.")
@interface_option
@detector_options
@pixel_bits_option
@edge_options
@name_option
@click.option("--output", "-o", type=GIVEN_PATH, metavar="FILE", help="File to write.  [default: stdout]")
def verilog(output: Path | None, interface: Interface, name: str, **options: Any) -> None:
    """Write the core as Verilog-2001, one file, top module 'cornerstream' or another name.

    \b
    Examples:
      cornerstream verilog -o cornerstream.v
      cornerstream verilog --profile robust --max-width 1280 --max-height 720 -o corners720.v
      cornerstream verilog --interface avalon -o cornerstream.v
      cornerstream verilog --interface stream -o bare.v
      cornerstream verilog --profile robust --name corners_b -o corners_b.v
    """
    parameters = build_from({"interface": interface, **options})
    if output is not None:
        prepare_file(output)
    with console.activity("Generating Verilog"), running_tools(), bad_input():
        text = emit_verilog(parameters, interface, name)
    if output is None:
        sys.stdout.write(text)
    else:
        write_all({output: text.encode()})
        console.files_written([output])
