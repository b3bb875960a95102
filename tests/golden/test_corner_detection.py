"""Non-maximum suppression and threshold on 5x5 maps made by hand, of which 3x3 can be corners."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays
from numpy.typing import NDArray

from golden.algorithm import Ties
from golden.corner_detection import corner_detection

NEIGHBOURS = [(v, u) for v, u in product((-1, 0, 1), repeat=2) if (v, u) != (0, 0)]
EARLIER = [(-1, -1), (-1, 0), (-1, 1), (0, -1)]
"""Neighbours that come first in raster order."""


def corners(peaks: dict[tuple[int, int], int], ties: Ties, t1: int = 0) -> list[tuple[int, int]]:
    """(y, x) of the corners in a 5x5 map of zeros with these peaks."""
    responses = np.zeros((5, 5), np.int32)
    for place, value in peaks.items():
        responses[place] = value
    return [(int(y) + 1, int(x) + 1) for y, x in np.argwhere(corner_detection(responses, t1, ties))]


@pytest.mark.parametrize("ties", ["strict", "first"])
def test_single_peak_and_threshold(ties: Ties) -> None:
    assert corners({(2, 2): 9}, ties) == [(2, 2)]
    assert corners({(2, 2): 9}, ties, t1=8) == [(2, 2)]
    assert corners({(2, 2): 9}, ties, t1=9) == []
    assert corners({(1, 3): 9}, ties) == [(1, 3)]


@pytest.mark.parametrize("ties", ["strict", "first"])
def test_outermost_responses_are_neighbours_only(ties: Ties) -> None:
    assert corners({(0, 0): 9, (4, 2): 9}, ties) == []
    assert corners({(0, 0): 10, (1, 1): 9}, ties) == []
    assert corners({(0, 0): 8, (1, 1): 9}, ties) == [(1, 1)]


@pytest.mark.parametrize("ties", ["strict", "first"])
@pytest.mark.parametrize(("v", "u"), NEIGHBOURS)
def test_each_larger_neighbour_suppresses(v: int, u: int, ties: Ties) -> None:
    assert corners({(2, 2): 9, (2 + v, 2 + u): 10}, ties) == [(2 + v, 2 + u)]


@pytest.mark.parametrize(("v", "u"), NEIGHBOURS)
def test_equal_neighbours(v: int, u: int) -> None:
    pair = {(2, 2): 9, (2 + v, 2 + u): 9}
    assert corners(pair, "strict") == []
    assert corners(pair, "first") == [(2 + v, 2 + u) if (v, u) in EARLIER else (2, 2)]


def test_runs_of_equal_responses() -> None:
    row = {(2, 1): 9, (2, 2): 9, (2, 3): 9}
    assert corners(row, "strict") == []
    assert corners(row, "first") == [(2, 1)]
    # (1, 3) and (2, 1) do not touch; (2, 2) touches both and comes after both
    assert corners({(1, 3): 9, (2, 2): 9, (2, 1): 9}, "first") == [(1, 3), (2, 1)]
    assert corners({(1, 1): 9, (1, 3): 9}, "strict") == [(1, 1), (1, 3)]


@pytest.mark.parametrize("ties", ["strict", "first"])
def test_plateau_that_begins_at_the_edge_has_no_corner(ties: Ties) -> None:
    assert not corner_detection(np.full((5, 5), 7, np.int32), 0, ties).any()


@given(
    arrays(np.int32, array_shapes(min_dims=2, max_dims=2, min_side=3, max_side=9), elements=st.integers(0, 4))
)
def test_equals_the_definition(responses: NDArray[np.int32]) -> None:
    height, width = responses.shape
    for ties, t1 in product(("strict", "first"), (0, 2)):
        expected = np.zeros((height - 2, width - 2), bool)
        for y, x in product(range(1, height - 1), range(1, width - 1)):
            value = responses[y, x]
            beaten = all(
                value > responses[y + v, x + u]
                or (ties == "first" and (v, u) not in EARLIER and value == responses[y + v, x + u])
                for v, u in NEIGHBOURS
            )
            expected[y - 1, x - 1] = beaten and value > t1
        assert (corner_detection(responses, t1, ties) == expected).all()


def check_by_definition(responses: NDArray[np.int32], ties: Ties, radius: int, t1: int) -> int:
    """Every neighbour is compared; two corners are never nearer than the radius plus one. Returns
    the number of corners.
    """
    found = corner_detection(responses, t1, ties, radius)
    height, width = responses.shape
    assert found.shape == (height - 2 * radius, width - 2 * radius)
    for y, x in np.ndindex(found.shape):
        square = responses[y : y + 2 * radius + 1, x : x + 2 * radius + 1].ravel().tolist()
        middle = len(square) // 2
        centre, before, after = square[middle], square[:middle], square[middle + 1 :]
        beats_later = centre > max(after) if ties == "strict" else centre >= max(after)
        assert found[y, x] == (centre > max(before) and beats_later and centre > t1)
    places = np.argwhere(found)
    apart = np.abs(places[:, None] - places).max(axis=-1) + 99 * np.eye(len(places), dtype=int)
    assert (apart > radius).all()
    return len(places)


@given(
    arrays(
        np.int32, array_shapes(min_dims=2, max_dims=2, min_side=9, max_side=14), elements=st.integers(0, 6)
    ),
    st.sampled_from(["strict", "first"]),
    st.integers(1, 4),
    st.integers(0, 5),
)
def test_any_radius_by_definition(responses: NDArray[np.int32], ties: Ties, radius: int, t1: int) -> None:
    check_by_definition(responses, ties, radius, t1)


@pytest.mark.parametrize("ties", ["strict", "first"])
@pytest.mark.parametrize("radius", [1, 2, 3, 4])
def test_noise_by_definition(ties: Ties, radius: int) -> None:
    responses = np.random.default_rng(radius).integers(0, 200, (40, 40), dtype=np.int32)
    assert check_by_definition(responses, ties, radius, 20) > 5
