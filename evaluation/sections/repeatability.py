"""Repeatability: the share of corners that another view of the scene has again, within a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import compress
from typing import Any, NamedTuple, TypeVar, get_args

import numpy as np
from numpy.typing import NDArray

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import Pair
from evaluation.methods.bootstrap import Values, estimate, mean, plain, relative_gain
from evaluation.methods.detectors import (
    MODES,
    PLAIN,
    WITHOUT,
    DetectionCache,
    Detector,
    Mode,
    Ours,
    Points,
    Thresholds,
    budget,
)
from golden import Parameters
from golden.algorithm import Fit
from golden.formats import MARGIN

T = TypeVar("T")

TOLERANCE = 1.5
"""Pixels of the second view."""


class Score(NamedTuple):
    """One detector on one pair: corners that count in each view, those matched, and the matches'
    mean distance.
    """

    first: int
    second: int
    matched: int
    distance: float

    @property
    def repeatability(self) -> float:
        """Matches over the smaller number of corners; NaN where one view has none."""
        fewer = min(self.first, self.second)
        return self.matched / fewer if fewer else float("nan")


def project(points: Points, homography: NDArray[np.floating[Any]]) -> Points:
    """(n, 2) points through a homography."""
    mapped = np.column_stack([points, np.ones(len(points))]) @ homography.T
    return mapped[:, :2] / mapped[:, 2:]


def inside(points: Points, image: NDArray[np.uint8], margin: float = MARGIN) -> NDArray[np.bool_]:
    """Which points have so many pixels around them in the image."""
    height, width = image.shape
    x, y = points.T
    return (x >= margin) & (y >= margin) & (x <= width - 1 - margin) & (y <= height - 1 - margin)


def match(first: Points, second: Points, tolerance: float = TOLERANCE) -> tuple[NDArray[np.intp], Values]:
    """Mutual nearest neighbours within the tolerance: (n, 2) indices, and their distances."""
    if not len(first) or not len(second):
        return np.empty((0, 2), np.intp), np.empty(0)
    # not at the top: the other commands do without it
    from scipy.spatial import cKDTree

    distances, forwards = cKDTree(second).query(first)
    _, backwards = cKDTree(first).query(second)
    rows = np.arange(len(first))
    mutual = (backwards[forwards] == rows) & (distances <= tolerance)
    return np.column_stack([rows, forwards])[mutual], distances[mutual]


def known(pair: Pair) -> NDArray[np.float64]:
    """The homography of a pair that has one."""
    assert pair.homography is not None, f"{pair.scene}, {pair.name} has no homography"
    return pair.homography


def visible(pair: Pair, first: Points, second: Points) -> tuple[Points, Points]:
    """The corners that both views can show, support and all, in their order."""
    homography = known(pair)
    ahead = inside(project(first, homography), pair.second)
    back = inside(project(second, np.linalg.inv(homography)), pair.first)
    return first[ahead], second[back]


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

    Where numbers are to be equal they are so in each view: N as the mode says, or what the detector
    that finds fewest has, if that is less.
    """
    found = {each.name: seen(each, mode.thresholds, mode.equal) for each in detectors}
    if not mode.equal:
        return found
    wanted = [budget(seen.pair.first, mode.pixels_per_corner)] * 2
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


def by_scene(pairs: list[Pair], values: Sequence[tuple[float, ...]]) -> list[Values]:
    """Values of the pairs, those of one photograph together; pairs without a value are left out."""
    groups: dict[str, list[tuple[float, ...]]] = {}
    for pair, value in zip(pairs, values, strict=True):
        if np.isfinite(value).all():
            groups.setdefault(pair.scene, []).append(value)
    return [np.array(group, dtype=np.float64) for group in groups.values()]


def summary(pairs: list[Pair], found: list[Score]) -> Figures:
    """Repeatability, localisation error and numbers, as means over pairs; intervals over
    photographs.
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
    """One mode: each detector over all pairs and by class of scene, and what it gains over having
    no filter.
    """
    results = figures_of_parts(pairs, found, parts_of(pairs), summary, gain)
    if views:
        for name, each in found.items():
            results[name]["views"] = _by_view(pairs, each)
    return results


def figures_of_parts(
    pairs: list[Pair],
    found: dict[str, list[T]],
    parts: dict[str, list[bool]],
    summary: Callable[[list[Pair], list[T]], Figures],
    gain: Callable[[list[Pair], list[T], list[T]], Figures],
) -> Figures:
    """Of each detector and each part of the pairs a summary, and the gain over no filter and over
    ranking by D.

    ``found`` has one score for each pair, of whatever kind ``summary`` and ``gain`` take.
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
    """Those that are chosen."""
    return list(compress(items, chosen))


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
    for done, mode in enumerate(MODES, start=1):
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
