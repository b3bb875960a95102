"""Plot of area by block."""

from __future__ import annotations

import importlib.util
import io
from pathlib import Path

from cornerstream.errors import BadInput
from evaluation.presentation.plots import SMALL, WIDTH
from flow.cyclone4.area import Area

FORMATS = ("png", "svg", "pdf")
COLOURS = ("#0072b2", "#56b4e9", "#e69f00")
"""Okabe and Ito's colours, distinct for every kind of colour vision."""


def check_plot(path: Path) -> None:
    """:class:`BadInput` if the file's name is wrong, or matplotlib is missing."""
    if path.suffix.lower().removeprefix(".") not in FORMATS:
        allowed = ", ".join(f".{name}" for name in FORMATS)
        raise BadInput(
            f"plot cannot be written to {str(path)!r}; allowed: a file whose name ends in {allowed}"
        )
    if importlib.util.find_spec("matplotlib") is None:
        raise BadInput("matplotlib is not installed: pip install 'cornerstream[synth]'")


def draw_area(areas: dict[str, Area], title: str, kind: str) -> bytes:
    """Bars of logic elements by block, largest first, each divided by contents.

    Parameters
    ----------
    areas
        Areas by name of the block.
    title
        Text above the plot.
    kind
        One of :data:`FORMATS`.
    """
    # not at the top: the other commands do without it
    from matplotlib.figure import Figure

    blocks = sorted(areas.items(), key=lambda item: item[1].le_packed)
    names = [name for name, _ in blocks]
    parts = {
        "table and flip-flop": [area.packed_pairs for _, area in blocks],
        "table only": [area.lut4 - area.packed_pairs for _, area in blocks],
        "flip-flop only": [area.ff - area.packed_pairs for _, area in blocks],
    }
    figure = Figure(figsize=(WIDTH, 1.4 + 0.32 * len(blocks)), layout="constrained")
    axes = figure.subplots()
    left = [0] * len(blocks)
    for (label, widths), colour in zip(parts.items(), COLOURS, strict=True):
        axes.barh(names, widths, left=left, label=label, color=colour)
        left = [start + width for start, width in zip(left, widths, strict=True)]
    for place, (_, area) in enumerate(blocks):
        memory = f", {area.m9k} M9K" if area.m9k else ""
        axes.text(area.le_packed, place, f" {area.le_packed:,}{memory}", va="center", fontsize=SMALL)
    axes.margins(x=0.18, y=0.01)
    axes.set_xlabel("logic elements of Cyclone IV (estimate)")
    axes.set_title(title, fontsize=10)
    axes.tick_params(labelsize=SMALL)
    axes.tick_params(axis="y", length=0)
    axes.grid(axis="x", color="#dddddd", linewidth=0.7)
    axes.set_axisbelow(True)
    axes.legend(loc="lower right", fontsize=SMALL, frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    picture = io.BytesIO()
    figure.savefig(picture, format=kind, dpi=150)
    return picture.getvalue()
