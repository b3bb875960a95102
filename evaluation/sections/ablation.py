"""What each step of profile ``robust`` towards stable corners is worth, at equal numbers of
corners.

From ranking by D upwards one thing changes at a time: the paper's texture filter, Sobel gradients,
with the response filter, with the adaptive threshold. All are placed by the gradient step, so
differences are those of the choice.
"""

from __future__ import annotations

from evaluation.figures import Figures, Notify
from evaluation.inputs import views
from evaluation.inputs.sources import Pair
from evaluation.methods.detectors import MODES, PLAIN, PLAIN_PARAMETERS, DetectionCache, Detector, Ours
from evaluation.methods.tracker import track
from evaluation.sections import repeatability, robustness

PAPER_FILTER = "paper's filter"
SOBEL = "Sobel gradients"
SMOOTHED = "and response filter"
ADAPTIVE = "and adaptive threshold"


def steps() -> list[Detector]:
    """Ranking by D, the paper's filter in its place, and the profile's own steps, each with those
    before it.
    """
    sobel = PLAIN_PARAMETERS.changed(derivative="sobel")
    smoothed = sobel.changed(response_filter="binomial")
    return [
        Ours(PLAIN, PLAIN_PARAMETERS, filtered=False),
        Ours(PAPER_FILTER, PLAIN_PARAMETERS),
        Ours(SOBEL, sobel, filtered=False),
        Ours(SMOOTHED, smoothed, filtered=False),
        Ours(ADAPTIVE, smoothed.changed(texture="mean")),
    ]


VIEWS = ("shift", "larger, brighter", "noisy")
"""Of a photograph: enough to tell steps apart, and a minute's work less."""


def chosen(pairs: list[Pair]) -> list[Pair]:
    """Of rendered pairs, those of :data:`VIEWS`; all others."""
    rendered = {view.name for view in views.VIEWS}
    return [pair for pair in pairs if pair.name in VIEWS or pair.name not in rendered]


def texture(pairs: list[Pair], *, notify: Notify | None = None) -> Figures:
    """Repeatability and rho of each step, and what it gains over ranking by D, by class of scene.

    Repeatability over the pairs with a homography, rho over those in the tracker's reach. On each
    pair all steps have the same number of corners: no more than the one that finds fewest.
    """
    detectors, mode, cache = steps(), MODES[0], DetectionCache()
    warped = [pair for pair in pairs if pair.homography is not None]
    found = repeatability.scores(warped, detectors, mode, cache)
    tracked: dict[str, list[robustness.Score]] = {detector.name: [] for detector in detectors}
    near = robustness.trackable(pairs)
    for done, pair in enumerate(near, start=1):
        tracks = track(pair.first, pair.second)
        for name, points in robustness.corners_of(pair, detectors, mode, cache).items():
            tracked[name].append(robustness.score(pair, points, tracks))
        if notify:
            notify(done)
    return {
        "pairs": len(warped),
        "tracked_pairs": len(near),
        "scenes": sorted({pair.scene for pair in pairs}),
        "steps": {
            detector.name: {
                "repeatability": _repeatability(warped, found[detector.name], found[PLAIN]),
                "rho": _rho(near, tracked[detector.name], tracked[PLAIN]),
            }
            for detector in detectors
        },
    }


def _repeatability(
    pairs: list[Pair], found: list[repeatability.Score], base: list[repeatability.Score]
) -> Figures:
    take = repeatability.take
    return {
        part: repeatability.summary(take(pairs, chosen), take(found, chosen))
        | {"gain": repeatability.gain(take(pairs, chosen), take(found, chosen), take(base, chosen))}
        for part, chosen in repeatability.parts_of(pairs).items()
    }


def _rho(pairs: list[Pair], found: list[robustness.Score], base: list[robustness.Score]) -> Figures:
    take = repeatability.take
    return {
        part: robustness.summary(take(pairs, chosen), take(found, chosen))
        | {"gain": robustness.gain(take(pairs, chosen), take(found, chosen), take(base, chosen))}
        for part, chosen in repeatability.parts_of(pairs).items()
    }
