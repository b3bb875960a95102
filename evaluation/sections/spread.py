"""An even spread: what cells, grids and minimum distances change, at equal numbers of corners."""

from __future__ import annotations

from typing import Any, NamedTuple

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import Pair
from evaluation.methods.bootstrap import estimate, mean, median
from evaluation.methods.by_number import by_number
from evaluation.methods.detectors import (
    WITHOUT,
    Detector,
    Fast,
    GoodFeaturesToTrack,
    Ours,
    Points,
)
from evaluation.methods.grouping import by_scene
from evaluation.methods.homographies import matched_error
from evaluation.methods.matching import TOLERANCE, visible
from evaluation.methods.placing import APART, Entrant
from evaluation.methods.spread import FastByGrid, OursByCells, covered
from evaluation.presentation import plots as style
from evaluation.presentation.modes import draw_parts
from evaluation.presentation.numbers import figure
from evaluation.presentation.table import Strong, Table
from evaluation.sections import downstream, repeatability
from evaluation.sections.section import Material, Section
from golden import Parameters

CELLS = (64, 32)
"""Sides of the cells in pixels."""
SQUARE = 48
"""Side of the squares that are covered by corners or not: not that of any cell."""
MEASURES = {"covered": mean, "repeatability": mean, "error": median}


class Score(NamedTuple):
    """One detector on one pair: squares of the first view covered, corners found again, error."""

    covered: float
    repeatability: float
    error: float


def detectors(profiles: dict[str, Parameters]) -> list[Detector]:
    """Every profile without cells and with them, then OpenCV's, as they are and spread."""
    found: list[Detector] = []
    for name, parameters in profiles.items():
        filtered = parameters.algorithm.texture != "patches"
        own = name if filtered else name + WITHOUT
        found.append(Ours(own, parameters, filtered=filtered))
        found += [OursByCells(own, parameters, cell, filtered=filtered) for cell in CELLS]
    return [*found, GoodFeaturesToTrack(), GoodFeaturesToTrack(APART), Fast(), FastByGrid()]


def score(pair: Pair, first: Points, second: Points, count: int) -> Score:
    """The first so many corners of each view; of those that both can show, for repeatability."""
    seen = (points[:count] for points in visible(pair, first, second))
    return Score(
        covered(pair.first, first[:count], SQUARE),
        repeatability.score(pair, *seen).repeatability,
        matched_error(pair, first[:count], second[:count]),
    )


def summary(pairs: list[Pair], found: list[Score]) -> Figures:
    """Every measure with its interval over photographs."""
    return {
        name: estimate(by_scene(pairs, [(getattr(each, name),) for each in found]), statistic)
        for name, statistic in MEASURES.items()
    }


def spread(
    pairs: list[Pair], some: list[Detector], numbers: tuple[int, ...], notify: Notify | None = None
) -> Figures:
    """``{number: {name: {part: figures}}}`` over these pairs."""
    return by_number(pairs, (Entrant(each.name, each) for each in some), numbers, score, summary, notify)


def measure(material: Material) -> Figures:
    """The views in which everything moves; quick: the smaller number of corners."""
    pairs = [pair for pair in material.views if pair.name in downstream.MOVED]
    numbers = downstream.NUMBERS[:1] if material.quick else downstream.NUMBERS
    with material.progress("spread", len(pairs)) as advance:
        found = spread(pairs, detectors(material.profiles), numbers, advance)
    return {"pairs": len(pairs), "scenes": len({pair.scene for pair in pairs}), "numbers": found}


def tables(found: Figures) -> dict[str, Table]:
    """One for each number of corners, under this number."""
    return {count: _table(count, by_name) for count, by_name in found["numbers"].items()}


def _table(count: str, by_name: Figures) -> Table:
    groups = [part for part in next(iter(by_name.values())) if part != "all"]
    rows = [
        [
            Strong(name) if name in style.INTEREST else name,
            *(
                figure(parts[part][measure], 3 if measure == "error" else 2)
                for measure in MEASURES
                for part in ("all", *groups)
            ),
        ]
        for name, parts in by_name.items()
    ]
    headings = ["detector"]
    for measure in ("covered", "repeatability", "error, px"):
        headings += [measure, *(f"... {group}" for group in groups)]
    return Table(f"Spread of {count} corners of each view", headings, rows)


def plot(found: Figures) -> bytes:
    """Squares covered, repeatability and error of every detector, with the most corners."""
    by_name = list(found["numbers"].values())[-1]
    drawn = style.figure(0.28 * len(by_name) + 1.2)
    texts = ("squares covered", "repeatability", "grid error, px (median)")
    for axes, name, text in zip(drawn.subplots(1, 3, sharey=True), MEASURES, texts, strict=True):
        draw_parts(axes, by_name, name)
        axes.set_xlim(left=0)
        axes.set_xlabel(text)
    style.key(drawn, drawn.axes[0])
    return style.plot_file(drawn)


def facts(found: Figures) -> dict[str, Any]:
    """The protocol."""
    return {
        "square": SQUARE,
        "cells": list(CELLS),
        "apart": APART,
        "tolerance": TOLERANCE,
        "most": list(found["numbers"])[-1],
    }


SECTION = Section(
    name="spread",
    title="An even spread",
    measure=measure,
    tables=tables,
    plots={"spread.png": plot},
    facts=facts,
    needs=frozenset({"views"}),
    options=frozenset({"profiles", "images"}),
)
