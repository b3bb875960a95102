"""Pictures to judge by eye: where each method puts a corner, and which corners another view has
again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from evaluation.inputs.boards import rendered_board
from evaluation.inputs.scenes import KINDS, Scene, scene
from evaluation.inputs.sources import Pair, photographs
from evaluation.inputs.views import VIEWS, rendered_pairs
from evaluation.methods.detectors import PLAIN, USUAL, Detector, budget, detectors
from evaluation.methods.localisation import INTEGER, OPENCV, place
from evaluation.report.plots import colour, encoded, figure
from evaluation.sections.accuracy import WITHIN, paper_scenes
from evaluation.sections.repeatability import known, match, project, visible
from golden import Parameters, Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SHOWN = (INTEGER, "nine", "gradient", OPENCV)
_MARKS = {INTEGER: "s", "nine": "^", "gradient": "o", OPENCV: "D"}
_REACH = 7.5
"""Pixels shown on each side of a corner."""


def pictures(profiles: dict[str, Parameters]) -> dict[str, bytes]:
    """File names and contents."""
    parameters = profiles.get("robust", next(iter(profiles.values())))
    return {
        "localisation.png": _scenes(_chosen(), parameters, columns=6),
        "table5.png": _scenes(paper_scenes(), parameters, columns=4),
        "chessboard.jpg": _board(parameters),
        "repeated.jpg": _repeated(profiles),
    }


def _chosen() -> list[Scene]:
    wanted = [(0, 90, False, 0.0), (30, 60, False, 3.0), (75, 120, True, 3.0)]
    return [scene(kind, o, opening, inverted=i, noise=n) for kind in KINDS for o, opening, i, n in wanted]


def _scenes(scenes: list[Scene], parameters: Parameters, columns: int) -> bytes:
    rows = -(-len(scenes) // columns)
    drawn = figure(1.6 * columns, 1.75 * rows + 0.3)
    grid = drawn.subplots(rows, columns, squeeze=False)
    for axes, each in zip(grid.flat, scenes, strict=True):
        localisation = place(each.image, parameters, Settings.default(parameters))
        corner = localisation.nearest(each.x, each.y, WITHIN)
        _show(axes, each.image)
        axes.plot(each.x, each.y, "+", color="red", markersize=18, markeredgewidth=1, label="true corner")
        if corner is not None:
            _mark(axes, {name: localisation.positions[name][[corner]] for name in SHOWN})
        axes.set_xlim(each.x - _REACH, each.x + _REACH)
        axes.set_ylim(each.y + _REACH, each.y - _REACH)
        axes.set_title(each.kind, fontsize="small")
    _legend(drawn, grid.flat[0])
    return encoded(drawn)


def _show(axes: Axes, image: np.ndarray) -> None:
    axes.imshow(image, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])


def _mark(axes: Axes, positions: dict[str, np.ndarray], size: float = 6) -> None:
    for name, points in positions.items():
        axes.plot(
            *points.T,
            linestyle="none",
            marker=_MARKS.get(name, "x"),
            markersize=size,
            markerfacecolor="none",
            markeredgewidth=1.4,
            color=colour(name),
            label=name,
        )


def _board(parameters: Parameters) -> bytes:
    board = rendered_board(0)
    assert board.truth is not None
    localisation = place(board.image, parameters, Settings.default(parameters))
    chosen = np.array([localisation.nearest(x, y, WITHIN) for x, y in board.truth])
    drawn = figure(9.6, 3)
    whole, *details = drawn.subplots(1, 4, width_ratios=(1.45, 1, 1, 1))
    _show(whole, board.image)
    _mark(whole, {"gradient": localisation.positions["gradient"][chosen]}, size=3)
    for axes, index in zip(details, (0, 22, len(chosen) - 1), strict=True):
        _show(axes, board.image)
        x, y = board.truth[index]
        axes.plot(x, y, "+", color="red", markersize=22, markeredgewidth=1, label="true corner")
        _mark(axes, {name: localisation.positions[name][[chosen[index]]] for name in SHOWN})
        axes.set_xlim(x - _REACH, x + _REACH)
        axes.set_ylim(y + _REACH, y - _REACH)
    _legend(drawn, details[0])
    return encoded(drawn, "jpg")


def _legend(drawn: Figure, axes: Axes) -> None:
    handles, labels = axes.get_legend_handles_labels()
    drawn.legend(
        handles, labels, fontsize="x-small", ncols=len(labels), loc="outside lower center", frameon=False
    )


REPEATED_IN = (("grass", "rotation 8°"), ("china", "perspective, darker"), ("camera", "rotation 8°"))
"""Photographs that are shown, and the view in which their corners are looked for."""
_PART = 200
"""Pixels of the part that is shown."""


def _repeated(profiles: dict[str, Parameters]) -> bytes:
    """Corners of part of a photograph, equal numbers in the whole: those another view has again,
    and the others.
    """
    images = {image.name: image for image in photographs()}
    shown: list[Detector] = [each for each in detectors(profiles) if each.name in (*profiles, PLAIN)]
    drawn = figure(3.1 * len(shown), 3.3 * len(REPEATED_IN))
    grid = drawn.subplots(len(REPEATED_IN), len(shown), squeeze=False)
    for row, (name, view) in zip(grid, REPEATED_IN, strict=True):
        (pair,) = rendered_pairs([images[name]], tuple(each for each in VIEWS if each.name == view))
        for axes, detector in zip(row, shown, strict=True):
            _compare(axes, pair, detector)
    _legend(drawn, grid[0, 0])
    return encoded(drawn, "jpg")


def _compare(axes: Axes, pair: Pair, detector: Detector) -> None:
    first, second = visible(pair, detector.ranked(pair.first, USUAL), detector.ranked(pair.second, USUAL))
    number = min(budget(pair.first), len(first), len(second))
    first, second = first[:number], second[:number]
    pairs, _ = match(project(first, known(pair)), second)
    again = np.zeros(number, bool)
    again[pairs[:, 0]] = True
    height, width = pair.first.shape
    left, top = (width - _PART) / 2, (height - _PART) / 2
    _show(axes, pair.first)
    for chosen, dot, text in ((again, "#00d68f", "found again"), (~again, "#ff8c00", "not found again")):
        axes.plot(*first[chosen].T, "o", markersize=4, markerfacecolor="none", color=dot, label=text)
    axes.set_xlim(left, left + _PART)
    axes.set_ylim(top + _PART, top)
    share = f"{again.sum()} of {number}" if number else "none"
    axes.set_title(f"{detector.name}: {share}", fontsize="small")
