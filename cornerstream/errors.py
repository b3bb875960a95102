"""Errors as the user sees them: one line on stderr, and an exit code."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import click


class BadInput(click.ClickException):
    """Something the user gave cannot be used; the message names it and what is allowed. Exit code 2."""

    exit_code = 2


class Failed(click.ClickException):
    """The run itself failed. Exit code 1."""

    exit_code = 1


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
def _usage_in_one_line() -> Iterator[None]:
    try:
        yield
    except click.exceptions.NoArgsIsHelpError:
        raise
    except click.UsageError as error:
        # click would print the usage above the message
        help_hint = f" (see '{error.ctx.command_path} --help')" if error.ctx else ""
        raise BadInput(error.format_message().rstrip(".") + help_hint) from error


class OneLineGroup(click.Group):
    """A group of commands whose usage errors take one line, too."""

    def make_context(self, *args: Any, **extra: Any) -> click.Context:
        with _usage_in_one_line():
            return super().make_context(*args, **extra)

    def invoke(self, ctx: click.Context) -> Any:
        with _usage_in_one_line():
            return super().invoke(ctx)
