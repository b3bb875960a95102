"""Detectors, each with what places its corners: rounding, a fit of its own, OpenCV's refinement."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from evaluation.inputs.sources import Image
from evaluation.methods.detectors import (
    PLAIN,
    PLAIN_PARAMETERS,
    WITHOUT,
    Detector,
    Fast,
    GoodFeaturesToTrack,
    Ours,
    Points,
)
from evaluation.methods.localisation import OPENCV, corner_sub_pix
from evaluation.methods.spread import FastByGrid
from golden import Parameters
from golden.algorithm import Fit

Placing = Callable[[Image, Points], Points]

WHOLE = "whole pixels"
FITS: tuple[Fit, ...] = ("nine", "gradient")
"""Fits by which the corners of every profile are placed besides its own."""
APART = 10
"""Pixels between corners of ``goodFeaturesToTrack``, where they are to be apart."""


def _as_found(image: Image, points: Points) -> Points:
    return points


def _whole(image: Image, points: Points) -> Points:
    return np.rint(points)


def _refined(image: Image, points: Points) -> Points:
    return corner_sub_pix(image, np.rint(points).astype(np.int64))


class Entrant(NamedTuple):
    """A detector, and what places its corners."""

    name: str
    detector: Detector
    place: Placing = _as_found


def entrants(profiles: dict[str, Parameters]) -> list[Entrant]:
    """Ranking by D and each profile, placed by their own fit and by others; OpenCV's."""
    found: list[Entrant] = []
    known = {PLAIN_PARAMETERS, *profiles.values()}
    for name, parameters in {PLAIN: PLAIN_PARAMETERS, **profiles}.items():
        # the paper's filter takes away the strongest corners, and leaves too few
        filtered = parameters.algorithm.texture != "patches"
        own = name if filtered or name == PLAIN else name + WITHOUT
        detector = Ours(own, parameters, filtered=filtered)
        found += [Entrant(f"{own}, {WHOLE}", detector, _whole), Entrant(own, detector)]
        for fit in FITS:
            other = parameters.changed(fit=fit)
            if other not in known:
                known.add(other)
                found.append(Entrant(f"{own}, {fit}", Ours(f"{own}, {fit}", other, filtered=filtered)))
    for opencvs in (GoodFeaturesToTrack(), GoodFeaturesToTrack(APART)):
        refined = f"{opencvs.name}, {OPENCV}"
        found += [Entrant(opencvs.name, opencvs), Entrant(refined, opencvs, _refined)]
    return [*found, Entrant(Fast.name, Fast()), Entrant(FastByGrid.name, FastByGrid())]
