"""The sums of the gradient steps: by hand, against their definition, and their bounds."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from golden.derivatives import Derivatives
from golden.normal_equations import (
    FARTHEST,
    LARGEST,
    PIXEL_SIZE,
    centre,
    largest,
    normal_equations,
    window_place,
)
from golden.parameters import Parameters
from golden.subpixel import derivative_bits

Y, X = np.mgrid[-7:8, -7:8]


def sums(pixels: NDArray[np.generic], x: int = 0, y: int = 0) -> Derivatives[int]:
    """Of one (15, 15) window of pixels."""
    found = normal_equations(pixels.astype(np.uint8)[None], np.array([x]), np.array([y]))
    return Derivatives(*(int(value[0]) for value in found))


def lone(x: int, y: int, value: int) -> NDArray[np.int64]:
    """A window of pixels, 0 but for one."""
    return np.where((x == X) & (y == Y), value, 0)


def test_sums_by_hand() -> None:
    """A lone pixel of 10: gx is -10 left and 10 right of it, gy above and below, never both."""
    xx, yy, xy, x, y = sums(lone(2, 1, 10))
    assert (xx, yy, xy) == (256 * 200, 256 * 200, 0)
    # gradients at u = 1 and 3, and at v = 0 and 2
    assert (x, y) == (256 * 100 * (1 + 3), 256 * 100 * (0 + 2))


def test_a_mixed_product_by_hand() -> None:
    """Both gradients are only at the place (-3, 3), with opposite signs: C = -6."""
    # left of it: gx = 2; below it: gy = -3
    xx, yy, xy, x, y = sums(lone(-4, 3, 2) + lone(-3, 4, 3))
    # the places (-5, 3) and (-3, 5) are outside; (-4, 2), (-4, 4), (-2, 4) and (-4, 3) are not
    corner = Derivatives(4, 9, 6, 4 * -3 + -6 * 3, -6 * -3 + 9 * 3)
    by_left = {(-4, 2): (0, -2), (-4, 4): (-3, 2)}
    by_below = {(-2, 4): (3, 0)}
    assert by_left[-4, 4] == (-3, 2) and by_below[-2, 4] == (3, 0)
    half, quarter = 128, 64
    assert xx == 256 * corner.xx + quarter * 9 + half * 9
    assert yy == 256 * corner.yy + half * 4 + quarter * 4
    assert xy == 256 * corner.xy + quarter * 6
    assert x == 256 * corner.x + quarter * (9 * -4 + -6 * 4) + half * (9 * -2)
    assert y == 256 * corner.y + half * (4 * 2) + quarter * (-6 * -4 + 4 * 4)


@pytest.mark.parametrize(("place", "first", "last"), [(0, 8, 8), (5, 3, 13), (-8, 16, 0), (7, 1, 15)])
def test_weights_of_the_outermost_gradients_by_hand(place: int, first: int, last: int) -> None:
    """gx is ±1 at the places x - 1 and x + 1 of a column of ones, and gy is 0."""
    assert int(centre(np.array(place))) == 0
    weight = {-5: 0, -4: first, **dict.fromkeys(range(-3, 4), 16), 4: last, 5: 0}
    for column in range(-4, 5):
        xx, yy, _, x, _ = sums((column == X) * 1, x=place)
        assert (xx, yy) == (128 * (weight[column - 1] + weight[column + 1]), 0)
        assert x == 128 * ((column - 1) * weight[column - 1] + (column + 1) * weight[column + 1])


def covered(place: int) -> dict[int, Fraction]:
    """What a box from place/16 - 4 to place/16 + 4 covers of the pixel around each whole number."""
    low, high = Fraction(place, 16) - 4, Fraction(place, 16) + 4
    half = Fraction(1, 2)
    return {k: max(min(k + half, high) - max(k - half, low), Fraction(0)) for k in range(-7, 8)}


@given(st.integers(0, 2**32 - 1), st.integers(-FARTHEST, FARTHEST), st.integers(-FARTHEST, FARTHEST))
def test_sums_equal_their_definition(seed: int, x_place: int, y_place: int) -> None:
    pixels = np.random.default_rng(seed).integers(0, 256, (PIXEL_SIZE, PIXEL_SIZE))
    across, down = covered(x_place), covered(y_place)
    assert sum(across.values()) == sum(down.values()) == 8
    x_middle, y_middle = (x_place + 8) // 16, (y_place + 8) // 16
    expected = [Fraction(0)] * 5
    for y in range(-6, 7):
        for x in range(-6, 7):
            gx = int(pixels[y + 7, x + 6] - pixels[y + 7, x + 8])
            gy = int(pixels[y + 6, x + 7] - pixels[y + 8, x + 7])
            a, b, c = gx * gx, gy * gy, gx * gy
            u, v = x - x_middle, y - y_middle
            for k, term in enumerate((a, b, -c, a * u + c * v, c * u + b * v)):
                expected[k] += 256 * across[x] * down[y] * term
    assert list(sums(pixels, x_place, y_place)) == expected


def test_places_by_hand() -> None:
    offsets = [0, 3, 4, 11, 12, -4, -5, -12, -13, 64, 308, 316, 500, -316, -500]
    places = [0, 0, 1, 1, 2, 0, -1, -1, -2, 8, 39, 39, 39, -39, -39]
    assert window_place(np.array(offsets)).tolist() == places
    assert centre(np.array([-39, -24, -25, -8, -9, 0, 7, 8, 23, 24, 39])).tolist() == [
        *(-2, -1, -2, 0, -1),
        *(0, 0, 1, 1, 2, 2),
    ]


@pytest.mark.parametrize("pixel_bits", range(4, 11))
def test_bound_of_the_sums(pixel_bits: int) -> None:
    """Stripes along both diagonals have gx = ±gy of full size where their contrast is largest."""
    parameters = Parameters.profile("robust", pixel_bits=pixel_bits, fit="gradient")
    assert LARGEST == 1 << 16 and largest(parameters) == LARGEST * parameters.product_max
    assert derivative_bits(parameters) == largest(parameters).bit_length()
    rng = np.random.default_rng(pixel_bits)
    pixels = (rng.integers(0, 2, (20_000, PIXEL_SIZE, PIXEL_SIZE)) * parameters.pixel_max).astype(np.uint16)
    x, y = rng.integers(-FARTHEST, FARTHEST, (2, 20_000), endpoint=True)
    assert max(int(np.abs(value).max()) for value in normal_equations(pixels, x, y)) <= largest(parameters)
