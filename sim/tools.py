"""Runs other programs, and leaves none of their processes and temporary files behind."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from sim.cache import user_caches


def run(
    command: Sequence[str],
    *,
    folder: Path | None = None,
    text: str | None = None,
    environment: Mapping[str, str] | None = None,
) -> subprocess.CompletedProcess[str]:
    """Run a program to its end; its output is captured.

    Parameters
    ----------
    folder
        Where it runs, and leaves temporary files.
    text
        The program's standard input, by default empty.
    environment
        Variables in addition to those of this process.

    Raises
    ------
    OSError
        The program cannot be started.
    """
    variables = {**os.environ, "XDG_CACHE_HOME": str(user_caches()), **(environment or {})}
    if folder is not None:
        variables["TMPDIR"] = str(folder.resolve())
    process = subprocess.Popen(
        command,
        cwd=folder,
        env=variables,
        stdin=subprocess.DEVNULL if text is None else subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        # compilers start programs of their own: Ctrl-C ends all of them, and through us alone
        start_new_session=True,
    )
    with process:
        try:
            output, errors = process.communicate(text)
        except BaseException:
            _end(process)
            raise
    return subprocess.CompletedProcess(command, process.returncode, output, errors)


def _end(process: subprocess.Popen[str]) -> None:
    if hasattr(os, "killpg"):
        os.killpg(process.pid, signal.SIGKILL)
    else:  # pragma: no cover
        process.kill()
