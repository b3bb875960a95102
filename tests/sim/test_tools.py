"""Other programs end with us."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from sim import tools
from tests.support.processes import wait_for_end, wait_for_number

CHILDREN = "echo $$ > first; sh -c 'echo $$ > second; sleep 60'; true"


def test_tools_and_what_they_started_end_with_us(tmp_path: Path) -> None:
    script = (
        # whoever started the tests may have it ignored
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler);"
        "from pathlib import Path; from sim.tools import run;"
        f"run(['sh', '-c', {CHILDREN!r}], folder=Path('.'))"
    )
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.DEVNULL) as process:
        numbers = [wait_for_number(tmp_path / name) for name in ("first", "second")]
        process.send_signal(2)
    for number in numbers:
        wait_for_end(number)


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C raises, whatever those who started the tests have it do."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_a_signal_while_a_tool_is_being_started_ends_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Interrupted(subprocess.Popen[str]):
        def __init__(self, *arguments: Any, **more: Any) -> None:
            super().__init__(*arguments, **more)
            numbers.append(self.pid)
            signal.raise_signal(signal.SIGINT)

    numbers: list[int] = []
    monkeypatch.setattr(subprocess, "Popen", Interrupted)
    with pytest.raises(KeyboardInterrupt):
        tools.run(["sleep", "60"], folder=tmp_path)
    wait_for_end(*numbers)


@pytest.mark.usefixtures("interruptible")
def test_a_second_signal_does_not_save_a_tool(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def again(number: int, which: int) -> None:
        numbers.append(number)
        signal.raise_signal(signal.SIGINT)
        killpg(number, which)

    numbers: list[int] = []
    killpg, handler = os.killpg, signal.getsignal(signal.SIGALRM)
    monkeypatch.setattr(os, "killpg", again)
    signal.signal(signal.SIGALRM, lambda *_: signal.raise_signal(signal.SIGINT))
    signal.setitimer(signal.ITIMER_REAL, 0.3)
    try:
        with pytest.raises(KeyboardInterrupt):
            tools.run(["sleep", "60"], folder=tmp_path)
    finally:
        signal.signal(signal.SIGALRM, handler)
    wait_for_end(*numbers)


def test_input_and_output_larger_than_a_pipe(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tools, "PATIENCE", 0.001)
    text = "corner\n" * 100_000
    assert tools.run(["sh", "-c", "sleep 0.1; cat"], text=text).stdout == text
