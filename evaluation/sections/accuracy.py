"""How far corners are from where they truly are, in rendered scenes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from evaluation.figures import Figures, Notify
from evaluation.inputs import scenes
from evaluation.inputs.scenes import (
    BLURS,
    CONTRASTS,
    KINDS,
    NOISES,
    OPENINGS,
    Scene,
    wide_set,
)
from evaluation.methods.bootstrap import Values, estimate, mean, plain
from evaluation.methods.detectors import USUAL
from evaluation.methods.localisation import WITHIN, Outcome, figures_of_images, methods
from evaluation.presentation import plots as style
from evaluation.presentation.numbers import figure, listed, spread
from evaluation.presentation.pictures import scene_grid
from evaluation.presentation.table import Name, Strong, Table
from evaluation.sections.section import Material, Section
from golden import Parameters, Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def figures(offsets: Values) -> Figures:
    """The same as :func:`figures_of_images`, for (n, 2) errors, each from another image."""
    return figures_of_images(list(offsets[:, None, :]))


def rate(found: list[bool]) -> Figures:
    """Share of scenes, with its interval."""
    figure = estimate([np.array([float(each)]) for each in found], mean)
    return {"value": figure["value"], "interval": figure["interval"]}


def kind_figures(outcome: Outcome, parameters: Parameters) -> Figures:
    """Figures of one kind: the profile's own fit, then each method, then each method by noise."""
    by_method = {name: figures(outcome.offsets(name)) for name in methods(parameters)}
    noises = np.array([scene.noise for scene in outcome.scenes])
    by_noise = {
        f"{noise:g}": {
            name: plain(float(np.median(np.hypot(*outcome.offsets(name)[noises == noise].T))))
            for name in methods(parameters)
        }
        for noise in sorted(set(noises.tolist()))
    }
    return {
        "scenes": len(outcome.found),
        "detected": rate(outcome.found),
        "accepted": rate(outcome.accepted),
        **by_method[parameters.algorithm.fit],
        "inwards": _inwards(outcome, parameters),
        "methods": by_method,
        "median_by_noise": by_noise,
    }


def _inwards(outcome: Outcome, parameters: Parameters) -> Figures | None:
    # along the axis of a wedge the errors of all orientations add up; in x and in y they cancel out
    angles = np.array([scene.inwards for scene in outcome.scenes])
    if not len(angles) or np.isnan(angles).any():
        return None
    axes = np.column_stack([np.cos(angles), np.sin(angles)])
    return {
        name: estimate((outcome.offsets(name) * axes).sum(1)[:, None], mean) for name in methods(parameters)
    }


def wide(profiles: dict[str, Parameters], *, quick: bool = False, notify: Notify | None = None) -> Figures:
    """``{profile: {kind: figures}}`` over the wide set, thresholds at their defaults."""
    results: Figures = {name: {"fit": parameters.algorithm.fit} for name, parameters in profiles.items()}
    done = 0
    for kind in KINDS:
        outcomes = {name: Outcome() for name in profiles}
        for scene in wide_set(kind, quick=quick):
            for name, parameters in profiles.items():
                outcomes[name].add(scene, parameters, Settings.default(parameters))
            done += 1
            if notify:
                notify(done)
        for name, parameters in profiles.items():
            results[name][kind] = kind_figures(outcomes[name], parameters)
    return results


def measure(material: Material) -> Figures:
    """The wide set, by profile and kind of corner."""
    total = len(KINDS) * len(scenes.wide_set("L", quick=material.quick))
    with material.progress("rendered corners", total) as advance:
        return wide(material.profiles, quick=material.quick, notify=advance)


def tables(found: Figures) -> dict[str, Table]:
    """Distances of each profile, under its name, and ``bias``."""
    return {profile: _distances(profile, kinds) for profile, kinds in found.items()} | {"bias": _bias(found)}


def _distances(profile: str, kinds: Figures) -> Table:
    rows = []
    for kind in KINDS:
        each = kinds[kind]
        cells = [kind, figure(each["detected"]), figure(each["accepted"])]
        for found in each["methods"].values():
            cells += [f"{spread(found['median'], found['median_interval'])}, {spread(found['p95'], None)}"]
        rows.append(cells)
    named = [Strong(method) if method == kinds["fit"] else method for method in kinds[KINDS[0]]["methods"]]
    return Table(
        f"Rendered corners of {profile}: distance to the true corner, px",
        ["corner", "found", "accepted", *named],
        rows,
        notes="Median with its interval, and after the comma the 95th percentile.",
    )


