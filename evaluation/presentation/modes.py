"""Figures by mode, detector and class of scene, as tables and as rows of a plot."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from evaluation.figures import Figures
from evaluation.inputs.sources import STRUCTURE, TEXTURE
from evaluation.methods.detectors import PLAIN, WITHOUT
from evaluation.presentation import plots as style
from evaluation.presentation.numbers import figure, number, percent
from evaluation.presentation.table import Strong, Table

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FEWEST = 10
"""Least corners per image for which figures are shown."""
PARTS = {"all": "#000000", TEXTURE: "#009e73", STRUCTURE: "#cc79a7"}
"""Colours of the classes of scenes."""


def mode_tables(modes: Figures, measure: str, *others: str) -> dict[str, Table]:
    """A table for each mode, under its name; ``others`` are shown over all scenes only."""
    tables = {}
    for mode, each in modes.items():
        groups = groups_of(each)
        headings = ["detector", "corners", "all", *groups, *(f"{other}, px" for other in others)]
        headings += ["gain of its filter", f"gain over {PLAIN}", *(f"... {group}" for group in groups)]
        rows = list(_rows(each, groups, measure, others))
        tables[mode] = Table(f"{measure.capitalize()}, {mode}", headings, rows)
    return tables


def groups_of(each: Figures) -> list[str]:
    """Classes of scenes, at most two."""
    parts = next(iter(each.values()))
    return [part for part in parts if part not in ("all", "views", "video", "rendered")][:2]


def some(parts: Figures) -> bool:
    """Whether there are corners enough to say anything; where none are counted, there are."""
    return (parts["all"].get("corners", FEWEST) or 0) >= FEWEST


def _rows(each: Figures, groups: list[str], measure: str, others: tuple[str, ...]) -> Iterator[list[str]]:
    for name, parts in each.items():
        everything = parts["all"]
        cells: list[str] = [Strong(name) if name in style.INTEREST else name, number(everything["corners"])]
        if not some(parts):
            yield cells + ["–"] * (3 + 2 * len(groups) + len(others))
            continue
        cells += [figure(parts[part][measure]) for part in ("all", *groups)]
        cells += [figure(everything[other]) for other in others]
        cells.append(percent(everything["gain"].get(name + WITHOUT)))
        cells += [percent(parts[part]["gain"].get(PLAIN)) for part in ("all", *groups)]
        yield cells


def draw_parts(axes: Axes, each: Figures, measure: str) -> None:
    """A row for each detector, with a point for all scenes and for each of their classes."""
    style.rows(axes, list(each))
    parts = [part for part in PARTS if part in next(iter(each.values()))]
    for row, (name, found) in enumerate(each.items()):
        if not some(found):
            continue
        for index, part in enumerate(parts):
            place = row + (index - (len(parts) - 1) / 2) * 0.24
            strong = name in style.INTEREST
            style.point(axes, place, found[part][measure], strong=strong, color=PARTS[part], label=part)
    style.plain(axes)
