"""Spread of a figure: percentile bootstrap over images, each drawn with all its corners."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Statistic = Callable[[Values], Values]
"""Maps values (..., n, columns) to one figure for each of the leading axes: (...); NaN for none."""

RESAMPLES = 1000
LEVEL = 0.95
SEED = 2017
DIGITS = 4
"""Decimals that are stored: more would be noise, and would fill the file."""


def interval(
    groups: Sequence[Values], statistic: Statistic, *, resamples: int | None = None, seed: int = SEED
) -> tuple[float, float]:
    """The central 95 % of a statistic over sets of images that are drawn with replacement.

    Parameters
    ----------
    groups
        For each image its values, (n,) or (n, columns), n from 0 on: corners of one image are not
        independent, so an image comes whole or not at all.
    statistic
        Computed from the values of all images.
    resamples
        By default :data:`RESAMPLES`.

    Returns
    -------
    Low and high end; NaN where fewer than two images have values: one has no spread.
    """
    groups = _columns(groups)
    if sum(len(group) > 0 for group in groups) < 2:
        return float("nan"), float("nan")
    random = np.random.default_rng(seed)
    draws = random.integers(len(groups), size=(resamples or RESAMPLES, len(groups)))
    if len({len(group) for group in groups}) == 1:
        # all of one size, which is usual: all draws at once
        stacked = np.stack(groups)
        results = statistic(stacked[draws].reshape(len(draws), -1, stacked.shape[-1]))
    else:
        drawn = (np.concatenate([groups[image] for image in chosen]) for chosen in draws)
        results = np.array([statistic(values) for values in drawn if len(values)])
    known = results[np.isfinite(results)]
    if not len(known):
        return float("nan"), float("nan")
    tail = 50 * (1 - LEVEL)
    low, high = np.percentile(known, [tail, 100 - tail])
    return float(low), float(high)


def _columns(groups: Sequence[Values]) -> list[Values]:
    arrays = [np.asarray(group, dtype=np.float64) for group in groups]
    return [array[:, None] if array.ndim == 1 else array for array in arrays]


def estimate(groups: Sequence[Values], statistic: Statistic, **options: Any) -> dict[str, Any]:
    """``value`` of a statistic and its ``interval`` [low, high] for JSON: None instead of NaN."""
    groups = _columns(groups)
    if not groups or not sum(map(len, groups)):
        return {"value": None, "interval": None}
    value = plain(float(statistic(np.concatenate(groups))))
    if value is None:
        return {"value": None, "interval": None}
    low, high = (plain(end) for end in interval(groups, statistic, **options))
    return {"value": value, "interval": None if low is None or high is None else [low, high]}


def plain(value: float) -> float | None:
    """A number as JSON takes it."""
    return None if not np.isfinite(value) else round(float(value), DIGITS)


def mean(values: Values) -> Values:
    """Mean of the first column; the two below use this column, too."""
    return np.asarray(values[..., 0].mean(axis=-1))


def median(values: Values) -> Values:
    """Median of the first column."""
    return np.asarray(np.median(values[..., 0], axis=-1))


def percentile_95(values: Values) -> Values:
    """95th percentile of the first column."""
    return np.asarray(np.percentile(values[..., 0], 95, axis=-1))


def relative_gain(values: Values) -> Values:
    """How much the mean of the first column is above that of the second, relative to the second."""
    ours, base = np.moveaxis(values.mean(axis=-2), -1, 0)
    return np.where(base > 0, ours / np.where(base > 0, base, 1) - 1, np.nan)
