"""Repeatability: the share of corners that are found again in another view of the scene."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

import numpy as np

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import Pair, photographs
from evaluation.inputs.views import VIEWS, rendered_pairs
from evaluation.methods.bootstrap import estimate, mean, plain, relative_gain
from evaluation.methods.detectors import (
    MODES,
    PLAIN,
    USUAL,
    DetectionCache,
    Detector,
    Mode,
    Ours,
    Points,
    Thresholds,
    budget,
    detectors,
    modes_of,
)
from evaluation.methods.grouping import by_scene, figures_of_parts, parts_of
from evaluation.methods.matching import TOLERANCE, known, match, project, visible
from evaluation.presentation import pictures
from evaluation.presentation import plots as style
from evaluation.presentation.modes import draw_parts, mode_tables
from evaluation.presentation.numbers import figure, number
from evaluation.presentation.table import Table
from evaluation.sections.section import Material, Section
from golden import Parameters
from golden.algorithm import Fit

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Score(NamedTuple):
    """One detector on one pair: corners of each view, matches, and their mean distance."""

    first: int
    second: int
    matched: int
    distance: float

    @property
    def repeatability(self) -> float:
        """Matches over the smaller number of corners; NaN where one view has none."""
        fewer = min(self.first, self.second)
        return self.matched / fewer if fewer else float("nan")


class Visible:
    """Corners of a pair that both views can show, by detector, as far as they were asked for."""

    def __init__(self, pair: Pair, cache: DetectionCache) -> None:
        self.pair = pair
        self._cache = cache

    def __call__(self, detector: Detector, thresholds: Thresholds, ranked: bool) -> tuple[Points, Points]:
        first, second = (
            self._cache.corners(detector, image, thresholds, ranked)
            for image in (self.pair.first, self.pair.second)
        )
        return visible(self.pair, first, second)


def corners_of(seen: Visible, detectors: list[Detector], mode: Mode) -> dict[str, tuple[Points, Points]]:
    """By the detector's name, the corners of both views that count.

    In a mode of equal numbers, all detectors have the same number in each view: N, or the smallest
    number that any detector finds, if that is less.
    """
    found = {each.name: seen(each, mode.thresholds, mode.equal) for each in detectors}
    if not mode.equal:
        return found
    wanted = [mode.wanted(seen.pair.first)] * 2
    if mode.like:
        (like,) = (each for each in detectors if each.name == mode.like)
        wanted = [len(points) for points in seen(like, mode.thresholds, False)]
    limits = [min(wanted[view], *(len(both[view]) for both in found.values())) for view in (0, 1)]
    return {name: (first[: limits[0]], second[: limits[1]]) for name, (first, second) in found.items()}


def score(pair: Pair, first: Points, second: Points) -> Score:
    """Compare the corners of two views, those of the first where the homography takes them."""
    _, distances = match(project(first, known(pair)), second)
    distance = float(distances.mean()) if len(distances) else float("nan")
    return Score(len(first), len(second), len(distances), distance)


def scores(
    pairs: list[Pair], detectors: list[Detector], mode: Mode, cache: DetectionCache
) -> dict[str, list[Score]]:
    """By the detector's name, a score for each pair."""
    results: dict[str, list[Score]] = {detector.name: [] for detector in detectors}
    for pair in pairs:
        for name, both in corners_of(Visible(pair, cache), detectors, mode).items():
            results[name].append(score(pair, *both))
    return results


def summary(pairs: list[Pair], found: list[Score]) -> Figures:
    """Means over pairs of repeatability, localisation error and numbers.

    Intervals are those over photographs.
    """
    fewer = [min(each.first, each.second) for each in found]
    return {
        "repeatability": estimate(by_scene(pairs, [(each.repeatability,) for each in found]), mean),
        "localisation": estimate(by_scene(pairs, [(each.distance,) for each in found]), mean),
        "corners": round(float(np.mean(fewer)), 1) if fewer else None,
    }


def gain(pairs: list[Pair], ours: list[Score], base: list[Score]) -> Figures:
    """How much higher ours is than the base on the same pairs, relative to it."""
    both = [(one.repeatability, other.repeatability) for one, other in zip(ours, base, strict=True)]
    return estimate(by_scene(pairs, both), relative_gain)


