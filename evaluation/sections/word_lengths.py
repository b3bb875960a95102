"""Savings and cost of fewer bits: in A, B and C, in D, and in the mantissas of the offset."""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING, Any

from evaluation.figures import Figures
from evaluation.methods.narrowing import steps, word_lengths
from evaluation.presentation import plots as style
from evaluation.presentation.numbers import figure, number
from evaluation.presentation.pictures import of_interest
from evaluation.presentation.table import Strong, Table
from evaluation.sections.section import Material, Section

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SWEEPS = {"tensor": "A, B, C", "response": "D", "mantissa": "mantissas"}


def measure(material: Material) -> Figures:
    """The sweep for ``robust``, or for the first profile that was chosen."""
    done = count(1)
    with material.progress("word lengths, with synthesis", steps()) as advance:
        return word_lengths(of_interest(material.profiles), notify=lambda _: advance(next(done)))


def tables(found: Figures) -> dict[str, Table]:
    """A table for each sweep; the default stands out."""
    return {
        "tensor": _cut("bits of A, B, C", found["tensor"]),
        "response": _cut("bits of D", found["response"]),
        "mantissa": Table(
            "Word lengths: mantissas of the gradient step's sums",
            ["bits", "LE", "clocks per corner", "median error, px", "95 %", "99 %"],
            [
                [
                    *(_bits(point), number(point["area"]["le"]), number(point["clocks"])),
                    *(figure(point["error"][share], 3) for share in ("median", "p95", "p99")),
                ]
                for point in found["mantissa"]
            ],
        ),
    }


def _cut(words: str, points: list[Figures]) -> Table:
    rows = [
        [
            *(_bits(point), number(point["area"]["le"]), number(point["area"]["memory_bits"])),
            figure(point["same"], 3),
            *(figure(point[kind]["median"]) for kind in ("L", "saddle")),
        ]
        for point in points
    ]
    headings = [words, "LE", "memory bits", "the same corners", "L, px", "saddle, px"]
    return Table(f"Word lengths: {words}", headings, rows)


def _bits(point: Figures) -> str:
    return Strong(point["bits"]) if point["default"] else str(point["bits"])


def plot(found: Figures) -> bytes:
    """Area above, accuracy below, over the bits of each sweep."""
    drawn = style.figure(4.8)
    panels = drawn.subplots(2, len(SWEEPS), sharex="col")
    for (area, accuracy), (name, title) in zip(panels.T, SWEEPS.items(), strict=True):
        points = found[name]
        area.set_title(title, fontsize=10)
        area.plot(
            [point["bits"] for point in points],
            [point["area"]["le"] for point in points],
            *("s-",),
            color="#0072b2",
            linewidth=2,
        )
        area.set_ylim(0, 1.15 * max(point["area"]["le"] for point in points))
        _accuracy(accuracy, points, mantissas=name == "mantissa")
        accuracy.set_xlabel("bits")
        for axes in (area, accuracy):
            style.plain(axes, grid="y")
            for point in points:
                if point["default"]:
                    axes.axvline(point["bits"], color="#555555", linewidth=1, linestyle=":")
                    axes.text(
                        *(point["bits"], 0.03, " default"),
                        transform=axes.get_xaxis_transform(),
                        fontsize=style.SMALL,
                        ha="right",
                    )
    panels[0, 0].set_ylabel("logic elements")
    return style.plot_file(drawn)


def _accuracy(axes: Axes, points: list[Figures], *, mantissas: bool) -> None:
    estimates = [point["error"]["p99"] if mantissas else point["same"] for point in points]
    for point, estimate in zip(points, estimates, strict=True):
        style.point(axes, point["bits"], estimate, flat=False, color="#d55e00")
    bits, values = [point["bits"] for point in points], [estimate["value"] for estimate in estimates]
    axes.plot(bits, values, color="#d55e00", linewidth=2)
    if mantissas:
        style.logarithmic(axes, (0.005, 0.01, 0.02, 0.05, 0.1, 0.2))
        axes.set_ylabel("99th percentile of error, px")
    else:
        axes.set_ylim(0, 1.05)
        axes.set_ylabel("share of the same corners")


def facts(found: Figures) -> dict[str, Any]:
    """Which blocks hold the numbers."""
    return {"blocks": found["blocks"]}


SECTION = Section(
    name="word_lengths",
    title="Word lengths",
    measure=measure,
    tables=tables,
    plots={"word_lengths.png": plot},
    facts=facts,
    needs=frozenset({"photographs", "synthesis"}),
    options=frozenset({"profiles"}),
    not_quick="it maps blocks to Cyclone IV, which takes minutes",
)
