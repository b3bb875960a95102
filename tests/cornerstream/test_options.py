"""Options are made from the fields of the dataclasses, and ``--help`` lists them by group."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import click
import pytest

from cornerstream import groups
from cornerstream.cli import main
from cornerstream.options import options_of_fields
from golden import Settings
from golden.algorithm import Algorithm
from golden.options import option, options
from hdl.build import Build
from tests.support.runner import CliRunner


@dataclass(frozen=True)
class MadeUp:
    """Fields of each kind."""

    kind: Literal["one", "two"] = option("one", "Which of two.")
    only: Literal["this"] = option("this", "No choice.")
    row_count: int = option(3, "How many rows, 1 to 9.", low=1, high=9)
    switch: bool = option(False, "On or off.")


def test_a_field_is_all_that_an_option_takes() -> None:
    seen: dict[str, object] = {}

    @click.command(cls=groups.GroupedCommand)
    @options_of_fields(groups.ALGORITHM, MadeUp, options(MadeUp), by_default=False)
    def command(**given: object) -> None:
        seen.update(given)

    shown = CliRunner().invoke(command, ["--help"]).output
    for part in ("--kind [one|two]", "Which of two.", "--row-count N", "How many rows, 1 to 9.", "--switch"):
        assert part in shown
    assert "--only" not in shown
    assert CliRunner().invoke(command, ["--kind", "two", "--row-count", "4", "--switch"]).exit_code == 0
    assert seen == {"kind": "two", "row_count": 4, "switch": True}
    assert CliRunner().invoke(command, ["--kind", "three"]).exit_code == 2


def listed(command: str) -> dict[str, click.Parameter]:
    return {parameter.name or "": parameter for parameter in main.commands[command].params}


@pytest.mark.parametrize("command", ["verilog", "package", "synth"])
def test_commands_of_the_core_have_all_fields(command: str) -> None:
    for name, field in {**options(Algorithm), **options(Build)}.items():
        assert (name in listed(command)) == (len(field.choices) != 1), name


@pytest.mark.parametrize("command", ["detect", "simulate"])
def test_commands_with_an_image_have_all_settings(command: str) -> None:
    """Both sides of a cell are one option."""
    missing = set(options(Settings)) - set(listed(command))
    assert missing == {"report_rejected", "cell_width", "cell_height"} and "cell" in listed(command)


@pytest.mark.parametrize("command", ["", "bench", "compare", "eval", "quartus", "quartus report"])
def test_help_fits_into_80_columns(command: str) -> None:
    words = [*command.split(), "--help"]
    result = CliRunner().invoke(main, words, prog_name="cornerstream", terminal_width=80)
    assert result.exit_code == 0 and max(map(len, result.stdout.splitlines())) <= 80


@pytest.mark.parametrize("width", [80, 100])
@pytest.mark.parametrize("command", ["detect", "simulate", "verilog", "package", "quartus export", "synth"])
def test_help_lists_the_groups_in_order(command: str, width: int) -> None:
    words = [*command.split(), "--help"]
    result = CliRunner().invoke(main, words, prog_name="cornerstream", terminal_width=width)
    lines = result.stdout.splitlines()
    assert max(map(len, lines)) <= width
    order = (
        *(groups.MAIN, groups.THRESHOLDS, groups.FRAME, groups.ALGORITHM, groups.HARDWARE),
        *(groups.SIMULATOR, groups.OTHER),
    )
    found = [line.removesuffix(":") for line in lines if line.removesuffix(":") in order]
    assert found == [group for group in order if group in found] and found[0] == groups.MAIN
    assert (groups.SIMULATOR in found) == (command == "simulate")
    assert (groups.HARDWARE in found) == (command != "detect")