def mode_figures(pairs: list[Pair], found: dict[str, list[Score]], *, views: bool = False) -> Figures:
    """One mode: each detector over all pairs and by class of scene, and the gain of its filter."""
    results = figures_of_parts(pairs, found, parts_of(pairs), summary, gain)
    if views:
        for name, each in found.items():
            results[name]["views"] = _by_view(pairs, each)
    return results


def _by_view(pairs: list[Pair], found: list[Score]) -> Figures:
    values: dict[str, list[float]] = {}
    for pair, each in zip(pairs, found, strict=True):
        known = values.setdefault(pair.name, [])
        if np.isfinite(each.repeatability):
            known.append(each.repeatability)
    return {view: plain(float(np.mean(some))) if some else None for view, some in values.items()}


def by_fit() -> list[Detector]:
    """The corners of ``robust``, placed by each fit."""
    return [Ours(str(fit), Parameters.profile("robust", fit=fit)) for fit in get_args(Fit)]


CURVE = (3000, 1500, 750, 375)
"""Pixels per corner at which repeatability is measured besides."""


def repeatability(
    pairs: list[Pair], detectors: list[Detector], *, quick: bool = False, notify: Notify | None = None
) -> Figures:
    """Every mode, and repeatability over the number of corners at equal numbers."""
    cache = DetectionCache()
    modes: Figures = {}
    for done, mode in enumerate(modes_of(detectors), start=1):
        found = scores(pairs, detectors, mode, cache)
        modes[mode.name] = mode_figures(pairs, found, views=mode is MODES[0])
        if notify:
            notify(done)
    fits = {
        name: summary(pairs, each)
        for name, each in scores(pairs, by_fit(), MODES[0], DetectionCache()).items()
    }
    curve: list[Figures] = []
    for pixels in () if quick else CURVE:
        mode = replace(MODES[0], pixels_per_corner=pixels)
        found = scores(pairs, detectors, mode, cache)
        point = {name: summary(pairs, each)["repeatability"]["value"] for name, each in found.items()}
        curve.append({"pixels_per_corner": pixels, **point})
    return {
        "tolerance": TOLERANCE,
        "scenes": sorted({pair.scene for pair in pairs}),
        "pairs": len(pairs),
        "modes": modes,
        "fits": fits,
        "curve": curve,
    }


def measure(material: Material) -> Figures:
    """Rendered views, and under ``given`` the user's pairs; None if there are none."""
    result: Figures = {}
    for name, pairs in (("rendered", material.views), ("given", material.user.pairs)):
        with material.progress(f"repeatability of {name} pairs", len(MODES)) as advance:
            measured = detectors(material.profiles)
            found = repeatability(pairs, measured, quick=material.quick, notify=advance) if pairs else None
            result[name] = found
    return result


def tables(found: Figures) -> dict[str, Table]:
    """Each mode under its name, then ``fits`` and ``views``; those of given pairs begin so."""
    rendered = found["rendered"]
    made = mode_tables(rendered["modes"], "repeatability", "localisation")
    fits = [
        [name, figure(each["repeatability"], 3), figure(each["localisation"], 3)]
        for name, each in rendered["fits"].items()
    ]
    equal = rendered["modes"][MODES[0].name]
    views = [
        [view, *(number(each["views"].get(view), 2) for each in equal.values())]
        for view in equal[PLAIN]["views"]
    ]
    made["fits"] = Table(
        "Corners of robust by fit, equal numbers", ["fit", "repeatability", "localisation, px"], fits
    )
    made["views"] = Table("Repeatability by view, equal numbers", ["view", *equal], views)
    if found["given"]:
        given = mode_tables(found["given"]["modes"], "repeatability", "localisation")
        made |= {
            f"given, {name}": replace(table, title=f"Given pairs: {table.title}")
            for name, table in given.items()
        }
    return made


