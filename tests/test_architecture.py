"""The architecture: imports point downwards, without a circle; no file is too long."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
BELOW: dict[str, set[str]] = {
    "golden": set(),
    "hdl": {"golden"},
    "sim": {"golden", "hdl"},
    "flow": {"golden", "hdl", "sim"},
    "evaluation": {"golden", "hdl", "sim", "flow"},
    "cornerstream": {"golden", "hdl", "sim", "flow", "evaluation"},
}
FILES = [path for folder in BELOW for path in sorted((ROOT / folder).rglob("*.py"))]
LONGEST = 400


def imports(path: Path) -> Iterator[tuple[str, str]]:
    """The modules that a file imports, anywhere in it, each with a name taken from it, or ""."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from ((node.module, alias.name) for alias in node.names)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_imports_point_downwards(path: Path) -> None:
    folder = path.relative_to(ROOT).parts[0]
    imported = {module.partition(".")[0] for module, _ in imports(path)}
    assert imported & set(BELOW) <= BELOW[folder] | {folder}


def module_name(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imported_modules(path: Path, modules: set[str]) -> set[str]:
    """Modules of the project that a file imports; a package stands for its own file."""
    inner = ((module, f"{module}.{name}") for module, name in imports(path))
    return {each if each in modules else module for module, each in inner} & modules


def test_imports_make_no_circle() -> None:
    modules = {module_name(path) for path in FILES}
    graph = {module_name(path): imported_modules(path, modules) - {module_name(path)} for path in FILES}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(ROOT)))
def test_files_stay_short(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= LONGEST


def test_each_box_of_fig_9_is_one_file_in_golden_and_in_hdl() -> None:
    boxes = {"preprocessing", "convolution", "square_root", "response", "corner_detection", "texture_filter"}
    boxes |= {"subpixel", "divider", "output_constructor", "thresholds", "detector"}
    for folder in ("golden", "hdl"):
        assert boxes <= {path.stem for path in (ROOT / folder).glob("*.py")}
