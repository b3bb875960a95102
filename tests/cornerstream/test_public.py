"""The one public package: what it offers, when it imports it, and what it says if it cannot."""

from __future__ import annotations

import ast
import inspect
import os
import subprocess
import sys
from pathlib import Path

import pytest

import cornerstream
from cornerstream.rooms import ROOMS, ROOT

OTHERS = "raise RuntimeError('somebody else')\n"


def run(*arguments: str, folder: Path, path: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Python in a folder, with ours on its path, behind another if there is one."""
    path_list = [str(each) for each in (path, ROOT) if each is not None]
    return subprocess.run(
        [sys.executable, *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(path_list)},
        capture_output=True,
        text=True,
    )


@pytest.mark.parametrize("name", cornerstream.__all__)
def test_public_names_are_there_and_documented(name: str) -> None:
    value = getattr(cornerstream, name)
    if callable(value):
        text = inspect.getdoc(value)
        # what dataclasses make up is only the signature
        assert text and not text.startswith(f"{name}(")
    assert name in dir(cornerstream)


def test_editors_see_the_same_names() -> None:
    assert cornerstream.__file__ is not None
    tree = ast.parse(Path(cornerstream.__file__).read_text(encoding="utf-8"))
    (block,) = (node for node in tree.body if isinstance(node, ast.If))
    imports = [node for node in block.body if isinstance(node, ast.ImportFrom)]
    seen = {alias.asname or alias.name: str(node.module) for node in imports for alias in node.names}
    assert seen.pop("__version__") == "golden.version"
    assert seen == cornerstream._HOME
    assert sorted([*seen, "__version__"]) == sorted(cornerstream.__all__)


def test_names_that_are_not_there() -> None:
    with pytest.raises(AttributeError, match="module 'cornerstream' has no attribute 'corners'"):
        cornerstream.corners  # noqa: B018


def test_nothing_is_imported_before_it_is_used(tmp_path: Path) -> None:
    script = (
        "import sys, cornerstream; slow = {'numpy', 'amaranth'}; print(slow & set(sys.modules));"
        "from cornerstream import Build; print(slow & set(sys.modules))"
    )
    done = run("-c", script, folder=tmp_path)
    assert (done.stdout, done.stderr) == ("set()\n{'numpy'}\n", "")


def other(folder: Path, name: str, kind: str) -> Path:
    """Somebody else's module of that name; what Python finds of it."""
    if kind == "file":
        found = folder / f"{name}.py"
    else:
        found = folder / name / ("__init__.py" if kind == "package" else "mine.py")
        found.parent.mkdir()
    found.write_text(OTHERS)
    return found


@pytest.mark.parametrize("name", ROOMS)
@pytest.mark.parametrize("kind", ["file", "package"])
def test_a_module_of_somebody_else(name: str, kind: str, tmp_path: Path) -> None:
    found = other(tmp_path, name, kind)
    message = (
        f"{name} is {found}, which hides cornerstream's own package {ROOT / name}; "
        "rename it, or run where it is not on Python's path (current folder, PYTHONPATH)"
    )
    done = run("-m", "cornerstream", "--version", folder=tmp_path)
    assert (done.stdout, done.stderr, done.returncode) == ("", f"Error: {message}\n", 2)


@pytest.mark.parametrize("line", ["from cornerstream import detect", "import cornerstream as c; c.Build"])
def test_a_module_of_somebody_else_in_a_program(line: str, tmp_path: Path) -> None:
    (tmp_path / "path").mkdir()
    found = other(tmp_path / "path", "golden", "file")
    done = run("-c", line, folder=tmp_path, path=tmp_path / "path")
    *traceback, last = done.stderr.splitlines()
    assert done.returncode == 1 and last.startswith(
        f"cornerstream.rooms.ShadowedError: golden is {found}, which hides cornerstream's own package"
    )
    assert len([each for each in traceback if each.startswith("  File ")]) <= 4


def test_a_module_of_somebody_else_that_is_already_imported(tmp_path: Path) -> None:
    found = other(tmp_path, "hdl", "file")
    found.write_text("")
    script = "import hdl, sys; del sys.path[0]; from cornerstream import detect"
    done = run("-c", script, folder=tmp_path)
    assert f"hdl is {found}, which hides" in done.stderr.splitlines()[-1]


def test_a_folder_without_init_hides_nothing_on_the_path(tmp_path: Path) -> None:
    other(tmp_path, "hdl", "folder")
    done = run("-m", "cornerstream", "--version", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")


def test_a_folder_without_init_hides_nothing_where_cornerstream_is_installed(tmp_path: Path) -> None:
    """A project with folders hdl and sim: programs in it import cornerstream all the same.

    Fails also where the editable install is older than pyproject.toml: install it anew.
    """
    for name in ROOMS:
        other(tmp_path, name, "folder")
    script = "from cornerstream import AxiCore, detect, make_engine; print('found')"
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert (done.stdout, done.stderr, done.returncode) == ("found\n", "", 0)


def test_a_folder_without_init_that_was_found_first(tmp_path: Path) -> None:
    folder = other(tmp_path, "hdl", "folder").parent
    script = (
        "import sys; path = sys.path[:]; sys.path[:] = path[:1]; import hdl;"
        f"sys.path[:] = [{str(ROOT)!r}, *path]; from cornerstream import detect"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True)
    assert f"hdl is {folder}, which hides" in done.stderr.splitlines()[-1]
