"""Robustness as in the paper: rho = corners that a tracker finds again / corners given to it."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import FRAMES_APART, PAIRS_PER_VIDEO, Pair
from evaluation.methods.bootstrap import estimate, mean, relative_gain
from evaluation.methods.detectors import (
    PAPER_LOW,
    WITHOUT,
    DetectionCache,
    Detector,
    Mode,
    Points,
    detectors,
    modes_of,
)
from evaluation.methods.grouping import by_scene, figures_of_parts, parts_of
from evaluation.methods.matching import TOLERANCE, project
from evaluation.methods.tracker import (
    LARGEST_RETURN_ERROR,
    LEAST_CORRELATION,
    REACH,
    WINDOW,
    TrackCache,
    Tracks,
)
from evaluation.presentation import paper_accuracy as paper
from evaluation.presentation import plots as style
from evaluation.presentation.modes import draw_parts, mode_tables, some
from evaluation.presentation.table import Table
from evaluation.sections.section import Material, Section

VIDEO = "video"
"""Name of all pairs whose homography nobody knows."""


class Score(NamedTuple):
    """One detector on one pair: corners given, corners tracked, and corners tracked rightly.

    The last number is known only for pairs with a homography.
    """

    given: int
    tracked: int
    right: float

    @property
    def rho(self) -> float:
        """NaN without corners."""
        return self.tracked / self.given if self.given else float("nan")


def farthest(pair: Pair) -> float:
    """Largest distance that a point of the first view moves, along x or y; 0 if not known."""
    if pair.homography is None:
        return 0.0
    height, width = pair.first.shape
    corners = np.array([(x, y) for x in (0.0, width - 1) for y in (0.0, height - 1)])
    return float(np.abs(project(corners, pair.homography) - corners).max())


def trackable(pairs: list[Pair], reach: int = REACH) -> list[Pair]:
    """The pairs of one size in which every known movement is within the tracker's reach."""
    return [p for p in pairs if p.first.shape == p.second.shape and farthest(p) <= reach]


def score(pair: Pair, points: Points, tracks: Tracks) -> Score:
    """Look up the tracks of these corners, at their nearest pixels."""
    columns, rows = np.rint(points).astype(np.intp).T
    kept: NDArray[np.bool_] = tracks.tracked[rows, columns]
    if pair.homography is None:
        return Score(len(points), int(kept.sum()), float("nan"))
    pixels = np.column_stack([columns, rows]).astype(np.float64)
    moved = pixels + np.column_stack([tracks.dx[rows, columns], tracks.dy[rows, columns]])
    errors = np.hypot(*(moved - project(pixels, pair.homography)).T)
    return Score(len(points), int(kept.sum()), float((kept & (errors <= TOLERANCE)).sum()))


def corners_of(pair: Pair, detectors: list[Detector], mode: Mode, cache: DetectionCache) -> dict[str, Points]:
    """By the detector's name, the corners of the first view that count.

    Their numbers are equal in a mode of equal numbers.
    """

    def ask(detector: Detector, ranked: bool) -> Points:
        return cache.corners(detector, pair.first, mode.thresholds, ranked)

    found = {detector.name: ask(detector, mode.equal) for detector in detectors}
    if not mode.equal:
        return found
    wanted = mode.wanted(pair.first)
    if mode.like:
        (like,) = (each for each in detectors if each.name == mode.like)
        wanted = len(ask(like, False))
    limit = min(wanted, *(len(points) for points in found.values()))
    return {name: points[:limit] for name, points in found.items()}


def summary(pairs: list[Pair], found: list[Score]) -> Figures:
    """rho as a mean over pairs, with its interval over scenes; the sums that Table 6 prints."""
    given, tracked = sum(each.given for each in found), sum(each.tracked for each in found)
    rights = [each.right / each.tracked if each.tracked else float("nan") for each in found]
    return {
        "rho": estimate(by_scene(pairs, [(each.rho,) for each in found]), mean),
        "given": given,
        "tracked": tracked,
        "right_of_tracked": estimate(by_scene(pairs, [(right,) for right in rights]), mean),
        "corners": round(given / len(found), 1) if found else None,
    }


def gain(pairs: list[Pair], ours: list[Score], base: list[Score]) -> Figures:
    """How much higher our rho is than the base's on the same pairs, relative to it."""
    both = [(one.rho, other.rho) for one, other in zip(ours, base, strict=True)]
    return estimate(by_scene(pairs, both), relative_gain)


def videos_of(pairs: list[Pair]) -> list[str]:
    """Names of the videos among the pairs."""
    return sorted({pair.name for pair in pairs if pair.homography is None})


