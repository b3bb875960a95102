"""``cornerstream detect``: the golden model on one image."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click
import numpy as np
from rich.table import Table

from cornerstream import console
from cornerstream.about import about
from cornerstream.advice import advice
from cornerstream.errors import bad_input
from cornerstream.files import (
    check_distinct,
    corner_objects,
    prepare_folder,
    profiles_json,
    result_paths,
    write_results,
)
from cornerstream.groups import THRESHOLDS, GroupedCommand, option
from cornerstream.idle import Idle, refuse_idle
from cornerstream.images import load
from cornerstream.options import (
    image_argument,
    json_option,
    model_options,
    most_demanding,
    normalize_option,
    output_option,
    parameters_from,
    profiles_option,
    settings_from,
    threshold_options,
)
from cornerstream.picture import Panel
from golden import Parameters, Settings, detection
from golden.checks import check_distance
from golden.frame import Frame


@click.command(cls=GroupedCommand, short_help="Golden model on one image.")
@image_argument
@output_option(None, "Folder for corners.csv and corners.png.  [default: build, or no files with --json]")
@profiles_option
@json_option
@threshold_options
@option(
    THRESHOLDS,
    "--min-distance",
    type=float,
    metavar="PX",
    default=0,
    show_default=True,
    help="Leave out each accepted corner that is nearer than this to a stronger one that stays. This is the "
    "last step, and only in this command: the hardware only keeps peaks apart, by --suppression.",
)
@model_options
@normalize_option
def detect(
    image: Path,
    output: Path | None,
    profiles: tuple[str, ...],
    min_distance: float,
    as_json: bool,
    normalize: bool,
    **options: Any,
) -> None:
    """Find the corners of IMAGE with the golden model, without hardware.

    Thresholds are relative to the image's own largest response: what the hardware uses from the
    second frame on while the scene stands still. With several profiles the picture shows them side
    by side, and each has its own table, as corners-robust.csv.

    \b
    Examples:
      cornerstream detect photo.jpg
      cornerstream detect photo.jpg --sigma1 0.02 -o corners/
      cornerstream detect photo.jpg --profile robust --profile paper
      cornerstream detect photo.jpg --min-distance 8
      cornerstream detect camera12bit.tif --pixel-bits 10 --normalize
      cornerstream detect photo.jpg --json | jq '.corners | length'
    """
    asked = [_Asked(name, parameters_from(name, options), options) for name in profiles]
    with bad_input():
        check_distance("min_distance", min_distance)
    photograph = load(image, most_demanding(each.parameters for each in asked), normalize=normalize)
    console.remarks(photograph)
    if output is None and not as_json:
        output = Path("build")
    if output is not None:
        check_distinct(image, *result_paths(output, profiles))
        prepare_folder(output)
    found = [detection(photograph.pixels, each.parameters, each.settings) for each in asked]
    panels = [
        Panel(
            each.profile,
            each.settings,
            one.corners.apart(min_distance),
            each.parameters.algorithm.margin,
        )
        for each, one in zip(asked, found, strict=True)
    ]
    written = []
    if output is not None:
        written = write_results(output, photograph.shown(asked[0].parameters), panels)
        console.files_written(written)
    if as_json:
        figures = [
            {
                **about(photograph, each.profile, each.parameters, each.settings),
                "min_distance": min_distance,
                "reference": one.reference,
                **one.limits._asdict(),
                "files": [str(path) for path in written],
                "corners": corner_objects(panel.corners),
            }
            for each, one, panel in zip(asked, found, panels, strict=True)
        ]
        click.echo(profiles_json(figures))
    else:
        height, width = photograph.pixels.shape
        console.show(_table(f"{width}x{height}", panels))
    for each, one in zip(asked, found, strict=True):
        frame = Frame(photograph.pixels, each.parameters, each.settings)
        console.advise(
            advice(
                *(each.profile, each.parameters, each.settings, one.corners),
                largest=frame.maximum,
                reference=one.reference,
                t1=one.limits.t1,
            )
        )


class _Asked:
    """Detector and thresholds of one profile; :class:`BadInput` if an option changes nothing."""

    def __init__(self, profile: str, parameters: Parameters, options: dict[str, Any]) -> None:
        self.profile = profile
        self.parameters = parameters
        self.settings = settings_from(options, parameters)
        aimed = self.settings.target_corners > 0 and parameters.algorithm.texture != "patches"
        unusual = self.settings.constant != Settings.default(parameters).constant
        refuse_idle(
            Idle("reference", aimed, "without --target-corners, or with --texture patches"),
            Idle(
                "constant",
                unusual and (aimed or self.settings.reference != "constant"),
                "with --reference constant",
            ),
        )


def _table(size: str, panels: list[Panel]) -> Table:
    table = Table()
    table.add_column("profile")
    for heading in ("size", "corners", "rejected", "clamped", "not a maximum"):
        table.add_column(heading, justify="right")
    for panel in panels:
        accepted = panel.corners.accepted
        flags = [np.count_nonzero(panel.corners.flags[accepted] & flag) for flag in (1, 2)]
        table.add_row(panel.profile, size, str(accepted.sum()), str((~accepted).sum()), *map(str, flags))
    return table
