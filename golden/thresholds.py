"""Thresholds of one frame: sigma1 and sigma2 times the reference, or those of a target."""

from __future__ import annotations

from typing import NamedTuple

from golden.formats import SIGMA_BITS
from golden.parameters import Parameters
from golden.settings import Settings


class Thresholds(NamedTuple):
    """What the responses and the texture measures of a frame are compared with."""

    t1: int
    """In units of D."""
    t2: int
    """In units of tau, which is scaled by ``Parameters.pixels_per_region``. With
    ``texture="mean"``, it is not a threshold but ``Settings.mean_weight``; with ``"none"``, nothing
    is compared with it.
    """


def choose_reference(settings: Settings, previous_maximum: int | None, adapted: int | None = None) -> int:
    """Dref: the previous frame's largest D, or the constant; never below the floor.

    Parameters
    ----------
    previous_maximum
        None after reset; Dref is then the constant.
    adapted
        Dref where the settings have a rank and no target; None: no frame has been counted yet.
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

    Parameters
    ----------
    adapted
        T1 where the settings have a target, but no less than sigma1 · floor; None: no frame has
        been counted yet.
    """
    t1 = (settings.sigma1_fixed * reference) >> SIGMA_BITS
    t2 = (settings.sigma2_fixed * reference * parameters.pixels_per_region) >> SIGMA_BITS
    if parameters.algorithm.texture == "mean":
        t2 = settings.mean_weight
    if settings.target_corners and adapted is not None:
        t1 = max((settings.sigma1_fixed * settings.floor) >> SIGMA_BITS, adapted)
    return Thresholds(t1, t2)
