"""Thresholds of one frame: sigma1 and sigma2 times the reference response, or what a target asks
for.
"""

from __future__ import annotations

from typing import NamedTuple

from golden.formats import SIGMA_BITS
from golden.parameters import Parameters
from golden.settings import Settings


class Thresholds(NamedTuple):
    """T1 in units of D; T2 in units of tau, that is times ``Parameters.pixels_per_region``.

    With ``texture="mean"`` T2 is no threshold but ``Settings.mean_weight``.
    """

    t1: int
    t2: int


def choose_reference(settings: Settings, previous_maximum: int | None, adapted: int | None = None) -> int:
    """Dref: the previous frame's largest D, or the constant (also after reset); never below the
    floor.

    With a rank and without a target it is ``adapted``; None: no frame before has been counted.
    """
    if settings.reference == "constant" or previous_maximum is None:
        return max(settings.constant, settings.floor)
    if settings.by_rank and adapted is not None:
        return max(adapted, settings.floor)
    return max(previous_maximum, settings.floor)


def thresholds(
    settings: Settings, reference: int, parameters: Parameters, adapted: int | None = None
) -> Thresholds:
    """T1 = sigma1 · Dref and T2 = sigma2 · Dref, rounded down.

    With a target T1 is ``adapted`` instead, but no less than sigma1 · floor; None: no frame before
    has been counted.
    """
    t1 = (settings.sigma1_fixed * reference) >> SIGMA_BITS
    t2 = (settings.sigma2_fixed * reference * parameters.pixels_per_region) >> SIGMA_BITS
    if parameters.algorithm.texture == "mean":
        t2 = settings.mean_weight
    if settings.target_corners and adapted is not None:
        t1 = max((settings.sigma1_fixed * settings.floor) >> SIGMA_BITS, adapted)
    return Thresholds(t1, t2)
