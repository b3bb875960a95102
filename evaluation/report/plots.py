"""The study's figures as plots. Colours are Okabe and Ito's, told apart with every kind of colour
vision.
"""

from __future__ import annotations

import io
from typing import TYPE_CHECKING, Any

import numpy as np

from evaluation.figures import Figures
from evaluation.inputs.scenes import KINDS
from evaluation.inputs.sources import STRUCTURE, TEXTURE
from evaluation.methods.detectors import MODES, PIXELS_PER_CORNER, PLAIN, WITHOUT
from evaluation.methods.localisation import INTEGER, OPENCV
from evaluation.report.paper_accuracy import MEAN_RHO
from evaluation.report.word_lengths_page import draw_word_lengths
from evaluation.sections import adaptation

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


COLOURS = {
    INTEGER: "#999999",
    "nine": "#e69f00",
    "six": "#f0e442",
    "printed": "#d55e00",
    "gradient": "#0072b2",
    OPENCV: "#cc79a7",
    PLAIN: "#000000",
    "paper": "#d55e00",
    "paper" + WITHOUT: "#e69f00",
    "robust": "#0072b2",
    "robust" + WITHOUT: "#56b4e9",
    "goodFeaturesToTrack": "#cc79a7",
    "FAST": "#009e73",
    "chance": "#999999",
}
_DPI = 100
FEWEST = 10
"""Corners per image below which rho is not drawn."""
NOTHING: Figures = {"value": None, "interval": None}


def colour(name: str) -> str:
    """Of a method or a detector; grey for one that nobody has thought of."""
    return COLOURS.get(name, "#444444")


