"""Repeatability as it is published for the dataset HPatches, and those figures beside ours."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from evaluation.figures import Figures, Notify
from evaluation.inputs.hpatches import ILLUMINATION, SIZE, VIEWPOINT, prepared
from evaluation.inputs.packages import opencv
from evaluation.inputs.sources import Image, Pair
from evaluation.methods.bootstrap import estimate, mean
from evaluation.methods.box_suppression import OVERLAP, SIDE, suppressed
from evaluation.methods.detectors import (
    USUAL,
    WITHOUT,
    DetectionCache,
    Detector,
    Points,
    Thresholds,
    detectors,
)
from evaluation.methods.grouping import by_scene, parts_of, take
from evaluation.methods.matching import inside, known, project
from evaluation.presentation import plots as style
from evaluation.presentation.numbers import figure
from evaluation.presentation.table import Strong, Table
from evaluation.sections.section import Material, Section
from golden import Parameters

TOLERANCE = 3.0
"""Pixels."""
POINTS = 300
"""Points of each view that count: the strongest that both views can show."""
BEFORE = 600
"""Points of each view that non-maximum suppression leaves."""

PUBLISHED = {
    "SuperPoint": {ILLUMINATION: 0.662, VIEWPOINT: 0.674},
    "SuperPoint, MagicLeap's weights": {ILLUMINATION: 0.641, VIEWPOINT: 0.621},
    "Harris": {ILLUMINATION: 0.630, VIEWPOINT: 0.755},
    "Shi": {ILLUMINATION: 0.584, VIEWPOINT: 0.629},
    "FAST": {ILLUMINATION: 0.576, VIEWPOINT: 0.625},
}
"""The table "Detector evaluation" in the README of github.com/rpautrat/SuperPoint."""
NAMES = {"rendered": "rendered views", "given": "given pairs", "hpatches": "HPatches"}


class Harris(Detector):
    """OpenCV's Harris response as it was called for the published row: every pixel above 0.

    No margin is kept, and nothing is suppressed yet.
    """

    name = "Harris, as published"

    def ranked(self, image: Image, thresholds: Thresholds) -> Points:
        response = opencv().cornerHarris(image, 4, 3, 0.04)
        y, x = np.nonzero(response > 0)
        order = np.argsort(-response[y, x], kind="stable")
        return np.column_stack([x, y]).astype(np.float64)[order]

    def at(self, image: Image, thresholds: Thresholds) -> Points:
        return self.ranked(image, thresholds)


def entrants(profiles: dict[str, Parameters]) -> list[Detector]:
    """The study's detectors without those without a filter, and Harris."""
    return [*(each for each in detectors(profiles) if not each.name.endswith(WITHOUT)), Harris()]


class Score(NamedTuple):
    """One detector on one pair: points of each view, repeatability, and mean distance in pixels."""

    first: int
    second: int
    repeatability: float
    distance: float


def score(pair: Pair, first: Points, second: Points) -> Score:
    """Points of both views, strongest first: how many have one of the other view within 3 px.

    Unlike in the section on repeatability, partners need not be each other's nearest.
    """
    # not at the top: the other commands do without it
    from scipy.spatial import cKDTree

    homography = known(pair)
    ahead = project(first, homography)
    ahead = ahead[inside(ahead, pair.second, 0)][:POINTS]
    second = second[inside(project(second, np.linalg.inv(homography)), pair.first, 0)][:POINTS]
    if not len(ahead) or not len(second):
        none = 0.0 if len(ahead) or len(second) else float("nan")
        return Score(len(ahead), len(second), none, float("nan"))
    distances = np.concatenate([cKDTree(second).query(ahead)[0], cKDTree(ahead).query(second)[0]])
    near = distances[distances <= TOLERANCE]
    distance = float(near.mean()) if len(near) else float("nan")
    return Score(len(ahead), len(second), len(near) / len(distances), distance)


def summary(pairs: list[Pair], found: list[Score]) -> Figures:
    """Means over pairs, with their intervals over scenes."""
    return {
        "repeatability": estimate(by_scene(pairs, [(each.repeatability,) for each in found]), mean),
        "localisation": estimate(by_scene(pairs, [(each.distance,) for each in found]), mean),
        "points": round(float(np.mean([min(each.first, each.second) for each in found])), 1),
    }


