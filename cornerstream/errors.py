"""Errors as the user sees them: one line on stderr, and an exit code."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import IO, Any

import click


def printable(text: str) -> str:
    """The text on one line: names of files may hold line breaks and undecodable bytes."""
    return "".join(char if char.isprintable() else char.encode("unicode_escape").decode() for char in text)


class Ended(click.ClickException):
    """The end of a command: one line on stderr, if that is open, and an exit code."""

    def show(self, file: IO[Any] | None = None) -> None:
        with suppress(OSError):
            super().show(file)


class BadInput(Ended):
    """The user's input cannot be used; the message says what is allowed. Exit code 2."""

    exit_code = 2

    def __init__(self, message: str) -> None:
        super().__init__(printable(message))


class Failed(Ended):
    """The run itself failed. Exit code 1."""

    exit_code = 1


class Interrupted(Ended):
    """Ctrl-C. Exit code 130, as shells have it: 128 and the number of the signal."""

    exit_code = 130

    def __init__(self) -> None:
        super().__init__("interrupted")


@contextmanager
def bad_input() -> Iterator[None]:
    """Turn a ``ValueError`` or ``TypeError`` about what the user gave into :class:`BadInput`."""
    try:
        yield
    except (ValueError, TypeError) as error:
        raise BadInput(one_line(error)) from error


def one_line(error: Exception) -> str:
    """The message of an exception on a single line."""
    return " ".join(str(error).split()) or type(error).__name__


def reason(error: OSError) -> str:
    """Why the operating system refused, without number and path."""
    return error.strerror or one_line(error)


@contextmanager
def _in_one_line() -> Iterator[None]:
    """Turn any exception that ends a command into a line and an exit code."""
    try:
        yield
    except click.UsageError as error:
        # click would print the usage above the message
        help_hint = f" (see '{error.ctx.command_path} --help')" if error.ctx else ""
        raise BadInput(error.format_message().rstrip(".") + help_hint) from error
    except KeyboardInterrupt as error:
        raise Interrupted from error
    except BrokenPipeError:
        # the reader has seen enough; click ends silently
        raise
    except OSError as error:
        # stdout has no name: the disk behind it may be full
        raise Failed(f"{error.filename or 'the output'}: {reason(error)}") from error


class OneLineGroup(click.Group):
    """A group of commands, in which every error ends in one line.

    Without arguments, it shows its help.
    """

    def make_context(
        self, info_name: str | None, args: list[str], parent: click.Context | None = None, **extra: Any
    ) -> click.Context:
        with _in_one_line():
            return super().make_context(info_name, args or ["--help"], parent, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        with _in_one_line():
            result = super().invoke(ctx)
            # here an error can still be reported
            sys.stdout.flush()
            return result
