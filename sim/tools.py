"""Runs other programs, and leaves none of their processes and temporary files behind."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryFile

from sim.cache import user_caches

SIGNALS = (signal.SIGINT, signal.SIGTERM)
"""By which we are asked to end."""
PATIENCE = 0.1
"""Seconds until a signal is looked at."""


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
    with _waiting_signals() as waiting, TemporaryFile("w+", encoding="utf-8") as given:
        given.write(text or "")
        given.seek(0)
        process = subprocess.Popen(
            command,
            cwd=folder,
            env=variables,
            # a file, because a pipe's rest is lost where we look at signals in between
            stdin=given,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            errors="replace",
            # compilers start programs of their own: Ctrl-C ends all of them, and through us alone
            start_new_session=True,
        )
        with process:
            try:
                output, errors = _communicate(process, waiting)
            except BaseException:
                _end(process)
                raise
    return subprocess.CompletedProcess(command, process.returncode, output, errors)


@contextmanager
def _waiting_signals() -> Iterator[list[int]]:
    """Context in which signals whose handler may raise only wait in the list; they come at its end.

    So none can come between a program's start and the line that would end it, nor while it is being
    ended.
    """
    waiting: list[int] = []
    # handlers run in the main thread, and nobody else may change them
    numbers = SIGNALS if threading.current_thread() is threading.main_thread() else ()
    before = {number: handler for number in numbers if callable(handler := signal.getsignal(number))}
    for number in before:
        signal.signal(number, lambda arrived, _: waiting.append(arrived))
    try:
        yield waiting
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
        for arrived in waiting:
            signal.raise_signal(arrived)


def _communicate(process: subprocess.Popen[str], waiting: list[int]) -> tuple[str, str]:
    """What the program printed, up to its end, or up to ours."""
    while True:
        try:
            return process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            if waiting:
                _end(process)


def _end(process: subprocess.Popen[str]) -> None:
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
    else:  # pragma: no cover
        process.kill()