def repeatability(pairs: list[Pair], some: list[Detector], notify: Notify | None = None) -> Figures:
    """Prepared pairs: ``{name: {part: figures}}``, the parts being the groups of the pairs."""
    cache = DetectionCache()
    scores: dict[str, list[Score]] = {each.name: [] for each in some}
    kept: dict[tuple[str, int], Points] = {}
    for done, pair in enumerate(pairs, start=1):
        for each in some:
            for image in (pair.first, pair.second):
                if (each.name, id(image)) not in kept:
                    points = cache.corners(each, image, USUAL, True)
                    kept[each.name, id(image)] = suppressed(points, BEFORE)
            first, second = (kept[each.name, id(image)] for image in (pair.first, pair.second))
            scores[each.name].append(score(pair, first, second))
        if notify:
            notify(done)
    parts = {name: chosen for name, chosen in parts_of(pairs).items() if name != "all"}
    return {
        name: {part: summary(take(pairs, chosen), take(each, chosen)) for part, chosen in parts.items()}
        for name, each in scores.items()
    }


def _by_change(pair: Pair) -> Pair:
    still = np.allclose(known(pair), np.eye(3))
    return replace(pair, group=ILLUMINATION if still else VIEWPOINT)


def measure(material: Material) -> Figures:
    """The rendered views, the user's pairs and HPatches; None for what was not given."""
    found: Figures = {}
    some = entrants(material.profiles)
    for name, pairs in (
        ("rendered", prepared([_by_change(pair) for pair in material.views])),
        ("given", prepared([_by_change(pair) for pair in material.user.pairs])),
        ("hpatches", material.user.hpatches),
    ):
        with material.progress(f"repeatability of {NAMES[name]} at 3 px", len(pairs)) as advance:
            measured = repeatability(pairs, some, advance) if pairs else None
        scenes = sorted({pair.scene for pair in pairs})
        found[name] = measured and {"pairs": len(pairs), "scenes": scenes, "detectors": measured}
    return found


def tables(found: Figures) -> dict[str, Table]:
    """Each set of pairs under its name; HPatches with the published rows, whether given or not."""
    made = {
        name: _table(f"Repeatability at {TOLERANCE:g} px, {NAMES[name]}", each["detectors"])
        for name, each in found.items()
        if each and name != "hpatches"
    }
    measured = found["hpatches"]["detectors"] if found["hpatches"] else {}
    return made | {"hpatches": _published(measured)}


_MEASURES = (("repeatability", ""), ("localisation", "localisation, px"))


def _table(title: str, by_name: Figures) -> Table:
    groups = list(next(iter(by_name.values())))
    rows = [
        [
            Strong(name) if name in style.INTEREST else name,
            *(figure(parts[group][measure], 3) for group in groups for measure, _ in _MEASURES),
        ]
        for name, parts in by_name.items()
    ]
    headings = [f"{group}: {words}" if words else group for group in groups for _, words in _MEASURES]
    return Table(title, ["detector", *headings], rows)


def _published(by_name: Figures) -> Table:
    headings = [ILLUMINATION, f"{ILLUMINATION}: localisation, px", VIEWPOINT]
    headings.append(f"{VIEWPOINT}: localisation, px")
    rows: list[list[str]] = []
    for name, values in PUBLISHED.items():
        rows.append([name, "published", f"{values[ILLUMINATION]:.3f}", "–", f"{values[VIEWPOINT]:.3f}", "–"])
    for name, parts in by_name.items():
        cells = [
            figure(parts[group][measure], 3) if group in parts else "–"
            for group in (ILLUMINATION, VIEWPOINT)
            for measure, _ in _MEASURES
        ]
        rows.append([Strong(name) if name in style.INTEREST else name, "measured", *cells])
    title = f"Repeatability at {TOLERANCE:g} px, HPatches"
    return Table(title, ["detector", "figures are", *headings], rows, names=2)


def facts(found: Figures) -> dict[str, Any]:
    """The protocol, and what was given."""
    return {
        "size": SIZE,
        "points": POINTS,
        "before": BEFORE,
        "tolerance": TOLERANCE,
        "side": SIDE,
        "overlap": OVERLAP,
        "given": found["given"]["scenes"] if found["given"] else [],
    }


SECTION = Section(
    name="hpatches",
    title="Repeatability as published for HPatches",
    measure=measure,
    tables=tables,
    facts=facts,
    needs=frozenset({"views"}),
    options=frozenset({"profiles", "images", "pairs", "hpatches"}),
)
