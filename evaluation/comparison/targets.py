"""What was to be reached with several pixels per clock, beside what was."""

from __future__ import annotations

from dataclasses import dataclass

from evaluation.comparison.parts import find, of_size, shown, size_name
from evaluation.comparison.variants import LANES_SIZE, UHD
from evaluation.figures import Figures
from evaluation.presentation.numbers import number
from evaluation.presentation.table import Strong


@dataclass(frozen=True)
class Target:
    """A bound for one figure of one ``lean`` build.

    Parameters
    ----------
    profile, pixels_per_clock, size
        The build.
    field, limit, at_least
        The figure, and its bound: at least or at most so much.
    times
        The limit is a multiple of the same figure with one pixel per clock.
    """

    profile: str
    pixels_per_clock: int
    field: str
    limit: float
    at_least: bool = False
    times: bool = False
    size: tuple[int, int] = LANES_SIZE


TARGETS = (
    Target("paper", 2, "le_packed", 6900),
    Target("paper", 4, "le_packed", 10_500),
    Target("paper", 4, "le_packed", 10_500, size=UHD),
    Target("paper", 8, "le_packed", 19_000),
    Target("robust", 4, "le_packed", 2.2, times=True),
    *(
        Target(profile, 4, "fmax_mhz", 150, at_least=True, size=size)
        for size in (LANES_SIZE, UHD)
        for profile in ("paper", "robust")
    ),
    *(Target(profile, 8, "fmax_mhz", 140, at_least=True) for profile in ("paper", "robust")),
)
_UNITS = {"le_packed": "logic elements", "fmax_mhz": "MHz"}


def targets_table(builds: list[Figures]) -> str:
    """A row for each target: its bound, the figure, and by how much it is missed."""
    return shown(["build", "target", "measured", ""], [_row(each, builds) for each in TARGETS], names=2)


def _row(target: Target, builds: list[Figures]) -> list[str]:
    chosen = of_size(builds, target.size)
    value = _figure(chosen, target, target.pixels_per_clock)
    limit: float | None = target.limit
    remark = ""
    if target.times:
        one = _figure(chosen, target, 1)
        limit = None if one is None else target.limit * one
        remark = f", {target.limit:g} times those of one"
    digits = 1 if target.field == "fmax_mhz" else 0
    sign = "≥" if target.at_least else "≤"
    return [
        f"`{target.profile}`, {target.pixels_per_clock} pixels per clock, {size_name(*target.size)}",
        f"{sign} {number(limit, digits)} {_UNITS[target.field]}{remark}",
        number(value, digits),
        _verdict(target, value, limit, digits),
    ]


def _figure(builds: list[Figures], target: Target, pixels_per_clock: int) -> float | None:
    found = find(builds, target.profile, "lean", pixels_per_clock)
    return found[target.field] if found else None


def _verdict(target: Target, value: float | None, limit: float | None, digits: int) -> str:
    if value is None or limit is None:
        return "–"
    lacking = limit - value if target.at_least else value - limit
    return "reached" if lacking <= 0 else Strong(f"missed by {number(lacking, digits)}")
