"""The style of plots: figures as points with intervals, the detector of interest last, strongest.

A plot is 800 pixels wide on a page, and its type has nine points or more.

Colours are Okabe and Ito's, which are told apart with every kind of colour vision.
"""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal

from evaluation.figures import Figures

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {
    "integer": "#888888",
    "nine": "#e69f00",
    "printed": "#d55e00",
    "gradient": "#0072b2",
    "cornerSubPix": "#cc79a7",
    "ranking by D": "#000000",
    "paper": "#d55e00",
    "paper without filter": "#e69f00",
    "robust": "#0072b2",
    "robust without filter": "#56b4e9",
    "precise": "#009e73",
    "goodFeaturesToTrack": "#cc79a7",
    "FAST": "#009e73",
    "chance": "#888888",
}
INTEREST = ("robust", "gradient")
"""Drawn last and strongest: the profile, and its method."""
MARKERS = {"integer": "s", "nine": "^", "cornerSubPix": "D"}
WIDTH = 8.0
"""Inches; a page shows a plot 800 pixels wide, so a point is 1.4 pixels."""
SMALL = 9
"""Points: the smallest type."""
_DPI = 140


def colour(name: str) -> str:
    """Colour of a method or a detector; dark grey for one that is not listed."""
    return COLOURS.get(name, "#444444")


def figure(height: float, width: float = WIDTH) -> Figure:
    """An empty figure of so many inches."""
    # not at the top: only plots need matplotlib
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained", dpi=_DPI)


def encoded(drawn: Figure, kind: str = "png") -> bytes:
    """The figure as a file of this kind, the same for the same figure."""
    file = io.BytesIO()
    if kind == "jpg":
        drawn.savefig(file, format=kind, pil_kwargs={"quality": 80, "optimize": True})
    else:
        drawn.savefig(file, format=kind, metadata={"Software": None})
    return file.getvalue()


def plot_file(drawn: Figure) -> bytes:
    """A plot as PNG with a palette: a third of the size, and lines and type look the same."""
    # not at the top: only plots need Pillow here
    from PIL import Image

    smaller = io.BytesIO()
    with Image.open(io.BytesIO(encoded(drawn))) as picture:
        picture.convert("RGB").quantize(128).save(smaller, format="png", optimize=True)
    return smaller.getvalue()


def in_order(names: Sequence[str]) -> list[str]:
    """The names with the one of interest last, so that it is drawn above the others."""
    return sorted(names, key=lambda name: name in INTEREST)


def point(
    axes: Axes, at: float, estimate: Figures, *, strong: bool = False, flat: bool = True, **style: Any
) -> None:
    """A figure with its interval, along x if ``flat``; nothing if there is no figure."""
    value = estimate["value"]
    if value is None:
        return
    low, high = estimate["interval"] or (value, value)
    ends = [[max(value - low, 0)], [max(high - value, 0)]]
    usual = {"fmt": "o", "markersize": 7 if strong else 5, "elinewidth": 2.4 if strong else 1.3}
    look: dict[str, Any] = usual | style | {"zorder": 4 if strong else 3}
    if flat:
        axes.errorbar(value, at, xerr=ends, **look)
    else:
        axes.errorbar(at, value, yerr=ends, **look)


def rows(axes: Axes, names: Sequence[str]) -> None:
    """One row for each name, from above; the one of interest is bold, on its own band."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - 0.5, -0.5)
    for place, name in enumerate(names):
        if name in INTEREST:
            axes.axhspan(place - 0.5, place + 0.5, color="#e8f1f8", zorder=0)
    # where panels share an axis, only the first has labels
    for label in axes.get_yticklabels():
        label.set_fontweight("bold" if label.get_text() in INTEREST else "normal")
    axes.tick_params(axis="y", length=0)


def plain(axes: Axes, *, grid: Literal["x", "y"] = "x") -> None:
    """No frame, light lines to read values by."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(axis=grid, color="#dddddd", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.tick_params(labelsize=SMALL)


def logarithmic(axes: Axes, ticks: Sequence[float]) -> None:
    """The y axis, with plain numbers at these ticks."""
    axes.set_yscale("log")
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.minorticks_off()


def end_labels(axes: Axes, lines: dict[str, tuple[float, float]], gap: float) -> None:
    """Names beside the ends (x, y) of lines, at least ``gap`` apart, instead of a legend."""
    ordered = sorted(lines, key=lambda name: lines[name][1])
    heights = [lines[name][1] for name in ordered]
    left, right = axes.get_xlim()
    for name, height in zip(ordered, _apart(heights, gap), strict=True):
        axes.annotate(
            name,
            (lines[name][0] + 0.03 * (right - left), height),
            annotation_clip=False,
            va="center",
            fontsize=SMALL,
            color=colour(name),
            fontweight="bold" if name in INTEREST else "normal",
        )


def _apart(heights: Sequence[float], gap: float) -> list[float]:
    """Ascending heights moved apart: the mean of moving them up only and of down only."""
    up, down = list(heights), list(heights)
    for index in range(1, len(heights)):
        up[index] = max(up[index], up[index - 1] + gap)
        down[-1 - index] = min(down[-1 - index], down[-index] - gap)
    return [(above + below) / 2 for above, below in zip(up, down, strict=True)]


def key(drawn: Figure, axes: Axes, columns: int = 4) -> None:
    """A legend of these axes below the whole figure, each name once."""
    handles, labels = axes.get_legend_handles_labels()
    named = dict(zip(labels, handles, strict=True))
    drawn.legend(
        list(named.values()),
        list(named),
        fontsize=SMALL,
        ncols=columns,
        loc="outside lower center",
        frameon=False,
    )
