"""What corners are for: how near a homography from matched corners comes to the true one."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import Pair
from evaluation.inputs.views import VIEWS
from evaluation.methods.bootstrap import estimate, mean, median
from evaluation.methods.by_number import by_number
from evaluation.methods.detectors import Points
from evaluation.methods.grouping import by_scene
from evaluation.methods.homographies import (
    AGREEMENT,
    FAILED,
    GRID,
    LEAST_CORRELATION,
    WINDOW,
    correspondences,
    grid_error,
    homography,
)
from evaluation.methods.placing import APART, Entrant, entrants
from evaluation.presentation import plots as style
from evaluation.presentation.modes import draw_parts
from evaluation.presentation.numbers import figure, number
from evaluation.presentation.table import Strong, Table
from evaluation.sections.section import Material, Section

NUMBERS = (100, 300)
"""Corners of each view, the strongest."""
MOVED = ("shift", "rotation 8°", "larger, brighter", "perspective, darker")
"""Views that are measured.

In the others nothing moves, so that whole pixels would be exact, or patches are turned too far to
correlate.
"""
USABLE = 1.0
"""Pixels: a homography with a larger error is of no use."""


class Score(NamedTuple):
    """One detector on one pair: corners of the view that has fewer, partners, and grid error."""

    corners: int
    partners: int
    error: float


def score(pair: Pair, first: Points, second: Points) -> Score:
    """Match the corners of two views, and judge the homography that they give."""
    partners = correspondences(pair, first, second)
    found = homography(first[partners[:, 0]], second[partners[:, 1]])
    return Score(min(len(first), len(second)), len(partners), grid_error(pair, found))


def summary(pairs: list[Pair], found: list[Score]) -> Figures:
    """Median error, with its interval over photographs, and the share of useless homographies."""
    useless = [(float(each.error > USABLE),) for each in found]
    return {
        "error": estimate(by_scene(pairs, [(each.error,) for each in found]), median),
        "useless": estimate(by_scene(pairs, useless), mean),
        "corners": round(float(np.mean([each.corners for each in found])), 1),
        "partners": round(float(np.mean([each.partners for each in found])), 1),
    }


def downstream(
    pairs: list[Pair], some: list[Entrant], numbers: tuple[int, ...], notify: Notify | None = None
) -> Figures:
    """``{number: {name: {part: figures}}}`` over these pairs."""

    def counted(pair: Pair, first: Points, second: Points, count: int) -> Score:
        return score(pair, first[:count], second[:count])

    return by_number(pairs, some, numbers, counted, summary, notify)


def measure(material: Material) -> Figures:
    """The views in which everything moves; quick: the smaller number of corners."""
    pairs = [pair for pair in material.views if pair.name in MOVED]
    numbers = NUMBERS[:1] if material.quick else NUMBERS
    with material.progress("homographies", len(pairs)) as advance:
        found = downstream(pairs, entrants(material.profiles), numbers, advance)
    return {"pairs": len(pairs), "scenes": len({pair.scene for pair in pairs}), "numbers": found}


def tables(found: Figures) -> dict[str, Table]:
    """One for each number of corners, under this number."""
    return {number: _table(number, by_name) for number, by_name in found["numbers"].items()}


def _table(count: str, by_name: Figures) -> Table:
    groups = [part for part in next(iter(by_name.values())) if part != "all"]
    rows = []
    for name, parts in by_name.items():
        everything = parts["all"]
        rows.append(
            [
                Strong(name) if name in style.INTEREST else name,
                number(everything["corners"]),
                number(everything["partners"]),
                *(figure(parts[part]["error"], 3) for part in ("all", *groups)),
                figure(everything["useless"]),
            ]
        )
    headings = ["detector", "corners", "partners", "error, px", *groups, f"share above {USABLE:g} px"]
    return Table(f"Homographies from the {count} strongest corners of each view", headings, rows)


def plot(found: Figures) -> bytes:
    """Errors of every detector, a panel for each number of corners."""
    numbers = found["numbers"]
    drawn = style.figure(0.24 * len(next(iter(numbers.values()))) + 1.2)
    panels = drawn.subplots(1, len(numbers), sharey=True, squeeze=False)[0]
    for axes, (count, by_name) in zip(panels, numbers.items(), strict=True):
        draw_parts(axes, by_name, "error")
        axes.set_xscale("log")
        axes.set_xticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
        axes.minorticks_off()
        axes.set_xlim(0.01, 1.5)
        axes.set_title(f"{count} corners", fontsize=10)
        axes.set_xlabel("grid error, px (median)")
    style.key(drawn, panels[0])
    return style.plot_file(drawn)


_TICKS = (0.02, 0.05, 0.1, 0.2, 0.5, 1)


def facts(found: Figures) -> dict[str, Any]:
    """The protocol."""
    return {
        "views": [view.name for view in VIEWS if view.name in MOVED],
        "window": WINDOW,
        "least_correlation": LEAST_CORRELATION,
        "agreement": AGREEMENT,
        "grid": GRID,
        "failed": FAILED,
        "apart": APART,
    }


SECTION = Section(
    name="downstream",
    title="Homographies from matched corners",
    measure=measure,
    tables=tables,
    plots={"downstream.png": plot},
    facts=facts,
    needs=frozenset({"views"}),
    options=frozenset({"profiles", "images"}),
)