def figure(width: float, height: float) -> Figure:
    """An empty figure of so many inches; matplotlib is only wanted here."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height), layout="constrained", dpi=_DPI)


def encoded(drawn: Figure, kind: str = "png") -> bytes:
    """The figure as a file of this kind, the same for the same figure."""
    file = io.BytesIO()
    if kind == "jpg":
        drawn.savefig(file, format=kind, pil_kwargs={"quality": 82, "optimize": True})
    else:
        drawn.savefig(file, format=kind, metadata={"Software": None})
    return file.getvalue()


def plots(study: Figures) -> dict[str, bytes]:
    """File names and contents; of what was not measured there is none."""
    drawn = {}
    if "accuracy" in study:
        drawn["accuracy.png"] = encoded(_accuracy(study["accuracy"]))
    if "repeatability" in study:
        drawn["repeatability.png"] = encoded(_repeatability(study["repeatability"]))
    if "texture" in study:
        drawn["texture.png"] = encoded(_texture(study["texture"]["steps"]))
    if "adaptation" in study:
        drawn["adaptation.png"] = adaptation.plot(study["adaptation"])
    if "word_lengths" in study:
        panels = figure(11, 3.4)
        draw_word_lengths(panels, study["word_lengths"])
        drawn["word_lengths.png"] = encoded(panels)
    if "robustness" in study:
        drawn["robustness.png"] = encoded(_robustness(study["robustness"]))
    return drawn


def _bars(axes: Axes, places: np.ndarray, estimates: list[Figures], **style: Any) -> None:
    """Bars with their intervals; a missing figure is no bar."""
    for place, each in zip(places, estimates, strict=True):
        if each["value"] is None:
            continue
        low, high = each["interval"] or [each["value"]] * 2
        ends = [[max(each["value"] - low, 0)], [max(high - each["value"], 0)]]
        axes.bar(place, each["value"], yerr=ends, capsize=2, error_kw={"linewidth": 1}, **style)
        style.pop("label", None)


def _own(axes: Axes) -> None:
    axes.spines[["top", "right"]].set_visible(False)
    axes.tick_params(labelsize="small")


def _accuracy(accuracy: Figures) -> Figure:
    drawn = figure(9, 3.6)
    left, right = drawn.subplots(1, 2, width_ratios=(1.5, 1))
    profile = "robust" if "robust" in accuracy else next(iter(accuracy))
    methods = [name for name in accuracy[profile][KINDS[0]]["methods"] if name not in ("six", "printed")]
    width = 0.8 / len(methods)
    for index, method in enumerate(methods):
        found = [accuracy[profile][kind]["methods"][method] for kind in KINDS]
        estimates = [{"value": each["median"], "interval": each["median_interval"]} for each in found]
        places = np.arange(len(KINDS)) + (index - (len(methods) - 1) / 2) * width
        _bars(left, places, estimates, width=width, color=colour(method), label=method)
        tails = [each["p95"] for each in found]
        left.plot(places, tails, linestyle="none", marker="_", markersize=10, color=colour(method))
    left.set_xticks(range(len(KINDS)), KINDS)
    left.set_yscale("log")
    left.set_ylabel("distance to the true corner, px")
    left.set_title(f"corners of {profile}: median, 95th percentile (dash)", fontsize="small")
    left.legend(fontsize="x-small", ncols=len(methods), loc="upper left", frameon=False)
    left.set_ylim(top=left.get_ylim()[1] * 2)
    for kind, line in zip(("L", "saddle"), ("-", "--"), strict=True):
        by_noise = accuracy[profile][kind]["median_by_noise"]
        for method in methods:
            values = [each[method] for each in by_noise.values()]
            noise = [float(level) for level in by_noise]
            right.plot(noise, values, line, marker="o", markersize=3, color=colour(method))
    right.set_yscale("log")
    right.set_xlabel("noise, grey levels")
    right.set_title("median; L solid, saddle dashed", fontsize="small")
    for axes in (left, right):
        _own(axes)
    return drawn


def _repeatability(found: Figures) -> Figure:
    drawn = figure(9, 3.6)
    left, right = drawn.subplots(1, 2, width_ratios=(1.25, 1))
    equal = found["modes"][MODES[0].name]
    parts = [part for part in next(iter(equal.values())) if part != "views"]
    width = 0.85 / len(equal)
    for index, (name, each) in enumerate(equal.items()):
        places = np.arange(len(parts)) + (index - (len(equal) - 1) / 2) * width
        estimates = [each[part]["repeatability"] for part in parts]
        _bars(left, places, estimates, width=width, color=colour(name), label=name)
    left.set_xticks(range(len(parts)), parts)
    left.set_ylabel(f"repeatability at {found['tolerance']} px")
    left.set_title(f"equal numbers, a corner for every {PIXELS_PER_CORNER} pixels or so", fontsize="small")
    for name in equal:
        curve = [(1000 / point["pixels_per_corner"], point[name]) for point in found["curve"]]
        if curve:
            right.plot(*zip(*curve, strict=True), marker="o", markersize=3, color=colour(name), label=name)
    right.set_xlabel("corners per 1000 pixels, equal for all")
    right.set_ylim(bottom=0)
    right.set_title("all photographs", fontsize="small")
    for axes in (left, right):
        _own(axes)
    handles, labels = left.get_legend_handles_labels()
    drawn.legend(handles, labels, fontsize="x-small", ncols=4, loc="outside lower center", frameon=False)
    return drawn


def _robustness(found: Figures) -> Figure:
    drawn = figure(9, 3.6)
    axes = drawn.subplots()
    modes = [name for name, each in found["modes"].items() if any(_some(part) for part in each.values())]
    detectors = list(found["modes"][modes[0]])
    width = 0.85 / len(detectors)
    for index, name in enumerate(detectors):
        places = np.arange(len(modes)) + (index - (len(detectors) - 1) / 2) * width
        parts = [found["modes"][mode][name] for mode in modes]
        estimates = [part["all"]["rho"] if _some(part) else NOTHING for part in parts]
        _bars(axes, places, estimates, width=width, color=colour(name), label=name)
    for value, style, text in zip(MEAN_RHO, (":", "--"), ("Shi-Tomasi", "the paper's"), strict=True):
        axes.axhline(value, color="black", linewidth=0.8, linestyle=style)
        axes.text(len(modes) - 0.5, value, f" Table 6,\n {text}", fontsize="x-small", va="center")
    axes.set_xticks(range(len(modes)), [mode.replace(" at ", "\nat ") for mode in modes])
    axes.set_xlim(-0.5, len(modes) - 0.5)
    axes.set_ylim(0, 1)
    axes.set_ylabel("rho = tracked / detected")
    _own(axes)
    handles, labels = axes.get_legend_handles_labels()
    drawn.legend(handles, labels, fontsize="x-small", ncols=4, loc="outside lower center", frameon=False)
    return drawn


def _texture(steps: Figures) -> Figure:
    drawn = figure(9, 3)
    names = [name for name in steps if name != PLAIN]
    for axes, measure in zip(drawn.subplots(1, 2, sharey=True), ("repeatability", "rho"), strict=True):
        parts = [part for part in ("all", TEXTURE, STRUCTURE) if part in steps[PLAIN][measure]]
        for index, (part, shade) in enumerate(zip(parts, ("#000000", "#009e73", "#0072b2"), strict=False)):
            for place, name in enumerate(names):
                gain = steps[name][measure][part]["gain"]
                if gain["value"] is None:
                    continue
                ends = [100 * end for end in (gain["value"], *(gain["interval"] or [gain["value"]] * 2))]
                spread = [[max(ends[0] - ends[1], 0)], [max(ends[2] - ends[0], 0)]]
                label = part if not place else None
                height = place + (index - 1) * 0.2
                axes.errorbar(ends[0], height, xerr=spread, fmt="o", markersize=4, color=shade, label=label)
        axes.axvline(0, color="black", linewidth=0.8)
        axes.set_yticks(range(len(names)), names)
        axes.set_ylim(len(names) - 0.5, -0.5)
        axes.set_xlabel(f"gain over {PLAIN}, %")
        axes.set_title(f"{measure}, equal numbers", fontsize="small")
        _own(axes)
    drawn.axes[0].legend(fontsize="x-small", frameon=False)
    return drawn


def _some(part: Figures) -> bool:
    return (part["all"]["corners"] or 0) >= FEWEST
