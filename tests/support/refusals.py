"""What a command refuses: exit code 2, one line with the value and what is allowed, no output."""

from __future__ import annotations

from pathlib import Path

from click.testing import Result

from cornerstream.cli import main
from tests.support.runner import CliRunner


def listing(folder: Path) -> list[str]:
    return sorted(str(path) for path in folder.rglob("*"))


def run(*arguments: str, env: dict[str, str | None] | None = None) -> Result:
    return CliRunner(env=env).invoke(main, arguments, prog_name="cornerstream")


def check(result: Result, *parts: str) -> None:
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    lines = result.stderr.splitlines()
    assert len(lines) == 1 and lines[0].startswith("Error: ")
    for part in parts:
        assert part in lines[0]
