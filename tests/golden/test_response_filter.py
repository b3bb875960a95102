"""S from D, by hand, and its purpose: one peak at a saddle."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from golden import Parameters, Settings, detect
from golden.algorithm import ResponseFilter
from golden.response_filter import response_filter


def test_one_response_spreads() -> None:
    frame = np.zeros((5, 5), np.int32)
    frame[2, 2] = 160
    assert response_filter(frame).tolist() == [[10, 20, 10], [20, 40, 20], [10, 20, 10]]


def test_rounds_to_nearest_halves_up() -> None:
    for value, rounded in ((0, 0), (7, 0), (8, 1), (23, 1), (24, 2)):
        frame = np.zeros((3, 3), np.int32)
        frame[0, 0] = value
        assert response_filter(frame).item() == rounded


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 65026, 2093058]))
def test_is_the_rounded_mean_by_loops_and_no_larger(seed: int, top: int) -> None:
    frame = np.random.default_rng(seed).integers(0, top, (3, 3), np.int32, endpoint=True)
    weights = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]])
    value = response_filter(frame).item()
    assert value == int(np.floor((weights * frame).sum() / 16 + 0.5))
    assert frame.min() <= value <= frame.max()
    full = np.full((3, 3), top, np.int32)
    assert response_filter(full).item() == top


def test_a_saddle_has_one_corner_and_two_without() -> None:
    """Two wedges of 75 degrees that touch, turned and between pixels, rendered 4 times as fine."""
    y, x = np.mgrid[: 31 * 4, : 31 * 4] / 4
    dx, dy = x - 15.9, y - 15.6
    first, second = (np.cos(angle) * dx + np.sin(angle) * dy < 0 for angle in (0.3, 0.3 + np.radians(75)))
    fine = np.where(first == second, 200.0, 40.0)
    image = np.round(fine.reshape(31, 4, 31, 4).mean(axis=(1, 3))).astype(np.uint8)
    kinds: tuple[ResponseFilter, ...] = ("none", "binomial")
    alone, smoothed = (
        detect(image, Parameters.profile("robust", response_filter=kind), Settings(sigma1=0.3, sigma2=0))
        for kind in kinds
    )
    assert (len(alone), len(smoothed)) == (2, 1)
