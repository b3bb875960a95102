"""Intervals, on distributions whose intervals are known."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.methods.bootstrap import estimate, interval, mean, median, percentile_95, plain, relative_gain


def groups(values: np.ndarray) -> list[np.ndarray]:
    return list(values.reshape(len(values), -1))


def test_interval_of_a_mean_is_that_of_the_normal_distribution() -> None:
    values = np.random.default_rng(1).normal(5, 2, 400)
    low, high = interval(groups(values), mean, resamples=1000)
    error = 1.96 * values.std() / np.sqrt(len(values))
    assert low == pytest.approx(values.mean() - error, abs=0.15 * error)
    assert high == pytest.approx(values.mean() + error, abs=0.15 * error)


def test_interval_covers_the_truth_as_often_as_it_says() -> None:
    random = np.random.default_rng(2)
    covered = 0
    for _ in range(200):
        low, high = interval(groups(random.normal(0, 1, 60)), mean, resamples=200)
        covered += low <= 0 <= high
    assert 178 <= covered <= 198, "of 200 about 190 should"


def test_corners_of_one_image_do_not_count_as_many_images() -> None:
    values = np.random.default_rng(3).normal(0, 1, 25)
    alone = interval(groups(values), mean, resamples=1000)
    many = interval([np.full(40, value) for value in values], mean, resamples=1000)
    assert many == pytest.approx(alone), "40 equal corners in each image say no more than one"
    split = interval(groups(np.repeat(values, 40)), mean, resamples=1000)
    assert split[1] - split[0] < 0.3 * (many[1] - many[0])


def test_same_seed_same_interval() -> None:
    values = groups(np.random.default_rng(4).normal(0, 1, 30))
    assert (
        interval(values, mean, resamples=100)
        == interval(values, mean, resamples=100)
        != interval(values, mean, resamples=100, seed=1)
    )


def test_images_without_corners() -> None:
    empty = np.empty(0)
    assert estimate([], mean) == estimate([empty, empty], mean) == {"value": None, "interval": None}
    some = estimate([empty, np.array([1.0, 2.0]), np.array([3.0])], mean)
    assert some["value"] == 2 and some["interval"][0] >= 1 and some["interval"][1] <= 3


def test_one_image_has_no_spread() -> None:
    alone = estimate([np.array([1.0, 2.0, 6.0]), np.empty(0)], mean)
    assert alone == {"value": 3, "interval": None}


def test_statistics() -> None:
    values = np.arange(101.0)[:, None]
    assert (mean(values), median(values), percentile_95(values)) == (50, 50, 95)
    assert median(np.stack([values, values + 1])).tolist() == [50, 51], "for each of the leading axes"
    assert relative_gain(np.array([[1.1, 1.0], [1.1, 1.0]])) == pytest.approx(0.1)
    assert np.isnan(relative_gain(np.array([[1.0, 0.0]])))
    assert plain(float("nan")) is None and plain(1 / 3) == 0.3333