def mode_figures(pairs: list[Pair], found: dict[str, list[Score]]) -> Figures:
    """One mode: each detector over all pairs, by class of scene and by video, and what it gains."""
    parts = parts_of(pairs)
    parts[VIDEO] = [pair.homography is None for pair in pairs]
    parts["rendered"] = [pair.homography is not None for pair in pairs]
    for video in videos_of(pairs):
        parts[video] = [pair.name == video and pair.homography is None for pair in pairs]
    return figures_of_parts(pairs, found, parts, summary, gain)


def robustness(
    pairs: list[Pair], detectors: list[Detector], tracked: TrackCache, *, notify: Notify | None = None
) -> Figures:
    """Every mode over all pairs that the tracker can reach across."""
    chosen, modes = trackable(pairs), modes_of(detectors)
    cache = DetectionCache()
    found: dict[str, dict[str, list[Score]]] = {
        mode.name: {detector.name: [] for detector in detectors} for mode in modes
    }
    for done, pair in enumerate(chosen, start=1):
        tracks = tracked.tracks(pair.first, pair.second)
        for mode in modes:
            for name, points in corners_of(pair, detectors, mode, cache).items():
                found[mode.name][name].append(score(pair, points, tracks))
        if notify:
            notify(done)
    return {
        "tracker": {
            "window": WINDOW,
            "reach": REACH,
            "least_correlation": LEAST_CORRELATION,
            "largest_return_error": LARGEST_RETURN_ERROR,
        },
        "pairs": len(chosen),
        "videos": videos_of(chosen),
        "left_out": len(pairs) - len(chosen),
        "modes": {mode.name: mode_figures(chosen, found[mode.name]) for mode in modes},
    }


def measure(material: Material) -> Figures:
    """Videos, rendered views and the user's pairs."""
    with material.progress("robustness", len(trackable(material.moving))) as advance:
        return robustness(material.moving, detectors(material.profiles), material.tracked, notify=advance)


def tables(found: Figures) -> dict[str, Table]:
    """``table_6`` beside the paper's if ``paper`` was measured, then each mode under its name."""
    made = {"table_6": _table_6(found["modes"], found["videos"])} if _has_paper(found) else {}
    return made | mode_tables(found["modes"], "rho")


def _has_paper(found: Figures) -> bool:
    return all("paper" in mode for mode in found["modes"].values())


def _table_6(modes: Figures, videos: list[str]) -> Table:
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
        *("", "video", f"Shi-Tomasi (ours: paper without filter, σ1 = {PAPER_LOW.sigma1})"),
        f"this work (ours: paper, {PAPER_LOW.name})",
        "as many of Shi-Tomasi's strongest",
        "as many points anywhere",
    ]
    return Table("The paper's Table 6: tracked / detected", headings, rows, names=2)


def _share(tracked: int, given: int) -> str:
    return f"{tracked:,} / {given:,} = {tracked / given:.2f}" if given else "none detected"


def plot(found: Figures) -> bytes:
    """A panel for each mode in which there are corners."""
    modes = {name: each for name, each in found["modes"].items() if any(map(some, each.values()))}
    lines = -(-len(modes) // 2)
    drawn = style.figure(2.6 * lines + 0.4)
    panels = drawn.subplots(lines, 2, sharex=True, sharey=True, squeeze=False)
    for axes, (mode, each) in zip(panels.flat, modes.items(), strict=False):
        draw_parts(axes, each, "rho")
        for value, line, name in zip(paper.MEAN_RHO, (":", "--"), ("Shi-Tomasi", "the paper"), strict=True):
            axes.axvline(value, color="black", linewidth=1, linestyle=line, label=f"Table 6: {name}")
        axes.set_title(mode, fontsize=10)
        axes.set_xlim(0, 1)
        axes.set_xticks([0, 0.2, 0.4, 0.6, 0.8, 1], ["0", "0.2", "0.4", "0.6", "0.8", "1"])
    for axes in list(panels.flat)[len(modes) :]:
        axes.set_visible(False)
    for axes in panels[-1]:
        axes.set_xlabel("rho = tracked / detected")
    style.key(drawn, panels[0, 0], columns=5)
    return style.plot_file(drawn)


def facts(found: Figures) -> dict[str, Any]:
    """How the pairs of frames are chosen."""
    return {
        "per_video": PAIRS_PER_VIDEO,
        "apart": FRAMES_APART,
        "modes": list(found["modes"]),
        "has_paper": _has_paper(found),
    }


SECTION = Section(
    name="robustness",
    title="Robustness, the paper's Table 6",
    measure=measure,
    tables=tables,
    plots={"robustness.png": plot},
    facts=facts,
    needs=frozenset({"views", "videos"}),
    options=frozenset({"profiles", "images", "pairs", "videos"}),
)