def plot(found: Figures) -> bytes:
    """Equal numbers, by class of scene and by number of corners."""
    rendered = found["rendered"]
    equal = rendered["modes"][MODES[0].name]
    drawn = style.figure(4.6)
    left, right = drawn.subplots(1, 2)
    draw_parts(left, equal, "repeatability")
    left.set_xlabel(f"repeatability at {rendered['tolerance']} px, equal numbers")
    left.set_xlim(left=0)
    if rendered["curve"]:
        _curves(right, rendered["curve"], list(equal))
    style.key(drawn, left)
    return style.plot_file(drawn)


def _curves(axes: Axes, curve: list[Figures], names: list[str]) -> None:
    numbers = [1000 / point["pixels_per_corner"] for point in curve]
    for name in style.in_order(names):
        values = [point[name] for point in curve]
        width = 2.6 if name in style.INTEREST else 1.3
        axes.plot(numbers, values, marker="o", markersize=4, linewidth=width, color=style.colour(name))
    axes.set_xlabel("corners per 1000 pixels, all photographs")
    axes.set_ylim(0, 0.9)
    axes.set_xlim(right=max(numbers) * 1.75)
    axes.set_xticks([0.5, 1, 1.5, 2, 2.5])
    style.end_labels(axes, {name: (max(numbers), curve[-1][name] or 0) for name in names}, gap=0.048)
    style.plain(axes, grid="y")


def facts(found: Figures) -> dict[str, Any]:
    """Numbers of views and photographs."""
    return {
        "views": [view.name for view in VIEWS],
        "modes": list(found["rendered"]["modes"]),
        "given": [f"given, {mode}" for mode in found["given"]["modes"]] if found["given"] else [],
    }


REPEATED_IN = (("grass", "rotation 8°"), ("china", "perspective, darker"), ("camera", "rotation 8°"))
"""Photographs that are shown, and the view in which their corners are looked for."""
_PART = 200
"""Pixels of the part that is shown."""


def picture(profiles: dict[str, Parameters]) -> bytes:
    """Corners in a part of a photograph, found again in another view or not; a JPEG file.

    The detectors have equal numbers of corners in the whole photograph.
    """
    images = {image.name: image for image in photographs()}
    shown: list[Detector] = [each for each in detectors(profiles) if each.name in (*profiles, PLAIN)]
    drawn = style.figure(8.4 * len(REPEATED_IN) / len(shown))
    grid = drawn.subplots(len(REPEATED_IN), len(shown), squeeze=False)
    for row, (name, view) in zip(grid, REPEATED_IN, strict=True):
        (pair,) = rendered_pairs([images[name]], tuple(each for each in VIEWS if each.name == view))
        for axes, detector in zip(row, shown, strict=True):
            _compare(axes, pair, detector)
    style.key(drawn, grid[0, 0])
    return style.encoded(drawn, "jpg")


def _compare(axes: Axes, pair: Pair, detector: Detector) -> None:
    first, second = visible(pair, detector.ranked(pair.first, USUAL), detector.ranked(pair.second, USUAL))
    count = min(budget(pair.first), len(first), len(second))
    first, second = first[:count], second[:count]
    pairs, _ = match(project(first, known(pair)), second)
    again = np.zeros(count, bool)
    again[pairs[:, 0]] = True
    height, width = pair.first.shape
    left, top = (width - _PART) / 2, (height - _PART) / 2
    pictures.show(axes, pair.first)
    looks: tuple[tuple[Any, dict[str, Any], str], ...] = (
        (~again, {"marker": "x", "color": "#ff8c00"}, "not found again"),
        (again, {"marker": "o", "color": "#00e6ff"}, "found again"),
    )
    for chosen, look, text in looks:
        axes.plot(
            *first[chosen].T, linestyle="none", markersize=5, markerfacecolor="none", label=text, **look
        )
    axes.set_xlim(left, left + _PART)
    axes.set_ylim(top + _PART, top)
    share = f"{again.sum()} of {count}" if count else "none"
    axes.set_title(f"{detector.name}: {share}", fontsize=style.SMALL)


SECTION = Section(
    name="repeatability",
    title="Repeatability",
    measure=measure,
    tables=tables,
    plots={"repeatability.png": plot},
    pictures={"repeated.jpg": picture},
    facts=facts,
    needs=frozenset({"views"}),
    options=frozenset({"profiles", "images", "pairs"}),
)
