"""tau of 9x9 windows made by hand, for both readings of Fig. 5."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from golden.algorithm import Patches
from golden.parameters import Parameters
from golden.texture_filter import patch, texture_filter, texturization


def single(y: int, x: int, value: int = 7) -> NDArray[np.int32]:
    window = np.zeros((9, 9), np.int32)
    window[y, x] = value
    return window


def tau(window: NDArray[np.int32], patches: Patches) -> int:
    return int(texturization(window, patches))


def tau_by_loops(window: NDArray[np.int32], patches: Patches) -> int:
    total = 0
    reach = (-1, 0, 1) if patches == "regions" else (0,)
    for a, b in ((1, 2), (2, 3)):
        for down in (-1, 1):
            for right in (-1, 1):
                for v in reach:
                    for u in reach:
                        one = int(window[4 + a * down + v, 4 + a * right + u])
                        other = int(window[4 + b * down + v, 4 + b * right + u])
                        total += abs(one - other)
    return total


def test_patches_of_the_figure() -> None:
    window = np.arange(81).reshape(9, 9)
    assert patch(window, 1, "pixels").reshape(-1).tolist() == [30, 32, 48, 50]
    assert patch(window, 3, "pixels").reshape(-1).tolist() == [10, 16, 64, 70]
    regions = patch(window, 3, "regions")
    assert regions.shape == (4, 3, 3)
    # the corners of the 9x9 square
    assert regions[0].tolist() == [[0, 1, 2], [9, 10, 11], [18, 19, 20]]
    assert regions[3, 2, 2] == 80
    # the 5x5 square: its four corner regions overlap in the middle
    assert patch(window, 1, "regions")[:, [0, 2], [0, 2]].tolist() == [[20, 40], [22, 42], [38, 58], [40, 60]]


@pytest.mark.parametrize(
    ("y", "x", "regions", "pixels"),
    [
        # how often the value of one pixel counts, worked out on paper
        (4, 4, 4, 0),  # in all four regions of patch 1, in none of patches 2 and 3
        (4, 3, 2, 0),  # in the two left regions of patch 1
        (3, 3, 3, 1),  # upper left: middle of patch 1 (1), first of patch 2 (2)
        (2, 2, 4, 2),  # patches 1 (1), 2 (2) and 3 (1)
        (1, 1, 3, 1),  # patch 3's middle (1), patch 2's first (2)
        (0, 0, 1, 0),  # patch 3's first
        (0, 4, 0, 0),  # between the regions of patch 3
        (4, 0, 0, 0),
        (7, 7, 3, 1),
        (6, 2, 4, 2),
    ],
)
def test_single_pixel(y: int, x: int, regions: int, pixels: int) -> None:
    assert tau(single(y, x), "regions") == 7 * regions
    assert tau(single(y, x), "pixels") == 7 * pixels


@pytest.mark.parametrize("patches", ["regions", "pixels"])
def test_flat_window_has_no_texture(patches: Patches) -> None:
    assert tau(np.full((9, 9), 130050, np.int32), patches) == 0


def test_ramp() -> None:
    ramp = np.tile(np.arange(9), (9, 1))
    # from patch to patch every pixel lies one step further out: 4 regions, 2 differences of 1 per
    # pixel
    assert tau(ramp, "pixels") == 8
    assert tau(ramp, "regions") == 72
    assert tau(10 * ramp.T, "regions") == 720


@pytest.mark.parametrize("patches", ["regions", "pixels"])
@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
def test_largest_tau_is_what_the_parameters_say(patches: Patches, pixel_bits: int) -> None:
    parameters = Parameters.profile("paper", pixel_bits=pixel_bits, patches=patches)
    stripes = np.zeros((9, 9), np.int32)
    stripes[::2] = parameters.response_max  # one step along a diagonal is one row: always the other stripe
    assert tau(stripes, patches) == parameters.texture_max


def test_threshold_is_strict() -> None:
    window = single(4, 4)  # tau = 28
    assert not texture_filter(window, 28, "regions")
    assert texture_filter(window, 29, "regions")
    assert not texture_filter(np.zeros((9, 9), np.int32), 0, "regions")


@given(st.integers(0, 2**32 - 1), st.sampled_from([3, 130050, 2093058]))
def test_equals_explicit_loops(seed: int, top: int) -> None:
    windows = np.random.default_rng(seed).integers(0, top + 1, (3, 9, 9), dtype=np.int32)
    for patches in ("regions", "pixels"):
        expected = [tau_by_loops(window, patches) for window in windows]
        assert texturization(windows, patches).tolist() == expected