def _bias(found: Figures) -> Table:
    rows = []
    for profile, kinds in found.items():
        for method, inwards in kinds["L"]["inwards"].items():
            cells = []
            for kind in ("L", "saddle"):
                each = kinds[kind]["methods"][method]
                cells += [spread(each[axis], each[f"{axis}_interval"]) for axis in ("bias_x", "bias_y")]
            named = Strong(method) if method == kinds["fit"] else method
            rows.append([Name(profile), named, *cells, figure(inwards)])
    headings = ["profile", "method", "L: x", "y", "saddle: x", "y", "L: inwards"]
    return Table("Bias on rendered corners, px", headings, rows, names=2)


_TICKS = (0.02, 0.05, 0.1, 0.2, 0.5, 1, 2)


def plot(found: Figures) -> bytes:
    """Distances by kind of corner, and by noise, of the profile of interest."""
    profile = "robust" if "robust" in found else next(iter(found))
    kinds = found[profile]
    named = [name for name in kinds[KINDS[0]]["methods"] if name not in ("six", "printed")]
    drawn = style.figure(4.0)
    left, right = drawn.subplots(1, 2, width_ratios=(1.5, 1))
    _by_kind(left, kinds, named)
    left.set_title(f"{profile}: median, and 95th percentile (bar)", fontsize=10)
    for method in style.in_order(named):
        strong = method in style.INTEREST
        for kind, line in (("L", "-"), ("saddle", "--")):
            by_noise = kinds[kind]["median_by_noise"]
            places, values = (
                [float(level) for level in by_noise],
                [each[method] for each in by_noise.values()],
            )
            look = {"color": style.colour(method), "marker": style.MARKERS.get(method, "o")}
            right.plot(places, values, line, linewidth=2.4 if strong else 1.3, markersize=5, **look)
    style.logarithmic(right, _TICKS)
    right.set_xlabel("noise, grey levels")
    right.set_title("median; L solid, saddle dashed", fontsize=10)
    for axes in (left, right):
        style.plain(axes, grid="y")
    style.key(drawn, left)
    return style.plot_file(drawn)


def _by_kind(axes: Axes, kinds: Figures, named: list[str]) -> None:
    places = {method: (index - (len(named) - 1) / 2) * 0.17 for index, method in enumerate(named)}
    for method in style.in_order(named):
        look = {"color": style.colour(method), "fmt": style.MARKERS.get(method, "o")}
        for column, kind in enumerate(KINDS):
            each = kinds[kind]["methods"][method]
            median = {"value": each["median"], "interval": each["median_interval"]}
            at = column + places[method]
            style.point(axes, at, median, strong=method in style.INTEREST, flat=False, label=method, **look)
            axes.plot(at, each["p95"], marker="_", markersize=11, color=look["color"])
    axes.set_xticks(range(len(KINDS)), KINDS)
    style.logarithmic(axes, _TICKS)
    axes.set_ylabel("distance to the true corner, px")


def _examples() -> list[Scene]:
    wanted = [(0, 90, False, 0.0), (30, 60, False, 3.0), (75, 120, True, 3.0)]
    return [
        scenes.scene(kind, o, opening, inverted=i, noise=n) for kind in KINDS for o, opening, i, n in wanted
    ]


def facts(found: Figures) -> dict[str, Any]:
    """What the scenes are made of."""
    return {
        "scenes": next(iter(found.values()))[KINDS[0]]["scenes"],
        "usual": USUAL,
        "within": f"{WITHIN:g}",
        "openings": listed(OPENINGS),
        "contrasts": " to ".join(map(str, CONTRASTS)),
        "blurs": " to ".join(map(str, BLURS)),
        "noises": listed(NOISES),
    }


SECTION = Section(
    name="accuracy",
    title="Accuracy on rendered corners",
    measure=measure,
    tables=tables,
    plots={"accuracy.png": plot},
    pictures={"localisation.png": lambda profiles: scene_grid(_examples(), profiles, columns=6)},
    facts=facts,
    options=frozenset({"profiles"}),
)
