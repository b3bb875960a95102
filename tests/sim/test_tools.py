"""Other programs end with us."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

from tests.support.processes import wait_for_end, wait_for_number

CHILDREN = "echo $$ > first; sh -c 'echo $$ > second; sleep 60'; true"


def test_tools_and_what_they_started_end_with_us(tmp_path: Path) -> None:
    script = f"from pathlib import Path; from sim.tools import run; run(['sh', '-c', {CHILDREN!r}], folder=Path('.'))"
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2])}
    command = [sys.executable, "-c", script]
    with subprocess.Popen(command, cwd=tmp_path, env=environment, stderr=subprocess.DEVNULL) as process:
        numbers = [wait_for_number(tmp_path / name) for name in ("first", "second")]
        process.send_signal(2)
    for number in numbers:
        wait_for_end(number)
