"""``cornerstream`` as a process of its own: ``python -m cornerstream``.

This module does what no command can do for itself. It handles a signal that comes while modules are
still being imported, and output that fails when the process ends.
"""

from __future__ import annotations

import io
import os
import signal
import sys
import traceback
import warnings
from types import FrameType
from typing import NoReturn

from cornerstream.rooms import ShadowedError, check_rooms


def main() -> NoReturn:
    """Run the command line; the process ends with one line at most, and one of its exit codes."""
    for ending in (signal.SIGTERM, getattr(signal, "SIGHUP", signal.SIGTERM)):
        # nohup asks that the signal be ignored
        if signal.getsignal(ending) is signal.SIG_DFL:
            signal.signal(ending, _end)
    _mend_standard_streams()
    code: int | str | None = 0
    try:
        check_rooms()
        from cornerstream.cli import main as command

        command(prog_name="cornerstream")
    except BaseException as error:
        # a warning about designs that an interruption left unfinished tells nothing new
        warnings.simplefilter("ignore")
        code = _exit_code(error)
    # what is left to do is Python's, which would answer with a traceback
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    _drop_what_cannot_be_written()
    sys.exit(code)


def _mend_standard_streams() -> None:
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        if stream is None:
            # closed by whoever called
            setattr(sys, name, open(os.devnull, "w", encoding="utf-8"))
        elif isinstance(stream.buffer, io.RawIOBase):
            # with PYTHONUNBUFFERED, Python forgets what a pipe or a disk has not taken at once
            setattr(sys, name, open(stream.fileno(), "w", 1, stream.encoding, closefd=False))


def _end(number: int, frame: FrameType | None) -> NoReturn:
    # as an exception, so that temporary files are removed and tools that run are ended
    raise SystemExit(128 + number)


def _exit_code(error: BaseException) -> int | str | None:
    if isinstance(error, SystemExit):
        return error.code
    if isinstance(error, KeyboardInterrupt):
        return 128 + signal.SIGINT
    if isinstance(error, ShadowedError):
        print(f"Error: {error}", file=sys.stderr)
        return 2
    if os.environ.get("CORNERSTREAM_TRACEBACK"):
        traceback.print_exception(error)
    else:
        what = " ".join(f"{type(error).__name__}: {error}".split())
        print(
            f"Error: {what} (a fault of cornerstream; CORNERSTREAM_TRACEBACK=1 shows where)", file=sys.stderr
        )
    return 1


def _drop_what_cannot_be_written() -> None:
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            # or Python would try once more at its end, and complain
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


if __name__ == "__main__":
    main()
