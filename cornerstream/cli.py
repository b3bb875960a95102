"""The command ``cornerstream``."""

from __future__ import annotations

import click

from cornerstream.bench import bench
from cornerstream.compare import compare
from cornerstream.detection import detect
from cornerstream.errors import BadInput, OneLineGroup
from cornerstream.eval import evaluate
from cornerstream.package import package
from cornerstream.quartus import quartus
from cornerstream.simulation import simulate
from cornerstream.synth import synth
from cornerstream.verilog import verilog
from golden.version import VERSION

_RENAMED = {"export": "quartus export", "report": "quartus report", "tables": "compare"}
"""Commands by the name that they had before."""


class _Main(OneLineGroup):
    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        if args[0] in _RENAMED:
            raise BadInput(f"{args[0]!r} has another name now; allowed: cornerstream {_RENAMED[args[0]]}")
        return super().resolve_command(ctx, args)


@click.group(
    cls=_Main,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
)
@click.version_option(VERSION, "--version", prog_name="cornerstream")
def main() -> None:
    """Find corners in a stream of images: one pixel per clock, in hardware.

    \b
    Examples:
      cornerstream simulate              a photograph through the hardware
      cornerstream simulate photo.jpg    your own photograph
      cornerstream detect photo.jpg      the golden model only
      cornerstream verilog -o core.v     the core, for your synthesis tool
      cornerstream package -o ip         the core with drivers and an example
      cornerstream quartus export        the core, as a Quartus project
      cornerstream synth                 its area and clock frequency
      cornerstream eval                  how good its corners are

    Exit codes: 0 all well, 1 hardware and golden model differ, timing is not met or the run failed,
    2 bad input, 130 interrupted.
    """


for command in (simulate, detect, verilog, package, quartus, synth, compare, bench, evaluate):
    main.add_command(command)
