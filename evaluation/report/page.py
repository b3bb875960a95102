"""The page that shows how good the corners are: the study's figures as tables, for the template's
prose.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from evaluation.figures import Figures
from evaluation.inputs.scenes import BLURS, CONTRASTS, KINDS, NOISES, OPENINGS
from evaluation.inputs.sources import FRAMES_APART, PAIRS_PER_VIDEO, STRUCTURE, TEXTURE
from evaluation.inputs.views import VIEWS
from evaluation.methods.detectors import MODES, PAPER_LOW, PLAIN, USUAL, WITHOUT
from evaluation.methods.localisation import INTEGER, OPENCV
from evaluation.report import paper_accuracy as paper
from evaluation.report.markdown import figure, number, percent, spread, table
from evaluation.report.word_lengths_page import word_lengths_tables
from evaluation.sections.accuracy import WITHIN
from flow.templates import render

FIGURES_NAME = "evaluation.json"
PAGE_NAME = "evaluation.md"
PICTURES = "evaluation"
"""Folder of the pictures, beside the page."""
FEWEST = 10
"""Corners per image below which nothing is said of them."""


def page(study: Figures) -> str:
    """The whole page, as Markdown. What was not measured is left out."""
    known = {
        "about": study["about"],
        "packages": ", ".join(f"{name} {of}" for name, of in study["about"]["packages"].items() if of),
        "usual": USUAL,
        "fewest": FEWEST,
        "within": f"{WITHIN:g}",
        "openings": _list(OPENINGS),
        "contrasts": " to ".join(map(str, CONTRASTS)),
        "blurs": " to ".join(map(str, BLURS)),
        "noises": _list(NOISES),
        "views": [view.name for view in VIEWS],
        "per_video": PAIRS_PER_VIDEO,
        "apart": FRAMES_APART,
        "tracker": study.get("robustness", {}).get("tracker"),
        "summary": _summary(study),
    }
    for name, write in (
        ("accuracy", _accuracy),
        ("table5", _table_5),
        ("repeatability", _repeatability),
        ("pairs", _repeatability),
        ("robustness", _robustness),
        ("texture", _texture),
        ("adaptation", _adaptation),
        ("references", _references),
        ("word_lengths", word_lengths_tables),
    ):
        known[name] = write(study[name]) if study.get(name) else None
    known["boards"] = [_boards(name, found) for name, found in study.get("chessboards", {}).items() if found]
    return render(Path(__file__).with_name("templates"), PAGE_NAME, known)


def _list(values: tuple[float, ...]) -> str:
    *first, last = (f"{value:g}" for value in values)
    return f"{', '.join(first)} and {last}"


def _median(each: Figures) -> str:
    return spread(each["median"], each["median_interval"])


def _named(method: str, fit: str) -> str:
    return f"**{method}**" if method == fit else method


def _summary(study: Figures) -> str | None:
    """What a user wants to know first; None unless all of it was measured."""
    if not all(study.get(name) for name in ("accuracy", "chessboards", "repeatability", "robustness")):
        return None
    profiles = list(study["accuracy"])
    rows = []
    for kind in KINDS:
        cells = [_median(study["accuracy"][profile][kind]) for profile in profiles]
        opencv = study["accuracy"][profiles[-1]][kind]["methods"][OPENCV]
        rows.append([f"distance to the true corner, {kind}, px", *cells, _median(opencv), ""])
    for name, boards in study["chessboards"].items():
        if boards:
            each = [boards["profiles"][profile] for profile in profiles]
            cells = [_median(one["methods"][one["fit"]]) for one in each]
            opencv = each[-1]["methods"][OPENCV]
            rows.append([f"... of {name} chessboards, px", *cells, _median(opencv), ""])
    for section, measure, words in (
        ("repeatability", "repeatability", "repeatability"),
        ("robustness", "rho", "ρ"),
    ):
        equal = study[section]["modes"][MODES[0].name]
        for part in ("all", "foliage and texture", "structure"):
            names = [*profiles, "goodFeaturesToTrack", "FAST"]
            rows.append([f"{words}, {part}", *(figure(equal[name][part][measure]) for name in names)])
    headings = [
        "medians; at equal numbers of corners",
        *(f"`{name}`" for name in profiles),
        "OpenCV's Shi-Tomasi, `cornerSubPix`",
        "FAST",
    ]
    return table(headings, rows)


def _accuracy(accuracy: Figures) -> Figures:
    tables = []
    for profile, kinds in accuracy.items():
        methods = [_named(method, kinds["fit"]) for method in kinds[KINDS[0]]["methods"]]
        rows = [
            [
                kind,
                figure(kinds[kind]["detected"]),
                figure(kinds[kind]["accepted"]),
                *(f"{_median(each)}, {number(each['p95'], 2)}" for each in kinds[kind]["methods"].values()),
            ]
            for kind in KINDS
        ]
        tables.append(table([f"`{profile}`", "found", "accepted", *methods], rows))
    scenes = next(iter(accuracy.values()))[KINDS[0]]["scenes"]
    return {"scenes": scenes, "tables": tables, "bias": _bias(accuracy)}


def _bias(accuracy: Figures) -> str:
    rows = []
    for profile, kinds in accuracy.items():
        for method, inwards in kinds["L"]["inwards"].items():
            cells = []
            for kind in ("L", "saddle"):
                each = kinds[kind]["methods"][method]
                cells += [spread(each[axis], each[f"{axis}_interval"]) for axis in ("bias_x", "bias_y")]
            rows.append([f"`{profile}`", _named(method, kinds["fit"]), *cells, figure(inwards)])
    return table(["profile", "method", "L: x", "y", "saddle: x", "y", "L: inwards"], rows, "ll")


def _table_5(found: Figures) -> Figures:
    headings = ["image", "paper: Shi-Tomasi", "paper: this work"]
    for profile, figures in found.items():
        headings += [f"`{profile}`: whole pixel", f"`{profile}`: {figures['fit']}"]
    rows = []
    for index, printed in enumerate(paper.TABLE_5):
        cells = [printed.shape, _position(printed.shi_tomasi, 0), _position(printed.paper)]
        for figures in found.values():
            row = figures["rows"][index]
            cells += [_position(row[INTEGER], 0), _position(row[figures["fit"]])]
        rows.append(cells)
    columns = ["detector", "method", "x", "y", "lines rotated: x", "y", "other positions: x", "y"]
    elsewhere = next(iter(found.values()))["elsewhere"]["scenes"] // len(paper.TABLE_5)
    means = table(columns, _table_5_means(found), "ll")
    return {"rows": table(headings, rows), "means": means, "elsewhere": elsewhere}


def _position(position: Any, digits: int = 2) -> str:
    return "–" if position is None else f"{position[0]:.{digits}f}, {position[1]:.{digits}f}"


def _table_5_means(found: Figures) -> Iterator[list[str]]:
    for text, error in (("whole pixel", paper.MEAN_ERROR_INTEGER), ("surface", paper.MEAN_ERROR)):
        yield ["the paper", text, *(f"{axis:g}" for axis in error), "", "", "", ""]
    for profile, figures in found.items():
        for method in (name for name, each in figures["methods"].items() if isinstance(each, dict)):
            parts = (figures[part][method] for part in ("methods", "rotation", "elsewhere"))
            cells = [figure(part[axis]) for part in parts for axis in ("x", "y")]
            yield [f"`{profile}`", _named(method, figures["fit"]), *cells]


def _boards(name: str, boards: Figures) -> Figures:
    tables = []
    for profile, figures in boards["profiles"].items():
        methods = [_named(method, figures["fit"]) for method in figures["methods"]]
        rows = [
            [text, *(spread(each[key], each[f"{key}_interval"]) for each in figures["methods"].values())]
            for text, key in (("median", "median"), ("95 %", "p95"), ("bias x", "bias_x"), ("y", "bias_y"))
        ]
        shares = f"found {figure(figures['detected'])}, accepted {figure(figures['accepted'])}"
        tables.append(table([f"`{profile}`: {shares}", *methods], rows))
    return {
        "name": name,
        "count": boards["boards"],
        "corners": boards["corners"],
        "not_found": boards["not_found"],
        "given": f"{boards['names'][0]} to {boards['names'][-1]}" if boards["names"] else "none",
        "reference": _median(boards["reference"]) if boards["reference"] else None,
        "tables": tables,
    }


def _repeatability(found: Figures) -> Figures:
    equal = found["modes"][MODES[0].name]
    fits = [
        [name, figure(each["repeatability"], 3), figure(each["localisation"], 3)]
        for name, each in found["fits"].items()
    ]
    views = [
        [view, *(number(each["views"].get(view), 2) for each in equal.values())]
        for view in equal[PLAIN]["views"]
    ]
    return {
        "pairs": found["pairs"],
        "tolerance": found["tolerance"],
        "scenes": len(found["scenes"]),
        "names": found["scenes"],
        "modes": list(_modes(found["modes"], "repeatability", "localisation")),
        "fits": table(["fit", "repeatability", "localisation, px"], fits),
        "views": table(["view", *equal], views),
    }


def _modes(modes: Figures, measure: str, other: str | None) -> Iterator[tuple[str, str]]:
    for mode, each in modes.items():
        parts = next(iter(each.values()))
        groups = [part for part in parts if part not in ("all", "views", "video", "rendered")][:2]
        headings = ["detector", "corners", "all", *groups, *([other] if other else [])]
        headings += ["gain of its filter", f"gain over {PLAIN}", *(f"... {group}" for group in groups)]
        title = f"{mode[0].upper()}{mode[1:]}"
        yield title, table(headings, _mode_rows(each, groups, measure, other))


def _mode_rows(each: Figures, groups: list[str], measure: str, other: str | None) -> Iterator[list[str]]:
    for name, parts in each.items():
        everything = parts["all"]
        cells = [name, number(everything["corners"])]
        if (everything["corners"] or 0) < FEWEST:
            yield cells + ["–"] * (4 + 2 * len(groups) - (other is None))
            continue
        cells += [figure(parts[part][measure]) for part in ("all", *groups)]
        if other:
            cells.append(figure(everything[other]))
        cells.append(percent(everything["gain"].get(name + WITHOUT)))
        cells += [percent(parts[part]["gain"].get(PLAIN)) for part in ("all", *groups)]
        yield cells


def _texture(found: Figures) -> Figures:
    rows = []
    for name, measures in found["steps"].items():
        cells = [name, number(measures["repeatability"]["all"]["corners"])]
        for measure in ("repeatability", "rho"):
            for part in ("all", TEXTURE, STRUCTURE):
                each = measures[measure].get(part)
                cells += [f"{figure(each[measure])}, {percent(each['gain'])}"] if each else ["–"]
        rows.append(cells)
    parts = ("all", TEXTURE, STRUCTURE)
    headings = [f"{words}: {part}" for words in ("repeatability", "ρ") for part in parts]
    last = found["steps"][list(found["steps"])[-1]]
    gains = {
        measure: percent(last[measure].get(TEXTURE, last[measure]["all"])["gain"])
        for measure in ("repeatability", "rho")
    }
    return {"table": table(["each with those before it", "corners", *headings], rows), **gains}


def _adaptation(found: Figures) -> Figures:
    rows = [
        [target, law, number(series["summary"]["frames"]), f"{100 * series['summary']['median_error']:.0f} %"]
        + [f"{100 * share:.0f} %" for share in series["summary"]["within"].values()]
        for target, laws in found["targets"].items()
        for law, series in laws.items()
    ]
    summary = next(iter(next(iter(found["targets"].values())).values()))["summary"]
    within = [f"within {100 * float(share):g} %" for share in summary["within"]]
    headings = ["target", "law", "frames judged", "median error", *within]
    return {"size": "×".join(map(str, found["size"])), "table": table(headings, rows, "ll")}


def hot_pixels(found: Figures) -> tuple[list[str], list[list[str]]]:
    """Headings and rows: corners with hot pixels over corners without, by reference."""
    profiles = found["profiles"]
    counts = list(next(iter(next(iter(profiles.values()))["hot"].values())))
    headings = ["reference", *(f"{profile}, {count} hot" for profile in profiles for count in counts)]
    rows = []
    for rank in next(iter(profiles.values()))["hot"]:
        cells = [profiles[profile]["hot"][rank][count] for profile in profiles for count in counts]
        name = f"rank {rank}" if rank != "0" else "the largest D"
        spreads = [f"{each['median']:.2f} ({each['least']:.2f} to {each['most']:.2f})" for each in cells]
        rows.append([name, *spreads])
    return headings, rows


def flicker(found: Figures) -> tuple[list[str], list[list[str]]]:
    """Headings and rows: corners in frames of full and of less light by turns, by reference."""
    profiles = found["profiles"]
    headings = [
        "reference",
        *(f"{profile}, gain {gain:g}" for profile in profiles for gain in found["gains"]),
    ]
    kinds = list(next(iter(profiles.values()))["flicker"])
    rows = [[kind, *(str(n) for each in profiles.values() for n in each["flicker"][kind])] for kind in kinds]
    return headings, rows


def _references(found: Figures) -> Figures:
    named = ("photographs", "sigma1", "draws", "contrast", "floor")
    return {
        **{name: found[name] for name in named},
        "gains": _list(tuple(found["gains"])),
        "hot": table(*hot_pixels(found)),
        "flicker": table(*flicker(found)),
    }


def _robustness(found: Figures) -> Figures:
    return {
        "pairs": found["pairs"],
        "table_6": _table_6(found["modes"], found["videos"]),
        "modes": list(_modes(found["modes"], "rho", None)),
    }


def _table_6(modes: Figures, videos: list[str]) -> str:
    rows = [
        ["the paper", f"{index}", _share(*row.shi_tomasi), _share(*row.paper), "", ""]
        for index, row in enumerate(paper.TABLE_6, start=1)
    ]
    low = modes[f"thresholds {PAPER_LOW.name}"]
    same = modes[f"as many as paper at {PAPER_LOW.name}"]
    for video in videos:
        columns = ((low, "paper" + WITHOUT), (low, "paper"), (same, "paper" + WITHOUT), (same, "chance"))
        parts = [mode[name][video] for mode, name in columns]
        rows.append(["ours", video, *(_share(part["tracked"], part["given"]) for part in parts)])
    headings = [
        *("", "video", f"Shi-Tomasi (ours: `paper` without filter, σ1 = {PAPER_LOW.sigma1})"),
        f"this work (ours: `paper`, {PAPER_LOW.name})",
        "as many of Shi-Tomasi's strongest",
        "as many points anywhere",
    ]
    return table(headings, rows, "ll")


def _share(tracked: int, given: int) -> str:
    return f"{tracked:,} / {given:,} = {tracked / given:.2f}" if given else "none detected"
