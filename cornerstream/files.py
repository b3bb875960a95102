"""Output files: tables of corners, the picture, whole folders; each is written whole or not."""

from __future__ import annotations

import errno
import io
import json
import os
import shutil
import stat
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any, TypeVar

import numpy as np
from jinja2 import UndefinedError
from numpy.typing import NDArray

from cornerstream.errors import BadInput, reason
from cornerstream.picture import Panel, draw_panels
from golden import Corners

Made = TypeVar("Made")

PICTURE_NAME = "corners.png"


def corner_objects(corners: Corners) -> list[dict[str, Any]]:
    """The corners as JSON has them: an object for each."""
    columns = corners.to_dict()
    rows = zip(*(values.tolist() for values in columns.values()), strict=True)
    return [dict(zip(columns, row, strict=True)) for row in rows]


def profiles_json(figures: list[dict[str, Any]]) -> str:
    """One JSON object: the figures of one profile, or a list of them for several profiles."""
    return json.dumps(figures[0] if len(figures) == 1 else {"profiles": figures})


def prepare_folder(folder: Path) -> None:
    """Make an output folder and check that it can be written, before long work begins."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(dir=folder, prefix=".writable-"):
            pass
    except OSError as error:
        raise BadInput(
            f"cannot write to {folder}: {reason(error)}; allowed: a folder that can be written"
        ) from error


def write_results(folder: Path, pixels: NDArray[np.uint8], panels: Sequence[Panel]) -> list[Path]:
    """Write a table for each profile, and one picture of them all; returns their paths."""
    picture = io.BytesIO()
    draw_panels(pixels, panels).save(picture, format="PNG", optimize=True)
    paths = result_paths(folder, [panel.profile for panel in panels])
    tables = [panel.corners.to_csv().encode() for panel in panels]
    write_all(dict(zip(paths, (*tables, picture.getvalue()), strict=True)))
    return paths


def prepare_file(path: Path) -> None:
    """Check that a file can be written, before long work begins; a missing folder is made."""
    _refuse_folder(path)
    if not _is_written_through(path):
        prepare_folder(_target(path).parent)
    elif not os.access(path, os.W_OK):
        raise _cannot_write(path, PermissionError(errno.EACCES, os.strerror(errno.EACCES)))


def _refuse_folder(path: Path) -> None:
    if path.is_dir():
        raise _cannot_write(path, IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR)))


def check_distinct(*paths: Path | None) -> None:
    """:class:`BadInput` if two of these paths lead to the same file; None stands for no file."""
    seen: dict[str, Path] = {}
    for path in filter(None, paths):
        same = seen.setdefault(os.path.realpath(path), path)
        if same is not path:
            raise BadInput(f"{path} and {same} are one file; allowed: a file of its own for each")


def result_paths(folder: Path, profiles: Sequence[str]) -> list[Path]:
    """Paths that :func:`write_results` writes; with several profiles, each table has a name."""
    names = ["corners.csv"] if len(profiles) == 1 else [f"corners-{profile}.csv" for profile in profiles]
    return [folder / name for name in (*names, PICTURE_NAME)]


def write_all(contents: Mapping[Path, bytes]) -> None:
    """Write files under temporary names, renamed when all are complete: none is ever half written.

    A link stays, and the file that it points to is replaced. Pipes, devices and other special files
    are written last, when all others could be written.
    """
    temporary: dict[Path, Path] = {}
    for path in contents:
        _refuse_folder(path)
    through = [path for path in contents if _is_written_through(path)]
    try:
        for path in (path for path in contents if path not in through):
            target = _target(path)
            with NamedTemporaryFile(dir=target.parent, prefix=f".{target.name}-", delete=False) as file:
                temporary[target] = Path(file.name)
                file.write(contents[path])
            # temporary files are private; these get the permissions that the umask allows
            temporary[target].chmod(0o666 & ~_umask())
        for path in through:
            _write_through(path, contents[path])
        for path, complete in temporary.items():
            os.replace(complete, path)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise _cannot_write(path, error) from error
    finally:
        for leftover in temporary.values():
            leftover.unlink(missing_ok=True)


def _target(path: Path) -> Path:
    """The file itself, where the path is a link to it."""
    return Path(os.path.realpath(path))


def _is_written_through(path: Path) -> bool:
    """Whether the file must stay: a pipe, a device, or the file behind stdout or stderr."""
    try:
        status = path.stat()
    except OSError:
        return False
    return not stat.S_ISREG(status.st_mode) or _standard_stream(status) is not None


def _standard_stream(status: os.stat_result) -> int | None:
    # compared by device and inode, because /dev/stdout is a link to a link
    for number in (1, 2):
        with suppress(OSError):
            if os.path.samestat(status, os.fstat(number)):
                return number
    return None


def _write_through(path: Path, content: bytes) -> None:
    number = _standard_stream(path.stat())
    # if it were opened again, a file behind stdout would lose its contents
    with open(path if number is None else os.dup(number), "wb") as file:
        file.write(content)


def _cannot_write(path: Path, error: OSError) -> BadInput:
    return BadInput(f"cannot write {path}: {reason(error)}; allowed: a file that can be written")


def read_figures(path: Path, make: Callable[[dict[str, Any]], Made]) -> Made:
    """The result of ``make`` for figures that were measured before.

    :class:`BadInput` if there are none, or not those that ``make`` needs.
    """
    allowed = "allowed: what was measured before"
    try:
        figures = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise BadInput(f"cannot read {path}: {reason(error)}; {allowed}") from error
    except ValueError as error:
        raise BadInput(f"{path} is not JSON; {allowed}") from error
    try:
        return make(figures)
    except (AttributeError, LookupError, TypeError, ValueError, UndefinedError) as error:
        raise BadInput(f"{path} has other figures than the page shows; {allowed}") from error


def earlier_files(folder: Path, manifest: str, what: str, *, force: bool) -> set[str]:
    """Files of an earlier run in this folder, which its manifest lists.

    :class:`BadInput` if the folder has other files, and no manifest.

    Parameters
    ----------
    folder, manifest
        The folder, and the name of the JSON file in it whose ``files`` are those that were written.
    what
        Name of what such a run makes, for the message.
    force
        Take a folder with other files, too.
    """
    if folder.exists() and not folder.is_dir():
        raise BadInput(f"{folder} is not a folder; allowed: a folder that can be written")
    try:
        if not folder.exists() or not any(folder.iterdir()):
            return set()
        made = json.loads((folder / manifest).read_text(encoding="utf-8"))
        return {name for name in made["files"] if _is_inside(name)}
    except (OSError, ValueError, KeyError, TypeError) as error:
        if force:
            return set()
        raise BadInput(
            f"{folder} holds files that are not an earlier {what}; allowed: an empty or a new folder, or --force"
        ) from error


def _is_inside(name: str) -> bool:
    path = Path(name)
    return not path.is_absolute() and ".." not in path.parts


def write_folder(folder: Path, files: Mapping[str, str], old: set[str]) -> None:
    """Write all files, by path relative to the folder, or none; then remove other old ones."""
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


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask
