"""Advice in one line: why there are few corners or none, and which option changes that."""

from __future__ import annotations

import numpy as np

from golden import Corners, Parameters, Settings
from golden.algorithm import DEFAULT_PROFILE


def advice(
    profile: str,
    parameters: Parameters,
    settings: Settings,
    corners: Corners,
    *,
    largest: int,
    reference: int,
    t1: int,
) -> str | None:
    """A line if there are no corners, or if the texture filter rejects most of them; else None.

    Parameters
    ----------
    profile, parameters, settings
        The detector that found the corners.
    corners
        The corners of one frame, with the rejected ones.
    largest, reference, t1
        The largest response of that frame where a corner can be; and the reference and the
        threshold T1 that it was compared with.
    """
    accepted = int(np.count_nonzero(corners.accepted))
    rejected = len(corners) - accepted
    if rejected > accepted:
        told = f"{profile}: the texture filter rejects {rejected} of {len(corners)} corners"
        if parameters.algorithm.texture == "mean":
            return f"{told}; try a smaller --sigma2"
        return f"{told}; {_try_the_default_or('a larger --sigma2', profile)}"
    if len(corners):
        return None
    if largest == 0:
        return (
            f"{profile}: no corners: the response is 0 everywhere: there are no edges, or only straight ones"
        )
    why = f"{profile}: no corners: the largest response is {largest}, and T1 is {t1}"
    if largest > t1:
        # such as between the squares of a drawn chessboard, which lies between four pixels
        strict = parameters.algorithm.ties == "strict"
        ties = "neither of two equal neighbouring responses is a corner"
        remedy = _try_the_default_or("--ties first", profile)
        return f"{why}; {f'{ties}; {remedy}' if strict else 'no peak of the response is above T1'}"
    if reference == settings.floor:
        return (
            f"{why}, since the reference is never below --floor, which is {reference}; try a smaller --floor"
        )
    if reference == settings.constant:
        return f"{why}, since the reference is --constant, which is {reference}; try a smaller --constant"
    return f"{why}; try a smaller --sigma1, which is {settings.sigma1:g}"


def _try_the_default_or(remedy: str, profile: str) -> str:
    if profile == DEFAULT_PROFILE:
        return f"try {remedy}"
    return f"try --profile {DEFAULT_PROFILE}, or {remedy}"
