"""A hook of MkDocs: the page of the commands gets what each prints with ``--help``."""

from __future__ import annotations

from collections.abc import Iterator

import click

from cornerstream.cli import main

PLACE = "<!-- help of all commands -->"


def helps(
    command: click.Command, name: str, parent: click.Context | None = None
) -> Iterator[tuple[str, str]]:
    """Name and help of the command and of all below it, in the order in which they are listed."""
    context = click.Context(command, info_name=name, parent=parent, **command.context_settings)
    yield context.command_path, command.get_help(context)
    if isinstance(command, click.Group):
        for each in command.list_commands(context):
            child = command.get_command(context, each)
            if child is not None:
                yield from helps(child, each, context)


def on_page_markdown(markdown: str, **_: object) -> str:
    if PLACE not in markdown:
        return markdown
    sections = (f"## {name}\n\n```text\n{text}\n```" for name, text in helps(main, "cornerstream"))
    return markdown.replace(PLACE, "\n\n".join(sections))
