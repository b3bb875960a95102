"""The paper's Table 5: eight images of one corner, and its position by each method."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from evaluation.figures import Figures
from evaluation.inputs.scenes import (
    PAPER_CORNER,
    PAPER_LINES,
    PAPER_SOLIDS,
    SEED,
    Reading,
    Scene,
    paper_scene,
)
from evaluation.methods.bootstrap import estimate, mean, plain
from evaluation.methods.localisation import INTEGER, Outcome, methods
from evaluation.presentation import paper_accuracy as paper
from evaluation.presentation.numbers import figure
from evaluation.presentation.pictures import scene_grid
from evaluation.presentation.table import Name, Strong, Table
from evaluation.sections.section import Section
from golden import Parameters, Settings


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
    """Positions as the paper prints them, from 1 on; None where no corner was found."""
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


def tables(found: Figures) -> dict[str, Table]:
    """The eight rows beside the paper's, and the mean errors."""
    return {"rows": _positions(found), "means": _mean_errors(found)}


def _positions(found: Figures) -> Table:
    headings = ["image", "paper: Shi-Tomasi", "paper: this work"]
    for profile, figures in found.items():
        headings += [f"{profile}: whole pixel", f"{profile}: {figures['fit']}"]
    rows = []
    for index, printed in enumerate(paper.TABLE_5):
        cells = [printed.shape, _position(printed.shi_tomasi, 0), _position(printed.paper)]
        for figures in found.values():
            row = figures["rows"][index]
            cells += [_position(row[INTEGER], 0), _position(row[figures["fit"]])]
        rows.append(cells)
    return Table("The paper's Table 5: x, y in pixels, the first pixel being 1", headings, rows)


def _position(position: Any, digits: int = 2) -> str:
    return "–" if position is None else f"{position[0]:.{digits}f}, {position[1]:.{digits}f}"


def _mean_errors(found: Figures) -> Table:
    rows: list[list[str]] = []
    for text, error in (("whole pixel", paper.MEAN_ERROR_INTEGER), ("surface", paper.MEAN_ERROR)):
        rows.append(["the paper", text, *(f"{axis:g}" for axis in error), "", "", "", ""])
    for profile, figures in found.items():
        for method in (name for name, each in figures["methods"].items() if isinstance(each, dict)):
            parts = (figures[part][method] for part in ("methods", "rotation", "elsewhere"))
            cells = [figure(part[axis]) for part in parts for axis in ("x", "y")]
            rows.append([Name(profile), Strong(method) if method == figures["fit"] else method, *cells])
    headings = ["detector", "method", "x", "y", "lines rotated: x", "y", "other positions: x", "y"]
    return Table("Mean of |dx| and |dy| over the eight images, px", headings, rows, names=2)


SECTION = Section(
    name="table5",
    title="The paper's Table 5",
    measure=lambda material: table_5(material.profiles, quick=material.quick),
    tables=tables,
    pictures={"table5.png": lambda profiles: scene_grid(paper_scenes(), profiles, columns=4)},
    facts=lambda found: {
        "elsewhere": next(iter(found.values()))["elsewhere"]["scenes"] // len(paper.TABLE_5)
    },
    options=frozenset({"profiles"}),
)
