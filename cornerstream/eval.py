"""``cornerstream eval``: how good the corners are."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path
from typing import get_args

import click

from cornerstream import console
from cornerstream.errors import BadInput, one_line
from cornerstream.eval_tables import terminal
from cornerstream.files import prepare_folder, read_figures, write_all
from cornerstream.idle import Idle, refuse_idle
from cornerstream.options import GIVEN_PATH, output_option
from cornerstream.own_data import load_boards, load_hpatches, load_images, load_pairs, load_video
from cornerstream.tools import running_tools
from evaluation.figures import Figures
from evaluation.inputs.packages import MissingPackageError
from evaluation.report.compact import compact
from evaluation.report.page import FIGURES_NAME, PAGE_NAME, PICTURES, page, plots
from evaluation.report.study import check_packages, study
from evaluation.sections.registry import SECTIONS
from evaluation.sections.section import Material, Option, UserData
from golden import PROFILES, Parameters

_LEFT_OUT = [name for name, section in SECTIONS.items() if section.not_quick]


@click.command("eval", short_help="Accuracy, repeatability, robustness.")
@click.option(
    "--quick",
    is_flag=True,
    help="Measure a tenth, to see that everything works; the figures must not be quoted.",
)
@click.option(
    "--json", "as_json", is_flag=True, help="Print everything as one JSON object instead of tables."
)
@click.option(
    "--only",
    multiple=True,
    metavar="SECTION",
    type=click.Choice(list(SECTIONS)),
    help=f"Measure this only: {', '.join(SECTIONS)}; may be given again; with --quick not "
    f"{' or '.join(_LEFT_OUT)}.  [default: all]",
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
    help="Photographs to render views of, instead of packaged ones: for repeatability, hpatches, robustness, "
    "downstream, spread and ablation.",
)
@click.option(
    "--pairs",
    type=GIVEN_PATH,
    metavar="DIR",
    help="Images and homographies H_1_2.txt: x2 ~ H x1, as HPatches: for repeatability, hpatches, "
    "robustness and ablation.",
)
@click.option(
    "--video",
    "videos",
    type=GIVEN_PATH,
    multiple=True,
    metavar="FILE",
    help="A video or a folder of frames, instead of packaged ones: for robustness; may be given again.",
)
@click.option(
    "--boards",
    type=GIVEN_PATH,
    metavar="DIR",
    help="Photographs of chessboards, besides the rendered ones: for chessboards.",
)
@click.option(
    "--hpatches",
    type=GIVEN_PATH,
    metavar="DIR",
    help="The dataset HPatches, its sequences i_NAME and v_NAME: for hpatches.",
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
    only: tuple[str, ...],
    profiles: tuple[str, ...],
    images: Path | None,
    pairs: Path | None,
    videos: tuple[Path, ...],
    boards: Path | None,
    hpatches: Path | None,
    board_size: str | None,
    output: Path | None,
    page_only: bool,
) -> None:
    """Measure how good the corners are, and print it beside the paper's and OpenCV's.

    Accuracy on rendered corners and chessboards, the paper's Table 5, repeatability on views of
    photographs, the paper's robustness on videos, homographies and depth from matched corners, and
    more, for every profile, with 95 % intervals. All of it takes about ten minutes; --only chooses.
    Needs OpenCV, scikit-learn, scikit-video and yosys (pip install 'cornerstream[eval]').

    \b
    Examples:
      cornerstream eval
      cornerstream eval --quick --json | jq .accuracy.robust.L.median
      cornerstream eval --only repeatability --images photos/
      cornerstream eval --only robustness --video walk.mp4
      cornerstream eval --only chessboards --boards boards/ --board-size 9x6
      cornerstream eval --only hpatches --hpatches hpatches-sequences-release/
      cornerstream eval --output build/evaluation
    """
    _refuse_idle(page_only, quick, only, boards)
    if (output or page_only) and importlib.util.find_spec("matplotlib") is None:
        raise BadInput("matplotlib is not installed; get it with: pip install 'cornerstream[eval]'")
    if page_only:
        folder = output or Path("docs/results")
        files = read_figures(folder / FIGURES_NAME, lambda figures: _page(figures, folder))
        _write_files(files)
        console.files_written(list(files))
        return
    names = only or _sections(quick=quick)
    try:
        with running_tools():
            check_packages(names, quick=quick, images=bool(images), videos=bool(videos))
        if output:
            prepare_folder(output)
        user = UserData(
            images=load_images(images) if images else [],
            pairs=load_pairs(pairs) if pairs else [],
            videos=[pair for video in videos for pair in load_video(video)],
            boards=load_boards(boards, _size(board_size)) if boards else [],
            hpatches=load_hpatches(hpatches) if hpatches else [],
        )
        chosen = {name: Parameters.profile(name) for name in profiles or PROFILES}
        with running_tools():
            result = study(names, Material(chosen, quick, user, console.progress))
    except MissingPackageError as error:
        raise BadInput(one_line(error)) from error
    if output:
        _write(result, output, chosen)
    if as_json:
        click.echo(json.dumps(result))
        return
    for name, section in SECTIONS.items():
        if name in result:
            for table in section.tables(result[name]).values():
                console.show(terminal(table))


def _sections(*, quick: bool) -> tuple[str, ...]:
    """All sections, or with ``quick`` those with a quick form; a line names each other one."""
    if not quick:
        return tuple(SECTIONS)
    for name in _LEFT_OUT:
        console.say(f"{name} is left out with --quick: {SECTIONS[name].not_quick}")
    return tuple(name for name in SECTIONS if name not in _LEFT_OUT)


def _refuse_idle(page_only: bool, quick: bool, only: tuple[str, ...], boards: Path | None) -> None:
    measuring = "without --page, which measures nothing"
    names = (
        "quick",
        "as_json",
        "only",
        "profiles",
        "images",
        "pairs",
        "videos",
        "boards",
        "hpatches",
        "board_size",
    )
    refuse_idle(*(Idle(name, page_only, measuring) for name in names))
    for name in only:
        if quick and SECTIONS[name].not_quick:
            raise BadInput(
                f"--only is {name}, which --quick leaves out: {SECTIONS[name].not_quick}; "
                f"allowed: without --quick"
            )
    refuse_idle(
        *(
            Idle(name, not any(name in SECTIONS[each].options for each in only or SECTIONS), _with(name))
            for name in get_args(Option)
        ),
        Idle("board_size", boards is None, "with --boards"),
    )


def _with(option: Option) -> str:
    return f"with --only {' or '.join(name for name, each in SECTIONS.items() if option in each.options)}"


def _page(result: Figures, folder: Path) -> dict[Path, bytes]:
    files = {folder / PAGE_NAME: page(result).encode()}
    drawn = plots(result)
    return files | {folder / PICTURES / name: content for name, content in drawn.items()}


def _write(result: Figures, folder: Path, chosen: dict[str, Parameters]) -> None:
    # first, because they took minutes, and the page can be written from them
    figures = {folder / FIGURES_NAME: compact(result).encode()}
    write_all(figures)
    files = _page(result, folder)
    with console.activity("drawing pictures"):
        for name, section in SECTIONS.items():
            if name in result:
                files |= {folder / PICTURES / file: draw(chosen) for file, draw in section.pictures.items()}
    _write_files(files)
    console.files_written([*figures, *files])


def _write_files(files: dict[Path, bytes]) -> None:
    for folder in {path.parent for path in files}:
        prepare_folder(folder)
    write_all(files)


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    found = re.fullmatch(r"(\d{1,3})x(\d{1,3})", text)
    if not found or min(int(found[1]), int(found[2])) < 3:
        raise BadInput(
            f"board size is {text!r}; allowed: inner corners along both sides, 3x3 to 999x999, as in 9x6"
        )
    return int(found[1]), int(found[2])
