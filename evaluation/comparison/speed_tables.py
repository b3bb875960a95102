"""What :func:`evaluation.comparison.speed.run` returns, as tables for people."""

from __future__ import annotations

from typing import Any

from rich.table import Table
from rich.text import Text


def _verdict(reached: bool) -> str:
    return "[green]reached[/green]" if reached else "[red]missed[/red]"


def golden_table(speed: dict[str, Any]) -> Table:
    """``run()["golden"]`` for people."""
    table = Table(title=f"Golden model and OpenCV {speed['opencv_version']}, one {speed['frame']} frame")
    table.add_column("")
    for column in ("fastest, ms", "median, ms", "threads"):
        table.add_column(column, justify="right")
    threads = {"golden": 1, "opencv": speed["opencv_threads"]}
    for key, title in (("golden", "golden.detect"), ("opencv", "goodFeaturesToTrack(blockSize=5)")):
        timing = speed[key]
        milliseconds = [f"{1000 * timing[field]:.1f}" for field in ("minimum", "median")]
        table.add_row(title, *milliseconds, str(threads[key]))
    verdict = _verdict(speed["median_ratio"] <= speed["goal"])
    table.caption = Text.from_markup(
        f"ratio {speed['ratio']:.2f}, median {speed['median_ratio']:.2f}; "
        f"goal at most {speed['goal']:g}: {verdict}"
    )
    return table


def engine_table(speed: dict[str, Any]) -> Table:
    """``run()["engines"]`` for people."""
    table = Table(title="Simulated hardware, built for 1920x1080, in clocks per second")
    table.add_column("engine")
    for column in ("frame", "clocks run", "best", "median", "mismatches"):
        table.add_column(column, justify="right")
    for rate in (speed["compiled"], speed["amaranth"]):
        figures = [f"{rate[field]:,.0f}" for field in ("clocks", "best", "median", "mismatches")]
        table.add_row(rate["name"], rate["frame"], *figures)
    clocks = _verdict(speed["compiled"]["median"] >= speed["clocks_goal"])
    speedup = _verdict(speed["speedup"] >= speed["speedup_goal"])
    table.caption = Text.from_markup(
        f"goal at least {speed['clocks_goal']:,.0f} clocks/s: {clocks}; "
        f"{speed['speedup']:,.0f} times as fast, goal at least {speed['speedup_goal']:g}: {speedup}"
    )
    return table


def lane_table(rates: list[dict[str, Any]]) -> Table:
    """``run()["pixels_per_clock"]`` for people."""
    table = Table(
        title=f"Simulated hardware, compiled, profile robust, one {rates[0]['engine']['frame']} frame"
    )
    for column in ("pixels per clock", "clocks/pixel", "clocks/s", "frames/s", "beside 1", "mismatches"):
        table.add_column(column, justify="right")
    for rate in rates:
        table.add_row(
            str(rate["pixels_per_clock"]),
            f"{rate['clocks_per_pixel']:.3f}",
            f"{rate['engine']['median']:,.0f}",
            f"{rate['frames_per_second']:.2f}",
            f"{rate['ratio']:.2f}",
            str(rate["engine"]["mismatches"]),
        )
    return table


def tables(result: dict[str, Any]) -> list[Table]:
    """What :func:`run` returns, for people."""
    engines = [engine_table(result["engines"])] if "engines" in result else []
    lanes = [lane_table(result["pixels_per_clock"])] if "pixels_per_clock" in result else []
    return [golden_table(result["golden"]), *engines, *lanes]
