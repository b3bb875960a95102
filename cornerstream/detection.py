"""``cornerstream detect``: the golden model on one image."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.table import Table

from cornerstream import console
from cornerstream.about import about
from cornerstream.errors import bad_input
from cornerstream.files import check_distinct, corners_json, prepare_folder, result_paths, write_results
from cornerstream.idle import Idle, refuse_idle
from cornerstream.images import load
from cornerstream.options import (
    image_argument,
    json_option,
    model_options,
    normalize_option,
    output_option,
    parameters_from,
    pixel_bits_option,
    settings_from,
    threshold_options,
)
from golden import Corners, Settings, detection
from golden.checks import check_distance


@click.command(short_help="Golden model on one image.")
@image_argument
@model_options
@pixel_bits_option
@normalize_option
@threshold_options
@output_option(None, "Folder for corners.csv and corners.png.  [default: build, or no files with --json]")
@click.option(
    "--min-distance",
    type=float,
    metavar="PX",
    default=0,
    show_default=True,
    help="Leave out each accepted corner that is nearer than this to a stronger one that stays. After all else, "
    "and only here: the hardware keeps no more than peaks apart, by --suppression.",
)
@json_option
def detect(
    image: Path, output: Path | None, min_distance: float, as_json: bool, normalize: bool, **options: Any
) -> None:
    """Find the corners of IMAGE with the golden model, without hardware.

    Thresholds are relative to the image's own largest response: what the hardware uses from the
    second frame on while the scene stands still.

    \b
    Examples:
      cornerstream detect photo.jpg
      cornerstream detect photo.jpg --profile robust --sigma1 0.05 -o corners/
      cornerstream detect photo.jpg --profile robust --min-distance 8
      cornerstream detect camera12bit.tif --pixel-bits 10 --normalize
      cornerstream detect photo.jpg --json | jq '.corners | length'
    """
    parameters = parameters_from(options)
    settings = settings_from(options, parameters)
    aimed = settings.target_corners > 0 and parameters.algorithm.texture == "mean"
    unusual = settings.constant != Settings.default(parameters).constant
    refuse_idle(
        Idle("reference", aimed, "without --target-corners, or with --texture patches"),
        Idle(
            "constant",
            unusual and (aimed or settings.reference != "constant"),
            "with --reference constant",
        ),
    )
    with bad_input():
        check_distance("min_distance", min_distance)
    photograph = load(image, parameters, normalize=normalize)
    console.remarks(photograph)
    if output is None and not as_json:
        output = Path("build")
    if output is not None:
        check_distinct(image, *result_paths(output))
        prepare_folder(output)
    found = detection(photograph.pixels, parameters, settings)
    corners = found.corners.apart(min_distance)
    written = [] if output is None else write_results(output, photograph.shown(parameters), corners)
    if written:
        console.files_written(written)
    height, width = photograph.pixels.shape
    if as_json:
        figures = {
            **about(photograph, options["profile"], parameters, settings),
            "min_distance": min_distance,
            "reference": found.reference,
            **found.limits._asdict(),
            "files": [str(path) for path in written],
        }
        click.echo(corners_json(corners, **figures))
    else:
        console.show(_table(width, height, corners))


def _table(width: int, height: int, corners: Corners) -> Table:
    table = Table()
    for heading in ("size", "corners", "rejected", "clamped", "not a maximum"):
        table.add_column(heading, justify="right")
    accepted = corners.accepted
    flags = [np.count_nonzero(corners.flags[accepted] & flag) for flag in (1, 2)]
    table.add_row(f"{width}x{height}", str(accepted.sum()), str((~accepted).sum()), *map(str, flags))
    return table
