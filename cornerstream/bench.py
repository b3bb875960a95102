"""``cornerstream bench``: how fast the golden model and the simulators are."""

from __future__ import annotations

import click


@click.command(short_help="Speed of golden model and simulators.")
def bench() -> None:
    """Measure the golden model against OpenCV, and the simulators, in clocks per second."""
    from evaluation.speed import main

    main()
