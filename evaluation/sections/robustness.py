"""Robustness as the paper defines it: rho = corners that a correlation tracker finds again /
corners given to it.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from evaluation.figures import Figures, Notify
from evaluation.inputs.sources import Pair
from evaluation.methods.bootstrap import estimate, mean, relative_gain
from evaluation.methods.detectors import MODES, DetectionCache, Detector, Mode, Points, budget
from evaluation.methods.tracker import LARGEST_RETURN_ERROR, LEAST_CORRELATION, REACH, WINDOW, Tracks, track
from evaluation.sections.repeatability import TOLERANCE, by_scene, figures_of_parts, parts_of, project

VIDEO = "video"
"""Name of all pairs whose homography nobody knows."""


class Score(NamedTuple):
    """One detector on one pair: corners given, corners tracked, and of these, where known, to the
    right place.
    """

    given: int
    tracked: int
    right: float

    @property
    def rho(self) -> float:
        """NaN without corners."""
        return self.tracked / self.given if self.given else float("nan")


def farthest(pair: Pair) -> float:
    """Largest distance that any point of the first view moves, along x or y; 0 where nobody knows."""
    if pair.homography is None:
        return 0.0
    height, width = pair.first.shape
    corners = np.array([(x, y) for x in (0.0, width - 1) for y in (0.0, height - 1)])
    return float(np.abs(project(corners, pair.homography) - corners).max())


def trackable(pairs: list[Pair], reach: int = REACH) -> list[Pair]:
    """The pairs of one size in which everything stays within the tracker's reach, as far as is
    known.
    """
    return [p for p in pairs if p.first.shape == p.second.shape and farthest(p) <= reach]


def score(pair: Pair, points: Points, tracks: Tracks) -> Score:
    """Look up what became of these corners, at their nearest pixels."""
    columns, rows = np.rint(points).astype(np.intp).T
    kept: NDArray[np.bool_] = tracks.tracked[rows, columns]
    if pair.homography is None:
        return Score(len(points), int(kept.sum()), float("nan"))
    pixels = np.column_stack([columns, rows]).astype(np.float64)
    moved = pixels + np.column_stack([tracks.dx[rows, columns], tracks.dy[rows, columns]])
    errors = np.hypot(*(moved - project(pixels, pair.homography)).T)
    return Score(len(points), int(kept.sum()), float((kept & (errors <= TOLERANCE)).sum()))


def corners_of(pair: Pair, detectors: list[Detector], mode: Mode, cache: DetectionCache) -> dict[str, Points]:
    """By the detector's name, the corners of the first view that count; of equal number if the mode
    says so.
    """

    def ask(detector: Detector, ranked: bool) -> Points:
        return cache.corners(detector, pair.first, mode.thresholds, ranked)

    found = {detector.name: ask(detector, mode.equal) for detector in detectors}
    if not mode.equal:
        return found
    wanted = budget(pair.first, mode.pixels_per_corner)
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


def robustness(pairs: list[Pair], detectors: list[Detector], *, notify: Notify | None = None) -> Figures:
    """Every mode over all pairs that the tracker can reach across."""
    chosen = trackable(pairs)
    cache = DetectionCache()
    found: dict[str, dict[str, list[Score]]] = {
        mode.name: {detector.name: [] for detector in detectors} for mode in MODES
    }
    for done, pair in enumerate(chosen, start=1):
        tracks = track(pair.first, pair.second)
        for mode in MODES:
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
        "modes": {mode.name: mode_figures(chosen, found[mode.name]) for mode in MODES},
    }
