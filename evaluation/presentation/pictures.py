"""Images with positions in them, to judge by eye."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from evaluation.inputs.scenes import Scene
from evaluation.methods.localisation import INTEGER, OPENCV, WITHIN, place
from evaluation.presentation.plots import INTEREST, MARKERS, SMALL, colour, encoded, figure, in_order, key
from golden import Parameters, Settings

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SHOWN = (INTEGER, "nine", "gradient", OPENCV)
REACH = 7.5
"""Pixels shown on each side of a corner."""


def of_interest(profiles: dict[str, Parameters]) -> Parameters:
    """The profile that pictures show: ``robust``, or the first."""
    return profiles.get("robust", next(iter(profiles.values())))


def scene_grid(scenes: Sequence[Scene], profiles: dict[str, Parameters], columns: int) -> bytes:
    """Each scene around its true corner, with the position by each method; a PNG file."""
    parameters = of_interest(profiles)
    rows = -(-len(scenes) // columns)
    drawn = figure(8 * rows / columns + 0.25 * rows + 0.3)
    grid = drawn.subplots(rows, columns, squeeze=False)
    for axes, each in zip(grid.flat, scenes, strict=True):
        found = place(each.image, parameters, Settings.default(parameters))
        corner = found.nearest(each.x, each.y, WITHIN)
        show(axes, each.image)
        truth(axes, each.x, each.y)
        if corner is not None:
            mark(axes, {name: found.positions[name][[corner]] for name in SHOWN})
        axes.set_title(each.kind, fontsize=SMALL)
    key(drawn, grid.flat[0], len(SHOWN) + 1)
    return encoded(drawn)


def show(axes: Axes, image: np.ndarray) -> None:
    """An image, pixel by pixel, without ticks."""
    axes.imshow(image, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
    axes.set_xticks([])
    axes.set_yticks([])


def truth(axes: Axes, x: float, y: float) -> None:
    """The true corner, and the axes cut to its surroundings."""
    axes.plot(x, y, "+", color="#ff2020", markersize=20, markeredgewidth=1.4, label="true corner")
    axes.set_xlim(x - REACH, x + REACH)
    axes.set_ylim(y + REACH, y - REACH)


def mark(axes: Axes, positions: dict[str, np.ndarray], size: float = 7) -> None:
    """Positions (n, 2) of each method; the method of interest is drawn last."""
    for name in in_order(list(positions)):
        axes.plot(
            *positions[name].T,
            linestyle="none",
            marker=MARKERS.get(name, "o"),
            markersize=size,
            markerfacecolor="none",
            markeredgewidth=2.2 if name in INTEREST else 1.5,
            color=colour(name),
            label=name,
        )
