"""Running commands, with stdout and stderr apart in every version of click that is allowed."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any

import click.testing

from cornerstream.cli import main


class CliRunner(click.testing.CliRunner):
    def __init__(self, **options: Any) -> None:
        # until 8.1 they were one unless told otherwise; since 8.2 nobody can tell otherwise
        if "mix_stderr" in inspect.signature(click.testing.CliRunner).parameters:
            options["mix_stderr"] = False
        super().__init__(**options)


def run(*arguments: str, code: int = 0) -> click.testing.Result:
    """``cornerstream`` with these arguments, which ends with this exit code."""
    result = CliRunner().invoke(main, arguments, prog_name="cornerstream")
    assert result.exit_code == code, result.output
    return result


def run_or_refuse(*arguments: str, code: int = 0) -> click.testing.Result:
    """:func:`run`; what fails says why in one line, and bad input says nothing else."""
    result = run(*arguments, code=code)
    if code:
        assert code == 1 or result.stdout == ""
        assert result.stderr.startswith("Error: ") and result.stderr.count("\n") == 1
    return result


def contents(folder: Path) -> dict[str, str]:
    """Text of all files in a folder, by path."""
    return {str(path.relative_to(folder)): path.read_text() for path in folder.rglob("*") if path.is_file()}
