"""The study for people: its figures as tables, each with its 95 % interval."""

from __future__ import annotations

from collections.abc import Iterator

from rich.table import Table

from evaluation.figures import Figures
from evaluation.methods.detectors import PLAIN
from evaluation.report.markdown import figure, percent, spread
from evaluation.report.page import flicker, hot_pixels
from evaluation.report.paper_accuracy import MEAN_ERROR, MEAN_ERROR_INTEGER
from evaluation.report.study import Section

TABULATED: tuple[Section, ...] = (
    *("accuracy", "table5", "chessboards", "repeatability", "robustness"),
    "references",
)
"""Sections that have a table here; all of them are on the page and in the JSON."""


def tables(study: Figures) -> Iterator[Table]:
    """A table for each section that was measured."""
    if "accuracy" in study:
        yield _accuracy(study["accuracy"])
    if "table5" in study:
        yield _table_5(study["table5"])
    for name, boards in study.get("chessboards", {}).items():
        if boards:
            yield _chessboards(name, boards)
    for key, title in (("repeatability", "rendered views"), ("pairs", "given pairs")):
        if study.get(key):
            yield _repeatability(title, study[key])
    if "robustness" in study:
        yield _robustness(study["robustness"])
    if "references" in study:
        found = study["references"]
        yield _plain(
            "Corners with hot pixels over corners without: median (least to most)", *hot_pixels(found)
        )
        yield _plain("Corners in light that flickers", *flicker(found))


def _plain(title: str, headings: list[str], rows: list[list[str]]) -> Table:
    table = _table(title, *headings)
    for row in rows:
        table.add_row(*row)
    return table


def _table(title: str, *headings: str, caption: str | None = None) -> Table:
    table = Table(title=title, caption=caption)
    for index, heading in enumerate(headings):
        table.add_column(heading, justify="right" if index else "left", no_wrap=not index)
    return table


def _accuracy(accuracy: Figures) -> Table:
    table = _table(
        "Rendered corners: distance to the true corner, px",
        *("profile", "corner", "found", "accepted", "method", "median", "95 %", "bias x", "bias y"),
        caption="found: D has a peak above T1; accepted: the texture filter lets it pass, too",
    )
    for profile, kinds in accuracy.items():
        for kind, figures in kinds.items():
            if kind == "fit":
                continue
            first = [profile, kind, figure(figures["detected"]), figure(figures["accepted"])]
            for method, each in figures["methods"].items():
                table.add_row(*first, _own(method, kinds["fit"]), *_errors(each))
                first = [""] * 4
            table.add_section()
    return table


def _own(method: str, fit: str) -> str:
    return f"{method} *" if method == fit else method


def _errors(each: Figures) -> list[str]:
    medians = [spread(each[name], each[f"{name}_interval"], 3) for name in ("median", "p95")]
    return medians + [spread(each[name], None, 3) for name in ("bias_x", "bias_y")]


def _table_5(table_5: Figures) -> Table:
    table = _table(
        "The paper's Table 5: mean of |dx| and |dy| over its eight images, px",
        *("profile", "method", "x", "y", "at random positions: x", "y"),
        caption=f"the paper: integer {MEAN_ERROR_INTEGER}, its surface {MEAN_ERROR}; * the profile's own",
    )
    for profile, figures in table_5.items():
        for method, each in figures["methods"].items():
            if isinstance(each, dict):
                elsewhere = figures["elsewhere"][method]
                cells = [figure(part[axis]) for part in (each, elsewhere) for axis in ("x", "y")]
                table.add_row(profile, _own(method, figures["fit"]), *cells)
        table.add_section()
    return table


def _chessboards(name: str, boards: Figures) -> Table:
    table = _table(
        f"Chessboards, {name}: distance to the reference, px ({boards['boards']} boards)",
        *("profile", "found", "accepted", "method", "median", "95 %", "bias x", "bias y"),
        caption=f"{boards['corners']} corners; {boards['not_found']} boards without a reference are left out",
    )
    for profile, figures in boards["profiles"].items():
        first = [profile, figure(figures["detected"]), figure(figures["accepted"])]
        for method, each in figures["methods"].items():
            table.add_row(*first, _own(method, figures["fit"]), *_errors(each))
            first = [""] * 3
        table.add_section()
    return table


def _by_mode(title: str, modes: Figures, measure: str, caption: str) -> Table:
    table = _table(
        title, "mode", "detector", "corners", "all", *_groups(modes), "gain over D", caption=caption
    )
    for mode, detectors in modes.items():
        first = mode
        for name, parts in detectors.items():
            gain = parts["all"]["gain"].get(PLAIN)
            cells = [figure(parts[group][measure]) for group in ("all", *_groups(modes))]
            corners = parts["all"]["corners"]
            table.add_row(first, name, "–" if corners is None else f"{corners:.0f}", *cells, percent(gain))
            first = ""
        table.add_section()
    return table


def _groups(modes: Figures) -> list[str]:
    parts = next(iter(next(iter(modes.values())).values()))
    return [name for name in parts if name not in ("all", "views", "video", "rendered")][:2]


def _repeatability(title: str, found: Figures) -> Table:
    return _by_mode(
        f"Repeatability at {found['tolerance']} px, {title} ({found['pairs']} pairs)",
        *(found["modes"], "repeatability"),
        caption="corners: mean number per view; intervals over photographs",
    )


def _robustness(found: Figures) -> Table:
    return _by_mode(
        f"Robustness rho = tracked / detected ({found['pairs']} pairs)",
        *(found["modes"], "rho"),
        caption="corners: mean number per first view; intervals over photographs and frames",
    )
