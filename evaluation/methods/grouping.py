"""Figures of many pairs: all of them, and by class of scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import compress
from typing import TypeVar

import numpy as np

from evaluation.figures import Figures
from evaluation.inputs.sources import Pair
from evaluation.methods.bootstrap import Values
from evaluation.methods.detectors import PLAIN, WITHOUT

T = TypeVar("T")


def by_scene(pairs: list[Pair], values: Sequence[tuple[float, ...]]) -> list[Values]:
    """Values of the pairs, those of one photograph together; pairs without a value are left out."""
    groups: dict[str, list[tuple[float, ...]]] = {}
    for pair, value in zip(pairs, values, strict=True):
        if np.isfinite(value).all():
            groups.setdefault(pair.scene, []).append(value)
    return [np.array(group, dtype=np.float64) for group in groups.values()]


def figures_of_parts(
    pairs: list[Pair],
    found: dict[str, list[T]],
    parts: dict[str, list[bool]],
    summary: Callable[[list[Pair], list[T]], Figures],
    gain: Callable[[list[Pair], list[T], list[T]], Figures],
) -> Figures:
    """A summary and gains for each detector and each part of the pairs.

    Gains are those over no filter and over ranking by D. ``found`` has one score for each pair, of
    the kind that ``summary`` and ``gain`` take.
    """
    results: Figures = {}
    for name, each in found.items():
        results[name] = {}
        for part, chosen in parts.items():
            some = take(pairs, chosen)
            results[name][part] = summary(some, take(each, chosen))
            results[name][part]["gain"] = {
                base: gain(some, take(each, chosen), take(found[base], chosen))
                for base in (name + WITHOUT, PLAIN)
                if base in found and base != name
            }
    return results


def parts_of(pairs: list[Pair]) -> dict[str, list[bool]]:
    """Which pairs belong to all, and to each class of scene."""
    parts = {"all": [True] * len(pairs)}
    for group in sorted({pair.group for pair in pairs}):
        parts[group] = [pair.group == group for pair in pairs]
    return parts


def take(items: list[T], chosen: list[bool]) -> list[T]:
    """The items that are chosen."""
    return list(compress(items, chosen))
