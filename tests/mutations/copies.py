"""A copy of the sources, one place of it made wrong, and tests run on it."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("golden", "hdl", "sim", "tests", "pyproject.toml")
PLUGINS = ("-p", "_hypothesis_pytestplugin")
"""The only one that these tests need: looking for others takes as long as many a test."""
TESTS_FAILED = 1
"""pytest's exit code for that; anything else says that the tests could not be run."""


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
    """Make a source another one, whatever time it is and however long: what was compiled of it
    goes.
    """
    path.write_text(text, encoding="utf-8")
    for compiled in path.parent.glob(f"__pycache__/{path.stem}.*"):
        compiled.unlink()


def run_tests(folder: Path, files: list[str], only: str = "") -> subprocess.CompletedProcess[str]:
    """pytest in the copy, on the copy's modules."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    # simulators are kept by what they are made of: in one place, for all of us and all copies
    environment |= {"PYTHONPATH": str(folder), "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"}
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", *PLUGINS]
    command += ["-k", only] * bool(only) + files
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=300
    )
