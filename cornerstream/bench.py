"""``cornerstream bench``: how fast the golden model and the simulators are."""

from __future__ import annotations

import json

import click

from cornerstream import console
from cornerstream.errors import BadInput, Failed, one_line
from cornerstream.idle import Idle, refuse_idle
from cornerstream.tools import running_tools
from sim.compiler import find_compiler


@click.command(short_help="Speed of golden model and simulators.")
@click.option(
    "--repeats",
    type=click.IntRange(min=1),
    default=15,
    show_default=True,
    help="How often the golden model and OpenCV are timed.",
)
@click.option(
    "--turns",
    type=click.IntRange(min=1),
    default=3,
    show_default=True,
    help="How often each simulation is timed.",
)
@click.option("--no-engines", is_flag=True, help="Leave the simulations out.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON instead of tables.")
def bench(repeats: int, turns: int, no_engines: bool, as_json: bool) -> None:
    """Measure the golden model against OpenCV, and the simulators in clocks per second.

    The simulators are the compiled one beside Amaranth's, and detectors of 2, 4 and 8 pixels per
    clock beside that of one. What is compared is timed in turns in one run, on Full HD. Takes a
    minute or two, the first time some minutes more to compile five detectors, and OpenCV
    (pip install 'cornerstream[eval]').

    \b
    Examples:
      cornerstream bench
      cornerstream bench --no-engines --repeats 50
      cornerstream bench --json > build/speed.json
    """
    refuse_idle(Idle("turns", no_engines, "without --no-engines"))
    from evaluation.comparison import speed, speed_tables

    try:
        speed.opencv()
    except speed.MissingPackageError as error:
        raise BadInput(one_line(error)) from error
    with running_tools():
        if not no_engines:
            find_compiler()
        result = speed.run(repeats=repeats, turns=turns, engines=not no_engines, notify=console.say)
    if as_json:
        click.echo(json.dumps(result))
    else:
        for table in speed_tables.tables(result):
            console.show(table)
    if wrong := sum(engine["mismatches"] for engine in speed.rates(result)):
        raise Failed(f"hardware and golden model differ in {wrong} records; see cornerstream simulate")
