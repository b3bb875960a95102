"""The command as a process: output that nobody takes, signals, and Python's own end."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

import cornerstream.detection
import cornerstream.verilog
from cornerstream.cli import main
from tests.support.runner import CliRunner

ROOT = Path(__file__).parents[2]
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
COMMAND = (sys.executable, "-m", "cornerstream")


def start(*arguments: str, **more: object) -> subprocess.Popen[str]:
    return subprocess.Popen([*COMMAND, *arguments], env=ENVIRONMENT, text=True, **more)  # type: ignore[call-overload]


def test_without_arguments_help_is_shown() -> None:
    result = CliRunner().invoke(main, [], prog_name="cornerstream")
    assert result.exit_code == 0 and result.stdout.startswith("Usage: cornerstream")


@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_reader_that_leaves(unbuffered: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(ENVIRONMENT, "PYTHONUNBUFFERED", unbuffered)
    # more than a pipe holds: the help of all commands, without any work
    script = (
        "import cornerstream.__main__ as m, cornerstream.cli as c, click;"
        "c.main.callback = lambda: click.echo('x' * 300_000);"
        "c.main.invoke_without_command = True; import sys; sys.argv[1:] = ['detect', 'nosuch.png']; m.main()"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", script],
        env=ENVIRONMENT,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None and process.stderr is not None
    assert process.stdout.read(1) == "x"
    process.stdout.close()
    assert (process.stderr.read(), process.wait()) == ("", 1)
    process.stderr.close()


@pytest.mark.parametrize(
    ("stream", "arguments", "said", "code"),
    [
        ("stdout", ["--version"], "Error: the output: No space left on device\n", 1),
        ("stderr", ["detect", "nosuch.png"], "", 2),
    ],
)
def test_a_full_disk(stream: str, arguments: list[str], said: str, code: int) -> None:
    other = "stderr" if stream == "stdout" else "stdout"
    with open("/dev/full", "wb") as full:
        process = start(*arguments, **{stream: full, other: subprocess.PIPE})
        assert (process.communicate()[other == "stderr"], process.returncode) == (said, code)


@pytest.mark.parametrize(("error", "code"), [(KeyboardInterrupt(), 130), (OSError(28, "Disk full", "x"), 1)])
def test_what_may_come_at_any_moment(
    error: BaseException, code: int, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def fail(*rest: object) -> None:
        raise error

    monkeypatch.setattr(cornerstream.verilog, "emit_verilog", fail)
    result = CliRunner().invoke(main, ["verilog", "-o", str(tmp_path / "core.v")])
    assert result.exit_code == code and result.stdout == ""
    assert result.stderr == ("Error: interrupted\n" if code == 130 else "Error: x: Disk full\n")
    assert os.listdir(tmp_path) == []
