"""make's variables: one that changes nothing is refused."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="there is no make")
ROOT = Path(__file__).parents[1]


def make(*arguments: str) -> subprocess.CompletedProcess[str]:
    # a make that runs the tests hands its own variables on
    environment = {name: value for name, value in os.environ.items() if "MAKE" not in name}
    command = ["make", "--dry-run", *arguments]
    return subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)


@pytest.mark.parametrize(
    ("arguments", "name", "allowed"),
    [
        (["run", "PROFILE=robust"], "PROFILE", "ARGS BUILD CORNERSTREAM_CACHE CXX IMAGE PYTHON VENV"),
        (["run", "image=x.png"], "image", "ARGS BUILD CORNERSTREAM_CACHE CXX IMAGE PYTHON VENV"),
        (["IMAGE=a b.png", "Q=1"], "Q", "ARGS BUILD CORNERSTREAM_CACHE CXX IMAGE PYTHON VENV"),
        (["synth", "IMAGE=x.png"], "IMAGE", "ARGS BUILD CORNERSTREAM_CACHE CXX PYTHON VENV"),
        (["verilog", "ARGS=--profile robust"], "ARGS", "BUILD CORNERSTREAM_CACHE CXX PYTHON VENV"),
    ],
)
def test_a_variable_that_changes_nothing(arguments: list[str], name: str, allowed: str) -> None:
    done = make(*arguments)
    assert (done.returncode, done.stdout) == (2, "")
    (line,) = done.stderr.splitlines()
    assert f"*** {name} changes nothing in 'make " in line and f"; allowed: {allowed}." in line


@pytest.mark.parametrize(
    ("arguments", "command"),
    [
        (
            ["run", "IMAGE=a b.png", "ARGS=--profile robust --sigma1=0.1 Q=1"],
            'simulate "a b.png" --output build  --profile robust --sigma1=0.1 Q=1\n',
        ),
        (["run"], "simulate  --output build --profile robust --profile paper \n"),
        (["compare", "ARGS=--quick"], "cornerstream compare --quick\n"),
        (["export"], "cornerstream quartus export --output build/quartus --force \n"),
        (["clean", "BUILD=elsewhere"], "rm -rf elsewhere\n"),
        # in a folder that is not there, so that there is something to be done
        (
            ["verilog", "PYTHON=python3.11", "CXX=g++ -m64", "BUILD=elsewhere"],
            "cornerstream verilog -o elsewhere/cornerstream.v",
        ),
    ],
)
def test_variables_that_change_something(arguments: list[str], command: str) -> None:
    done = make(*arguments)
    assert done.returncode == 0 and command in done.stdout
