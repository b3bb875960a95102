"""The smoothing kernel of Eq. 1 and its rounding, by hand and against a direct correlation."""

from __future__ import annotations

from decimal import ROUND_HALF_UP, Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from golden.convolution import KERNEL, SHIFT, smooth

EQUATION_1 = [
    [8, 16, 16, 16, 8],
    [16, 32, 32, 32, 16],
    [16, 32, 32, 32, 16],
    [16, 32, 32, 32, 16],
    [8, 16, 16, 16, 8],
]
"""Times 512, as printed, except for the single 19 that stands for 16."""


def half_away_from_zero(sixty_fourths: int) -> int:
    # Decimal's ROUND_HALF_UP looks at the magnitude: -0.5 becomes -1
    return int((Decimal(int(sixty_fourths)) / 64).quantize(Decimal(1), ROUND_HALF_UP))


def smooth_directly(image: NDArray[np.int64]) -> NDArray[np.int64]:
    height, width = image.shape
    total = np.zeros((height - 4, width - 4), dtype=np.int64)
    for v in range(5):
        for u in range(5):
            total += EQUATION_1[v][u] // 8 * image[v : v + height - 4, u : u + width - 4]
    return np.vectorize(half_away_from_zero)(total)


def test_kernel_is_equation_1() -> None:
    assert (8 * KERNEL).tolist() == EQUATION_1
    assert KERNEL.sum() == 1 << SHIFT
    assert (KERNEL == KERNEL.T).all() and (KERNEL == KERNEL[::-1]).all()


@pytest.mark.parametrize("sign", [1, -1])
def test_impulse_returns_the_kernel(sign: int) -> None:
    image = np.zeros((9, 9), np.int32)
    image[4, 4] = 64 * sign
    expected = [[1, 2, 2, 2, 1], [2, 4, 4, 4, 2], [2, 4, 4, 4, 2], [2, 4, 4, 4, 2], [1, 2, 2, 2, 1]]
    assert (smooth(image) * sign).tolist() == expected


@pytest.mark.parametrize("value", [0, 1, 17, 65025, 1046529, -1, -65025, -1046529])
def test_constant_stays(value: int) -> None:
    result = smooth(np.full((6, 8), value, np.int32))
    assert result.shape == (2, 4)
    assert (result == value).all()


@pytest.mark.parametrize(
    ("total", "rounded"),
    [(31, 0), (32, 1), (33, 1), (95, 1), (96, 2), (-31, 0), (-32, -1), (-33, -1), (-95, -1), (-96, -2)],
)
def test_half_rounds_away_from_zero(total: int, rounded: int) -> None:
    image = np.zeros((5, 5), np.int32)
    image[0, 0] = total
    assert smooth(image).tolist() == [[rounded]]


def test_rounding_of_every_sum_of_either_sign() -> None:
    totals = np.arange(-1000, 1001)
    image = np.zeros((5, 5 * len(totals)), np.int32)
    image[0, ::5] = totals
    assert smooth(image)[0, ::5].tolist() == [half_away_from_zero(int(total)) for total in totals]


@given(
    st.integers(5, 12), st.integers(5, 12), st.integers(0, 2**32 - 1), st.sampled_from([40, 65025, 1046529])
)
def test_equals_direct_correlation(height: int, width: int, seed: int, top: int) -> None:
    image = np.random.default_rng(seed).integers(-top, top + 1, (height, width), dtype=np.int32)
    assert (smooth(image) == smooth_directly(image)).all()
    assert (smooth(abs(image)) == smooth_directly(abs(image))).all()
    assert (smooth(-image) == -smooth(image)).all()
