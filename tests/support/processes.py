"""Processes that are to end."""

from __future__ import annotations

import time
from pathlib import Path


def wait_for_number(file: Path) -> int:
    """The number of a process, which it writes itself."""
    deadline = time.monotonic() + 60
    while not (file.exists() and file.read_text().endswith("\n")):
        assert time.monotonic() < deadline, f"{file} was not written"
        time.sleep(0.02)
    return int(file.read_text())


def wait_for_end(number: int) -> None:
    """AssertionError if it does not end soon."""
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline:
        status = Path("/proc", str(number), "stat")
        try:
            # a zombie has ended; whoever inherits it says so when it pleases
            if status.read_text().rpartition(")")[2].split()[0] == "Z":
                return
        except OSError:
            return
        time.sleep(0.02)
    raise AssertionError(f"process {number} still runs")
