"""Spread of a figure: percentile bootstrap over images, which are what is drawn anew, with all their corners."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Statistic = Callable[[Values], float]

RESAMPLES = 1000
LEVEL = 0.95
SEED = 2017
DIGITS = 4
"""Decimals that are kept: more would be noise, and would fill the file."""


def interval(
    groups: Sequence[Values], statistic: Statistic, *, resamples: int = RESAMPLES, seed: int = SEED
) -> tuple[float, float]:
    """The central 95 % of a statistic over sets of images that are drawn with replacement.

    Parameters
    ----------
    groups
        For each image its values, (n, ...), n from 0 on: corners of one image are not independent, so an image
        comes whole or not at all.
    statistic
        Of the values of all images, concatenated; those of no value at all count as NaN and are left out.

    Returns
    -------
    Low and high end; NaN where there are no values.
    """
    groups = [np.asarray(group, dtype=np.float64) for group in groups]
    if not groups or not sum(map(len, groups)):
        return float("nan"), float("nan")
    random = np.random.default_rng(seed)
    flat = np.concatenate(groups)
    ends = np.cumsum([len(group) for group in groups])
    members = [np.arange(end - len(group), end) for group, end in zip(groups, ends, strict=True)]
    results = []
    for chosen in random.integers(len(groups), size=(resamples, len(groups))):
        drawn = np.concatenate([members[image] for image in chosen])
        if len(drawn):
            results.append(statistic(flat[drawn]))
    tail = 50 * (1 - LEVEL)
    low, high = np.nanpercentile(results, [tail, 100 - tail])
    return float(low), float(high)


def estimate(groups: Sequence[Values], statistic: Statistic, **options: Any) -> dict[str, Any]:
    """``value`` of a statistic and its ``interval`` [low, high], as JSON takes them: None where there is none."""
    groups = [np.asarray(group, dtype=np.float64) for group in groups]
    if not groups or not sum(map(len, groups)):
        return {"value": None, "interval": None}
    value = statistic(np.concatenate(groups))
    return {"value": plain(value), "interval": [plain(end) for end in interval(groups, statistic, **options)]}


def plain(value: float) -> float | None:
    """A number as JSON takes it."""
    return None if not np.isfinite(value) else round(float(value), DIGITS)


def mean(values: Values) -> float:
    return float(values.mean())


def median(values: Values) -> float:
    return float(np.median(values))


def percentile_95(values: Values) -> float:
    return float(np.percentile(values, 95))


def ratio(values: Values) -> float:
    """Sum of the first column over the sum of the second: NaN where that is 0."""
    whole = values[:, 1].sum()
    return float(values[:, 0].sum() / whole) if whole else float("nan")


def relative_gain(values: Values) -> float:
    """How much the mean of the first column is above the mean of the second, relative to that."""
    base = values[:, 1].mean()
    return float(values[:, 0].mean() / base - 1) if base else float("nan")
