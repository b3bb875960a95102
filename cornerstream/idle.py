"""Options that would change nothing are refused in one line, so that none is ignored silently."""

from __future__ import annotations

from typing import NamedTuple

import click
from click.core import ParameterSource

from cornerstream.errors import BadInput


class Idle(NamedTuple):
    """One option: the name of its parameter, whether it changes nothing, and what it needs."""

    parameter: str
    changes_nothing: bool
    allowed: str


def refuse_idle(*rules: Idle) -> None:
    """:class:`BadInput` for the first option that was typed and changes nothing.

    A value that equals the default is allowed. Options that the current command does not have are
    passed over, so that commands can share rules.
    """
    context = click.get_current_context()
    options = {each.name: each for each in context.command.params if isinstance(each, click.Option)}
    for name, changes_nothing, allowed in rules:
        option = options.get(name)
        if option is None or not changes_nothing:
            continue
        value = context.params[name]
        typed = context.get_parameter_source(name) is not ParameterSource.DEFAULT
        if typed and value != option.get_default(context):
            said = "set" if option.is_flag else ", ".join(map(str, value)) if option.multiple else value
            raise BadInput(f"{option.opts[0]} is {said}, which changes nothing; allowed: {allowed}")
