"""A copy of the sources, one place of it made wrong, and tests run on it."""

from __future__ import annotations

import multiprocessing
import runpy
import shutil
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("golden", "hdl", "sim", "tests", "pyproject.toml")
PLUGINS = ("-p", "_hypothesis_pytestplugin")
"""The only one that these tests need: looking for others takes as long as many a test."""
TIMEOUT = 300
"""Seconds until the tests in a copy are ended."""
TESTS_FAILED = 1
"""pytest's exit code for that; anything else says that the tests could not be run."""
_SCRIPT = Path(__file__).with_name("in_copy.py")
_PROCESSES = multiprocessing.get_context(
    "forkserver" if "forkserver" in multiprocessing.get_all_start_methods() else "spawn"
)
_PROCESSES.set_forkserver_preload(["amaranth.sim", "hypothesis", "numpy", "pytest", "skimage.data"])


@dataclass(frozen=True)
class Mutation:
    """A change of one place, and the few fast tests that must see it.

    Parameters
    ----------
    file
        Source to change.
    old, new
        Text that occurs exactly once in it, and what takes its place.
    tests
        File of tests.
    only
        pytest's ``-k``: which of them.
    """

    file: str
    old: str
    new: str
    tests: str
    only: str = ""


def copy_sources(folder: Path) -> None:
    for name in COPIED:
        if (ROOT / name).is_dir():
            # with what Python has compiled, which takes longer than most of these tests; not with
            # what it just writes
            shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("*.pyc.*"))
        else:
            shutil.copy(ROOT / name, folder / name)


def change(path: Path, text: str) -> None:
    """Replace a source, and remove its compiled file, which could still look valid."""
    path.write_text(text, encoding="utf-8")
    for compiled in path.parent.glob(f"__pycache__/{path.stem}.*"):
        compiled.unlink()


def run_tests(folder: Path, files: list[str], only: str = "") -> tuple[int | None, str]:
    """pytest in the copy, on the copy's modules: its exit code, and its output.

    The process is a fork of one that has imported the other packages, because importing them takes
    longer than most of these tests. It ends with the process that has asked for it.
    """
    options = ["-x", "-q", "-p", "no:cacheprovider", *PLUGINS, *(["-k", only] if only else [])]
    output = folder / "output.txt"
    names = {"FOLDER": str(folder), "OUTPUT": str(output), "ARGUMENTS": [*options, *files]}
    process = _PROCESSES.Process(target=runpy.run_path, args=(str(_SCRIPT), names))
    process.start()
    process.join(TIMEOUT)
    process.kill()
    process.join()
    return process.exitcode, output.read_text(encoding="utf-8") if output.exists() else ""
