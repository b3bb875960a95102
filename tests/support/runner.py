"""click's runner of commands, with stdout and stderr apart in every version that is allowed."""

from __future__ import annotations

import inspect
from typing import Any

import click.testing


class CliRunner(click.testing.CliRunner):
    def __init__(self, **options: Any) -> None:
        # until 8.1 they were one unless told otherwise; since 8.2 nobody can tell otherwise
        if "mix_stderr" in inspect.signature(click.testing.CliRunner).parameters:
            options["mix_stderr"] = False
        super().__init__(**options)
