"""The sweep of word lengths for the page: its figures as tables, and a plot of area against
accuracy.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from evaluation.figures import Figures
from evaluation.report.markdown import figure, number, table

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


SWEEPS = {"tensor": "A, B, C", "response": "D", "mantissa": "mantissas"}


def word_lengths_tables(found: Figures) -> Figures:
    """A table for each sweep; the default is bold."""
    tensor, response = (
        [
            [
                _bits(point),
                number(point["area"]["le"]),
                number(point["area"]["memory_bits"]),
                figure(point["same"], 3),
                *(figure(point[kind]["median"]) for kind in ("L", "saddle")),
            ]
            for point in found[name]
        ]
        for name in ("tensor", "response")
    )
    headings = ["LE", "memory bits", "the same corners", "L, px", "saddle, px"]
    mantissas = [
        [
            _bits(point),
            number(point["area"]["le"]),
            number(point["clocks"]),
            *(figure(point["error"][share], 3) for share in ("median", "p95", "p99")),
        ]
        for point in found["mantissa"]
    ]
    return {
        "blocks": found["blocks"],
        "tensor": table(["bits of A, B, C", *headings], tensor),
        "response": table(["bits of D", *headings], response),
        "mantissa": table(["bits", "LE", "clocks per corner", "median error, px", "95 %", "99 %"], mantissas),
    }


def _bits(point: Figures) -> str:
    return f"**{point['bits']}**" if point["default"] else str(point["bits"])


def draw_word_lengths(drawn: Figure, found: Figures) -> None:
    """Into an empty figure: of each sweep area and accuracy over bits."""
    panels = drawn.subplots(1, len(SWEEPS))
    for axes, (name, title) in zip(panels, SWEEPS.items(), strict=True):
        points = found[name]
        bits = [point["bits"] for point in points]
        axes.set_title(title, fontsize="medium")
        axes.set_xlabel("bits")
        axes.plot(bits, [point["area"]["le"] for point in points], "s-", color="#0072b2")
        axes.set_ylim(bottom=0)
        axes.set_ylabel("logic elements", color="#0072b2")
        other = axes.twinx()
        if name == "mantissa":
            _line(other, bits, [point["error"]["p99"] for point in points])
            other.set_yscale("log")
            other.set_ylabel("99th percentile of the error, px", color="#d55e00")
        else:
            _line(other, bits, [point["same"] for point in points])
            other.set_ylim(0, 1.05)
            other.set_ylabel("share of the same corners", color="#d55e00")
        default = next((point["bits"] for point in points if point["default"]), None)
        if default is not None:
            axes.axvline(default, color="#999999", linewidth=0.8, linestyle=":")
        for each in (axes, other):
            each.tick_params(labelsize="small")


def _line(axes: Axes, bits: list[int], estimates: list[Figures]) -> None:
    values = [estimate["value"] for estimate in estimates]
    ends = [[max(each["value"] - each["interval"][0], 0) for each in estimates]]
    ends.append([max(each["interval"][1] - each["value"], 0) for each in estimates])
    axes.errorbar(bits, values, yerr=ends, fmt="o-", color="#d55e00", capsize=2)
