"""How far corners are from where they truly are, in rendered scenes: the wide set, and the paper's
Table 5.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from evaluation.figures import Figures, Notify
from evaluation.inputs.scenes import (
    KINDS,
    PAPER_CORNER,
    PAPER_LINES,
    PAPER_SOLIDS,
    SEED,
    Reading,
    Scene,
    paper_scene,
    wide_set,
)
from evaluation.methods.bootstrap import Values, estimate, mean, median, percentile_95, plain
from evaluation.methods.localisation import methods, place
from golden import Parameters, Settings

WITHIN = 4.0
"""Pixels: a corner further from the truth than this is another one. The peak of D lies 2 to 3
pixels inside an L.
"""


@dataclass
class Outcome:
    """What became of the scenes of one kind, scene by scene.

    Attributes
    ----------
    found, accepted
        Whether D has a maximum above T1 near the truth, and whether the texture filter lets it
        pass.
    errors
        By method: (dx, dy) to the truth in pixels, of those that were found.
    scenes
        Those that were found.
    """

    found: list[bool] = field(default_factory=list)
    accepted: list[bool] = field(default_factory=list)
    errors: dict[str, list[tuple[float, float]]] = field(default_factory=dict)
    scenes: list[Scene] = field(default_factory=list)

    def add(self, scene: Scene, parameters: Parameters, settings: Settings) -> None:
        """Detect the corner of a scene: that whose whole pixel is nearest to the truth, the same
        for all methods.
        """
        localisation = place(scene.image, parameters, settings)
        corner = localisation.nearest(scene.x, scene.y, WITHIN)
        self.found.append(corner is not None)
        self.accepted.append(corner is not None and bool(localisation.accepted[corner]))
        if corner is None:
            return
        self.scenes.append(scene)
        for name, positions in localisation.positions.items():
            x, y = positions[corner]
            self.errors.setdefault(name, []).append((x - scene.x, y - scene.y))

    def offsets(self, method: str) -> Values:
        """(n, 2) errors of the corners that were found."""
        return np.array(self.errors.get(method, []), dtype=np.float64).reshape(-1, 2)


def figures(offsets: Values) -> Figures:
    """As :func:`figures_of_images`, of (n, 2) errors that are each from another image."""
    return figures_of_images(list(offsets[:, None, :]))


def figures_of_images(offsets: Sequence[Values]) -> Figures:
    """Median and 95th percentile of the distance, and bias, of (n, 2) errors for each image, with
    intervals.
    """
    distances = [np.hypot(*each.T)[:, None] for each in offsets]
    found: Figures = {}
    for name, values, statistic in (
        ("median", distances, median),
        ("p95", distances, percentile_95),
        ("bias_x", [each[:, :1] for each in offsets], mean),
        ("bias_y", [each[:, 1:] for each in offsets], mean),
    ):
        figure = estimate(values, statistic)
        found |= {name: figure["value"], f"{name}_interval": figure["interval"]}
    return found


def rate(found: list[bool]) -> Figures:
    """Share of scenes, with its interval."""
    figure = estimate([np.array([float(each)]) for each in found], mean)
    return {"value": figure["value"], "interval": figure["interval"]}


def kind_figures(outcome: Outcome, parameters: Parameters) -> Figures:
    """All about one kind: the profile's own fit first, then each method, then each method by noise."""
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


def paper_scenes(reading: Reading = "opening", corner: tuple[float, float] = PAPER_CORNER) -> list[Scene]:
    """The eight images, in the paper's order."""
    lines = [paper_scene(degrees, solid=False, reading=reading, corner=corner) for degrees in PAPER_LINES]
    return lines + [paper_scene(degrees, solid=True, corner=corner) for degrees in PAPER_SOLIDS]


def _elsewhere(positions: int) -> Iterator[Scene]:
    random = np.random.default_rng(SEED)
    for _ in range(positions):
        x, y = np.round(PAPER_CORNER) + random.uniform(-0.5, 0.5, 2)
        yield from paper_scenes(corner=(float(x), float(y)))


def table_5(profiles: dict[str, Parameters], *, quick: bool = False) -> Figures:
    """``{profile: ...}``: the eight rows in the paper's 1-based pixels, and the mean errors.

    ``rows`` by each method; ``methods``: mean of |dx|, of |dy| and of the distance over the eight,
    by each method; ``rotation``: the same for the other reading of the lines' degrees;
    ``elsewhere``: for the same shapes at random positions, because a method could be right at one
    position by chance.
    """
    shapes: dict[str, Sequence[Scene]] = {
        "opening": paper_scenes(),
        "rotation": paper_scenes("rotation"),
        "elsewhere": list(_elsewhere(2 if quick else 16)),
    }
    results: Figures = {}
    for name, parameters in profiles.items():
        outcomes = {}
        for group, scenes in shapes.items():
            outcomes[group] = Outcome()
            for scene in scenes:
                outcomes[group].add(scene, parameters, Settings.default(parameters))
        results[name] = {
            "fit": parameters.algorithm.fit,
            "rows": list(_rows(outcomes["opening"], parameters)),
            "methods": _means(outcomes["opening"], parameters),
            "rotation": _means(outcomes["rotation"], parameters),
            "elsewhere": _means(outcomes["elsewhere"], parameters),
        }
    return results


def _rows(outcome: Outcome, parameters: Parameters) -> Iterator[Figures]:
    """Positions as the paper prints them, the first pixel being 1; None where no corner was found."""
    names = methods(parameters)
    offsets = {name: iter(outcome.offsets(name)) for name in names}
    for scene, found, accepted in zip(paper_scenes(), outcome.found, outcome.accepted, strict=True):
        row: Figures = {"shape": scene.kind, "accepted": accepted}
        for name in names:
            offset = next(offsets[name]) if found else None
            row[name] = None if offset is None else [plain(v) for v in offset + PAPER_CORNER + 1]
        yield row


def _means(outcome: Outcome, parameters: Parameters) -> Figures:
    results: Figures = {"scenes": len(outcome.found), "found": sum(outcome.found)}
    results["accepted"] = sum(outcome.accepted)
    for name in methods(parameters):
        offsets = outcome.offsets(name)
        results[name] = {
            "x": estimate(list(np.abs(offsets[:, :1])), mean),
            "y": estimate(list(np.abs(offsets[:, 1:])), mean),
            "distance": estimate(list(np.hypot(*offsets.T)[:, None]), mean),
        }
    return results
