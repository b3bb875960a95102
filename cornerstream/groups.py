"""Options in groups: ``--help`` lists those that everybody uses first."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import click

Command = TypeVar("Command", bound=Callable[..., Any])

MAIN = "Main options"
THRESHOLDS = "Thresholds"
FRAME = "Frame size and formats"
ALGORITHM = "Algorithm (the default of each is the profile's)"
HARDWARE = "Hardware (records stay the same)"
SIMULATOR = "Simulator"
OTHER = "Other"
_ORDER = (MAIN, THRESHOLDS, FRAME, ALGORITHM, HARDWARE, SIMULATOR, OTHER)


class _Option(click.Option):
    def __init__(self, *args: Any, group: str = OTHER, **attributes: Any) -> None:
        super().__init__(*args, **attributes)
        self.group = group


class GroupedCommand(click.Command):
    """A command whose help lists its options by group, in the order of importance."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        listed: dict[str, list[tuple[str, str]]] = {group: [] for group in _ORDER}
        for parameter in self.get_params(ctx):
            # an argument is explained above the options
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                listed[getattr(parameter, "group", OTHER)].append(record)
        for group, records in listed.items():
            if records:
                with formatter.section(group):
                    formatter.write_dl(records, col_max=26)


def option(group: str, *names: str, **attributes: Any) -> Callable[[Command], Command]:
    """``click.option`` of a group; for commands of the class :class:`GroupedCommand`."""
    return click.option(*names, cls=_Option, group=group, **attributes)


def together(*decorators: Callable[[Command], Command]) -> Callable[[Command], Command]:
    """Several options as one decorator, in this order."""

    def decorate(command: Command) -> Command:
        for each in reversed(decorators):
            command = each(command)
        return command

    return decorate
