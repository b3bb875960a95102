"""The page about the quality of corners: sections in order, with prose, tables and plots."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from evaluation.figures import Figures
from evaluation.inputs.scenes import KINDS
from evaluation.inputs.sources import STRUCTURE, TEXTURE
from evaluation.methods.detectors import MARGIN, MODES, USUAL, WITHOUT
from evaluation.methods.localisation import OPENCV
from evaluation.presentation.markdown import markdown, titled
from evaluation.presentation.modes import FEWEST
from evaluation.presentation.numbers import figure, spread
from evaluation.presentation.table import Table
from evaluation.sections.registry import SECTIONS
from evaluation.sections.section import Section
from flow.templates import render

FIGURES_NAME = "evaluation.json"
PAGE_NAME = "evaluation.md"
PICTURES = "evaluation"
"""Folder of the pictures, beside the page."""
_TEMPLATES = Path(__file__).with_name("templates")


def page(study: Figures) -> str:
    """The whole page, as Markdown. What was not measured is left out."""
    about = study["about"]
    summary = _summary(study)
    known = {
        "about": about,
        "packages": ", ".join(f"{name} {of}" for name, of in about["packages"].items() if of),
        "summary": markdown(summary) if summary else None,
        "usual": USUAL,
        "margin": MARGIN,
        "fewest": FEWEST,
    }
    parts = [render(_TEMPLATES, "head.md", known)]
    parts += [_section(section, study[name]) for name, section in SECTIONS.items() if study.get(name)]
    parts.append(render(_TEMPLATES, "method.md", known))
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def plots(study: Figures) -> dict[str, bytes]:
    """File names and contents of the plots; none of what was not measured."""
    return {
        file: draw(study[name])
        for name, section in SECTIONS.items()
        if study.get(name)
        for file, draw in section.plots.items()
    }


def _section(section: Section, figures: Figures) -> str:
    own = f"{section.name}.md"
    known = {
        "section": section,
        "found": figures,
        "tables": section.tables(figures),
        "facts": section.facts(figures),
        "pictures": PICTURES,
        "markdown": markdown,
        "titled": titled,
    }
    text = render(_TEMPLATES, own if (_TEMPLATES / f"{own}.j2").is_file() else "section.md", known)
    return f"## {section.title}\n\n{text}"


def _summary(study: Figures) -> Table | None:
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
    for measure, words, modes in (
        ("repeatability", "repeatability", study["repeatability"]["rendered"]["modes"]),
        ("rho", "ρ", study["robustness"]["modes"]),
    ):
        equal = modes[MODES[0].name]
        names = [*profiles, "goodFeaturesToTrack", "FAST"]
        for part in ("all", TEXTURE, STRUCTURE):
            if part in equal[profiles[0]]:
                rows.append([f"{words}, {part}", *(figure(equal[name][part][measure]) for name in names)])
    rows += _uses(study, profiles)
    headings = [
        "medians; at equal numbers of corners",
        *profiles,
        "OpenCV's Shi-Tomasi, cornerSubPix",
        "FAST",
    ]
    return Table("Which profile for what", headings, rows)


def _uses(study: Figures, profiles: list[str]) -> Iterator[list[str]]:
    """What the corners of each profile give: homographies, and depth."""
    if study.get("downstream"):
        count, by_name = list(study["downstream"]["numbers"].items())[-1]
        cells = (figure(by_name[name]["all"]["error"]) for name in _placed(by_name, profiles))
        yield [f"error of homographies from {count} corners, px", *cells]
    if study.get("reconstruction"):
        by_name = study["reconstruction"]["detectors"]
        yield ["error of depth, %", *(figure(by_name[name]["median"]) for name in _placed(by_name, profiles))]


def _placed(found: Figures, profiles: list[str]) -> list[str]:
    names = [name if name in found else name + WITHOUT for name in profiles]
    return [*names, f"goodFeaturesToTrack, {OPENCV}", "FAST"]


def _median(each: Figures) -> str:
    return spread(each["median"], each["median_interval"])
