"""What each step of profile ``robust`` gains, at equal numbers of corners.

From ranking by D, each step alone; then all of them, which is the profile; then the profile with
one thing that it does without.
"""

from __future__ import annotations

from typing import Any

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import Pair
from evaluation.inputs.views import VIEWS
from evaluation.methods.detectors import (
    PLAIN,
    PLAIN_PARAMETERS,
    USUAL,
    DetectionCache,
    Detector,
    Mode,
    Ours,
)
from evaluation.methods.grouping import parts_of, take
from evaluation.presentation import plots as style
from evaluation.presentation.modes import PARTS, groups_of
from evaluation.presentation.numbers import figure, number, percent
from evaluation.presentation.table import Strong, Table
from evaluation.sections import downstream, repeatability
from evaluation.sections.section import Material, Section
from golden import Parameters

PROFILE = "robust"
ALONE: dict[str, dict[str, str]] = {
    "smoothed pixels": {"pixel_filter": "binomial"},
    "response filter": {"response_filter": "binomial"},
}
"""The steps of the profile, as changes of ranking by D; all of them together are the profile."""
CHANGED: dict[str, dict[str, str]] = {
    "gradient step": {"fit": "gradient"},
    "pixels smoothed twice": {"pixel_filter": "twice"},
    "Sobel gradients": {"derivative": "sobel"},
    "adaptive threshold": {"texture": "mean"},
}
"""What the profile does without, as changes of it."""


def steps() -> list[Detector]:
    """Ranking by D, and this with each step alone; the profile, and this with each change."""
    robust = Parameters.profile(PROFILE)
    alone = [Ours(name, PLAIN_PARAMETERS.changed(**each), filtered=False) for name, each in ALONE.items()]
    more = [Ours(f"{PROFILE}, {name}", robust.changed(**each)) for name, each in CHANGED.items()]
    return [
        Ours(PLAIN, PLAIN_PARAMETERS, filtered=False),
        *alone,
        Ours(PROFILE, robust),
        *more,
    ]


NUMBERS = (100, 300)
"""Corners of each view, the strongest."""


def ablation(
    pairs: list[Pair], numbers: tuple[int, ...] = NUMBERS, *, notify: Notify | None = None
) -> Figures:
    """``{number: {step: {part: figures}}}``: repeatability, gains, and homographies' errors.

    On each pair all steps have the same number of corners: no more than the one that finds fewest.
    Gains are those over ranking by D and over the profile.
    """
    detectors, cache = steps(), DetectionCache()
    found: Figures = {}
    for done, count in enumerate(numbers, start=1):
        mode = Mode(f"{count} corners", USUAL, equal=True, number=count)
        scores = repeatability.scores(pairs, detectors, mode, cache)
        found[str(count)] = {name: _by_part(pairs, each, scores) for name, each in scores.items()}
        if notify:
            notify(done)
    _add_homographies(found, pairs, detectors, numbers)
    return {"pairs": len(pairs), "scenes": sorted({pair.scene for pair in pairs}), "numbers": found}


def _by_part(
    pairs: list[Pair], found: list[repeatability.Score], scores: dict[str, list[repeatability.Score]]
) -> Figures:
    results: Figures = {}
    for part, chosen in parts_of(pairs).items():
        some, ours = take(pairs, chosen), take(found, chosen)
        results[part] = repeatability.summary(some, ours)
        for base in (PLAIN, PROFILE):
            results[part][f"gain over {base}"] = repeatability.gain(some, ours, take(scores[base], chosen))
    return results


def _add_homographies(
    found: Figures, pairs: list[Pair], detectors: list[Detector], numbers: tuple[int, ...]
) -> None:
    """Set ``error``, as the section on homographies measures it, where everything moves."""
    still = {view.name for view in VIEWS} - set(downstream.MOVED)
    moving = [pair for pair in pairs if pair.name not in still]
    entrants = [downstream.Entrant(each.name, each) for each in detectors]
    for count, by_name in downstream.downstream(moving, entrants, numbers).items():
        for name, parts in by_name.items():
            for part, figures in parts.items():
                found[count][name][part]["error"] = figures["error"]


def measure(material: Material) -> Figures:
    """Rendered views, and the user's pairs; quick: the smaller number of corners."""
    numbers = NUMBERS[:1] if material.quick else NUMBERS
    pairs = material.views + material.user.pairs
    with material.progress("steps of robust", len(numbers)) as advance:
        return ablation(pairs, numbers, notify=advance)


def tables(found: Figures) -> dict[str, Table]:
    """One for each number of corners, under this number."""
    return {count: _table(count, by_name) for count, by_name in found["numbers"].items()}


def _table(count: str, by_name: Figures) -> Table:
    parts = ["all", *groups_of(by_name)]
    rows = []
    for name, each in by_name.items():
        cells = [Strong(name) if name == PROFILE else name, number(each["all"]["corners"])]
        cells += [figure(each["all"]["repeatability"])]
        cells += [percent(each[part][f"gain over {PLAIN}"]) for part in parts]
        cells += [percent(each["all"][f"gain over {PROFILE}"]), figure(each["all"]["error"], 3)]
        rows.append(cells)
    headings = ["step", "corners", "repeatability", f"gain over {PLAIN}"]
    headings += [f"... {part}" for part in parts[1:]]
    headings += [f"gain over {PROFILE}", "homographies, px"]
    return Table(f"Steps of {PROFILE}, the {count} strongest corners", headings, rows)


def plot(found: Figures) -> bytes:
    """The gain of each step over ranking by D, a panel for each number of corners."""
    numbers = found["numbers"]
    names = [name for name in next(iter(numbers.values())) if name != PLAIN]
    drawn = style.figure(0.3 * len(names) + 1.2)
    panels = drawn.subplots(1, len(numbers), sharey=True, squeeze=False)[0]
    for axes, (count, by_name) in zip(panels, numbers.items(), strict=True):
        style.rows(axes, names)
        for index, part in enumerate(part for part in PARTS if part in by_name[PLAIN]):
            for row, name in enumerate(names):
                gain = _in_percent(by_name[name][part][f"gain over {PLAIN}"])
                place = row + (index - 1) * 0.22
                style.point(axes, place, gain, strong=name == PROFILE, color=PARTS[part], label=part)
        axes.axvline(0, color="black", linewidth=1)
        axes.set_xlabel(f"gain in repeatability over {PLAIN}, %")
        axes.set_title(f"{count} corners", fontsize=10)
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
    """Numbers of corners and photographs, and what the profile gains on each class of scene."""
    profile = {count: by_name[PROFILE] for count, by_name in found["numbers"].items()}
    return {
        "numbers": list(profile),
        "gains": [
            f"{percent(each[part][f'gain over {PLAIN}'])} ({part}, {count} corners)"
            for count, each in profile.items()
            for part in groups_of({PROFILE: each})
        ],
    }


SECTION = Section(
    name="ablation",
    title="What each step of `robust` gains",
    measure=measure,
    tables=tables,
    plots={"ablation.png": plot},
    facts=facts,
    needs=frozenset({"views"}),
    options=frozenset({"images", "pairs"}),
)
