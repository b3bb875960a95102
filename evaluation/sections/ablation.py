"""Gain of each step of profile ``robust`` towards stable corners, at equal numbers of corners.

From ranking by D on, one thing changes at a time: the paper's texture filter, Sobel gradients, with
the response filter, with the adaptive threshold. All corners are placed by the gradient step, so
the differences are those of the choice.
"""

from __future__ import annotations

from typing import Any

from evaluation.figures import Figures, Notify
from evaluation.inputs import views
from evaluation.inputs.sources import STRUCTURE, TEXTURE, Pair
from evaluation.methods.detectors import MODES, PLAIN, PLAIN_PARAMETERS, DetectionCache, Detector, Ours
from evaluation.methods.grouping import parts_of, take
from evaluation.methods.tracker import TrackCache
from evaluation.presentation import plots as style
from evaluation.presentation.modes import PARTS
from evaluation.presentation.numbers import figure, number, percent
from evaluation.presentation.table import Table
from evaluation.sections import repeatability, robustness
from evaluation.sections.section import Material, Section

PAPER_FILTER = "paper's filter"
SOBEL = "Sobel gradients"
SMOOTHED = "and response filter"
ADAPTIVE = "and adaptive threshold"


def steps() -> list[Detector]:
    """Ranking by D, ranking with the paper's filter, and the profile's steps.

    Each of the profile's steps includes those before it.
    """
    sobel = PLAIN_PARAMETERS.changed(derivative="sobel")
    smoothed = sobel.changed(response_filter="binomial")
    return [
        Ours(PLAIN, PLAIN_PARAMETERS, filtered=False),
        Ours(PAPER_FILTER, PLAIN_PARAMETERS),
        Ours(SOBEL, sobel, filtered=False),
        Ours(SMOOTHED, smoothed, filtered=False),
        Ours(ADAPTIVE, smoothed.changed(texture="mean")),
    ]


VIEWS = ("shift", "larger, brighter", "noisy")
"""Views of a photograph that are used: enough to tell steps apart, and a minute less."""


def chosen(pairs: list[Pair]) -> list[Pair]:
    """All pairs except rendered ones whose view is not in :data:`VIEWS`."""
    rendered = {view.name for view in views.VIEWS}
    return [pair for pair in pairs if pair.name in VIEWS or pair.name not in rendered]


def ablation(pairs: list[Pair], tracks_of: TrackCache, *, notify: Notify | None = None) -> Figures:
    """Repeatability and rho of each step, and what it gains over ranking by D, by class of scene.

    Repeatability over the pairs with a homography, rho over those in the tracker's reach. On each
    pair all steps have the same number of corners: no more than the one that finds fewest.
    """
    detectors, mode, cache = steps(), MODES[0], DetectionCache()
    warped = [pair for pair in pairs if pair.homography is not None]
    found = repeatability.scores(warped, detectors, mode, cache)
    tracked: dict[str, list[robustness.Score]] = {detector.name: [] for detector in detectors}
    near = robustness.trackable(pairs)
    for done, pair in enumerate(near, start=1):
        tracks = tracks_of.tracks(pair.first, pair.second)
        for name, points in robustness.corners_of(pair, detectors, mode, cache).items():
            tracked[name].append(robustness.score(pair, points, tracks))
        if notify:
            notify(done)
    return {
        "pairs": len(warped),
        "tracked_pairs": len(near),
        "scenes": sorted({pair.scene for pair in pairs}),
        "steps": {
            detector.name: {
                "repeatability": _repeatability(warped, found[detector.name], found[PLAIN]),
                "rho": _rho(near, tracked[detector.name], tracked[PLAIN]),
            }
            for detector in detectors
        },
    }


def _repeatability(
    pairs: list[Pair], found: list[repeatability.Score], base: list[repeatability.Score]
) -> Figures:
    return {
        part: repeatability.summary(take(pairs, chosen), take(found, chosen))
        | {"gain": repeatability.gain(take(pairs, chosen), take(found, chosen), take(base, chosen))}
        for part, chosen in parts_of(pairs).items()
    }


def _rho(pairs: list[Pair], found: list[robustness.Score], base: list[robustness.Score]) -> Figures:
    return {
        part: robustness.summary(take(pairs, chosen), take(found, chosen))
        | {"gain": robustness.gain(take(pairs, chosen), take(found, chosen), take(base, chosen))}
        for part, chosen in parts_of(pairs).items()
    }


MEASURES = ("repeatability", "rho")


def measure(material: Material) -> Figures:
    """Videos, some of the rendered views, and the user's pairs."""
    some = chosen(material.moving)
    with material.progress("steps of robust", len(robustness.trackable(some))) as advance:
        return ablation(some, material.tracked, notify=advance)


def tables(found: Figures) -> dict[str, Table]:
    """``steps``: repeatability and rho of each, by class of scene, and the gain."""
    parts = ("all", TEXTURE, STRUCTURE)
    rows = []
    for name, measures in found["steps"].items():
        cells = [name, number(measures["repeatability"]["all"]["corners"])]
        for measure in MEASURES:
            for part in parts:
                each = measures[measure].get(part)
                cells += [f"{figure(each[measure])}, {percent(each['gain'])}" if each else "–"]
        rows.append(cells)
    headings = [f"{measure}: {part}" for measure in MEASURES for part in parts]
    return {
        "steps": Table(
            "Steps of robust, and their gain over ranking by D",
            ["each with those before it", "corners", *headings],
            rows,
        )
    }


def plot(found: Figures) -> bytes:
    """The gain of each step over ranking by D."""
    steps = found["steps"]
    names = [name for name in steps if name != PLAIN]
    drawn = style.figure(3.2)
    panels = drawn.subplots(1, 2, sharey=True)
    for axes, measure in zip(panels, MEASURES, strict=True):
        style.rows(axes, names)
        for index, part in enumerate(part for part in PARTS if part in steps[PLAIN][measure]):
            for row, name in enumerate(names):
                gain = _in_percent(steps[name][measure][part]["gain"])
                style.point(axes, row + (index - 1) * 0.22, gain, color=PARTS[part], label=part)
        axes.axvline(0, color="black", linewidth=1)
        axes.set_xlabel(f"gain in {measure} over {PLAIN}, %")
        style.plain(axes)
    style.key(drawn, panels[0])
    return style.plot_file(drawn)


def _in_percent(gain: Figures) -> Figures:
    value, interval = gain["value"], gain["interval"]
    return {
        "value": None if value is None else 100 * value,
        "interval": interval and [100 * end for end in interval],
    }


def facts(found: Figures) -> dict[str, Any]:
    """What all steps together gain on texture."""
    last = list(found["steps"].values())[-1]
    return {
        measure: percent(last[measure].get(TEXTURE, last[measure]["all"])["gain"]) for measure in MEASURES
    }


SECTION = Section(
    name="ablation",
    title="What `robust` does about texture",
    measure=measure,
    tables=tables,
    plots={"ablation.png": plot},
    facts=facts,
    needs=frozenset({"views", "videos"}),
    options=frozenset({"images", "pairs", "videos"}),
)
