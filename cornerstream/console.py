"""Output to the terminal: results on stdout, everything else on stderr."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path

import click
from rich.console import Console
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    SpinnerColumn,
    TextColumn,
    TimeRemainingColumn,
)
from rich.table import Table

from cornerstream.errors import printable
from cornerstream.images import Photograph

# names that users give must not be read as markup
out = Console(markup=False)
_ANY_WIDTH = 10_000
"""More than any table takes."""


def remarks(photograph: Photograph) -> None:
    """One line for each conversion that the image needed."""
    for remark in photograph.remarks:
        say(f"{photograph.name}: {remark}")


def say(line: str) -> None:
    """A line for the user that is not a result; the command goes on if stderr is closed."""
    with suppress(OSError):
        click.echo(printable(line), err=True)


def advise(line: str | None) -> None:
    """A line of advice, if there is one."""
    if line is not None:
        say(line)


def files_written(paths: list[Path]) -> None:
    """Name the files that were written."""
    say(f"Written: {', '.join(map(str, paths))}")


def size(of: float) -> str:
    """A number of bytes, for people."""
    return f"{of / 1e6:.0f} MB" if of >= 1e7 else f"{of / 1e6:.1f} MB"


def show(table: Table) -> None:
    """A table of results.

    In a file or pipe, it is as wide as its text; in a narrow terminal, it has no blanks beside it.
    """
    wanted = out.measure(table, options=out.options.update(width=_ANY_WIDTH)).maximum
    if not out.file.isatty():
        Console(file=out.file, width=wanted, markup=False).print(table)
        return
    if wanted > out.width:
        table.padding = 0
    out.print(table)


@contextmanager
def activity(text: str) -> Iterator[None]:
    """Show that something of unknown length is going on; nothing if stderr is not a terminal."""
    console = Console(stderr=True)
    # where there is none, early versions of rich leave an empty line
    with console.status(text) if console.is_terminal else nullcontext():
        yield


@contextmanager
def progress(text: str, total: int) -> Iterator[Callable[[int], None]]:
    """A bar on stderr, moved by calling the result with the steps done so far.

    It shows nothing if stderr is not a terminal.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        # rich would end a bar that nobody sees with an empty line
        yield lambda done: None
        return
    columns = (
        SpinnerColumn(),
        TextColumn("{task.description}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bar:
        # the time before the first step, such as compiling, must not spoil the estimate
        task = bar.add_task(text, total=total, start=False)

        def advance(done: int) -> None:
            bar.start_task(task)
            bar.update(task, completed=done)

        yield advance
