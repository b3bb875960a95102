"""``cornerstream export``: a project for Quartus; and how a folder is written that may be an earlier run's."""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from cornerstream import console
from cornerstream.errors import BadInput, bad_input, reason
from cornerstream.files import prepare_folder, write_all
from cornerstream.options import detector_options, output_option, parameters_from, pixel_bits_option
from cornerstream.tools import running_tools
from flow.quartus.project import DEVICE, MANIFEST, project_files


@click.command(short_help="Quartus project.")
@output_option("build/quartus", "Folder of the project.")
@detector_options
@pixel_bits_option
@click.option("--clock", type=float, default=100.0, show_default=True, metavar="MHZ", help="Clock asked for.")
@click.option("--force", is_flag=True, help="Write into a folder that holds other files, too.")
def export(output: Path, clock: float, force: bool, **options: Any) -> None:
    """Write the core as a Quartus project: Verilog, settings, constraints, and a script that compiles it.

    An earlier export in the same folder is replaced; what Quartus made of it stays.

    \b
    Examples:
      cornerstream export
      cornerstream export -o q720 --profile robust --width 1280 --height 720 --clock 150
      cd build/quartus && quartus_sh -t compile.tcl
    """
    parameters = parameters_from(options, hardware=True)
    old = earlier_files(output, MANIFEST, "export", force=force)
    with console.activity("Generating Verilog"), running_tools(), bad_input():
        files = project_files(parameters, clock_mhz=clock)
    write_folder(output, files, old)
    console.say(
        f"Written: {output}, {len(files)} files: {DEVICE}, up to {parameters.max_width}x{parameters.max_height} "
        f"pixels, {clock:g} MHz. Next, in that folder: quartus_sh -t compile.tcl"
    )


def earlier_files(folder: Path, manifest: str, what: str, *, force: bool) -> set[str]:
    """Files of an earlier run into this folder, known by its manifest; :class:`BadInput` if it is somebody else's.

    Parameters
    ----------
    folder, manifest
        Where, and the name of the JSON file there whose ``files`` are those that were written.
    what
        What such a run makes, for the message.
    force
        Take somebody else's folder, too.
    """
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"{folder} is no folder; allowed: a folder that can be written")
    try:
        if not folder.exists() or not any(folder.iterdir()):
            return set()
        made = json.loads((folder / manifest).read_text(encoding="utf-8"))
        return {name for name in made["files"] if _is_inside(name)}
    except (OSError, ValueError, KeyError, TypeError) as error:
        if force:
            return set()
        raise BadInput(
            f"{folder} holds files that are no earlier {what}; allowed: an empty or a new folder, or --force"
        ) from error


def _is_inside(name: str) -> bool:
    path = Path(name)
    return not path.is_absolute() and ".." not in path.parts


def write_folder(folder: Path, files: Mapping[str, str], old: set[str]) -> None:
    """Write all files, by path relative to the folder, or none; then remove what belonged to the old ones only."""
    contents = {name: text.encode() for name, text in files.items()}
    if folder.exists():
        _write_into(folder, contents)
        for name in old - set(files):
            (folder / name).unlink(missing_ok=True)
        return
    prepare_folder(folder.parent)
    made = folder.parent / f".{folder.name}-{os.getpid()}"
    try:
        made.mkdir()
        _write_into(made, contents)
        os.replace(made, folder)
    except OSError as error:
        raise BadInput(f"cannot write {folder}: {reason(error)}; allowed: a new folder") from error
    finally:
        shutil.rmtree(made, ignore_errors=True)


def _write_into(folder: Path, contents: Mapping[str, bytes]) -> None:
    for place in {(folder / name).parent for name in contents}:
        prepare_folder(place)
    write_all({folder / name: content for name, content in contents.items()})
