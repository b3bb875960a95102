"""Quadratic fits of exact surfaces, and their peaks."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from golden.divider import worst_error
from golden.parameters import Fit
from golden.subpixel import Surface, fit_nine, fit_printed, fit_six, peak, subpixel

Y, X = np.mgrid[-1:2, -1:2]
SIX = [0, 3, 5, 7, 2, 6]
WORST = worst_error()


def samples(l0: int, l1: int, l2: int, l3: int, l4: int, l5: int) -> NDArray[np.int64]:
    return l0 * X * X + l1 * Y * Y + l2 * X * Y + l3 * X + l4 * Y + l5


def design(x: NDArray[np.int64], y: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack([x * x, y * y, x * y, x, y, np.ones_like(x)], axis=1)


def applied_to_units(fit: Fit) -> NDArray[np.int64]:
    """The fit as a matrix: column k is what a lone 1 at sample k gives."""
    fits = {"nine": fit_nine, "six": fit_six, "printed": fit_printed}
    return np.array(fits[fit](np.eye(9, dtype=np.int32).reshape(9, 3, 3)))


def surface(*coefficients: int) -> Surface:
    return Surface(*(np.array([value], dtype=np.int64) for value in coefficients))


def outcome(s: Surface, printed: bool = False) -> tuple[int, int, bool, bool]:
    offset = peak(s, printed=printed)
    return int(offset.dx[0]), int(offset.dy[0]), bool(offset.clamped[0]), bool(offset.not_maximum[0])


PEAK_AT_03_02 = (-1000, -1500, 200, 640, -660, 5000)
"""f has its maximum at (0.3, -0.2): -2000·0.3 + 200·(-0.2) + 640 = 0 and -3000·(-0.2) + 200·0.3 - 660 = 0."""


@pytest.mark.parametrize(("fit", "scale"), [(fit_nine, 12), (fit_six, 2)])
def test_fit_recovers_the_coefficients_of_a_paraboloid(fit, scale: int) -> None:
    fitted = fit(samples(*PEAK_AT_03_02))
    assert [int(value) for value in fitted] == [scale * value for value in PEAK_AT_03_02[:5]]


@pytest.mark.parametrize("fit", ["nine", "six"])
def test_fit_recovers_the_peak_of_a_paraboloid(fit: Fit) -> None:
    offset = subpixel(samples(*PEAK_AT_03_02)[None], fit)
    assert abs(offset.dx[0] / 128 - 0.3) <= WORST
    assert abs(offset.dy[0] / 128 + 0.2) <= WORST
    assert not offset.clamped[0] and not offset.not_maximum[0]


def test_printed_formulas_do_not_recover_it() -> None:
    """f = 10 - (x - 0.3)² - (y + 0.2)², times 100: Eqs. 11 and 12 move its peak to (0.04, -0.54)."""
    patch = samples(-100, -100, 0, 60, -40, 1000 - 9 - 4)
    l0, l1, l2, l3, l4 = (int(value) for value in fit_printed(patch))
    denominator = l2 * l2 - 4 * l0 * l1
    assert round((2 * l1 * l3 - l2 * l4) / denominator, 2) == 0.04
    assert round((2 * l0 * l4 - l2 * l3) / denominator, 2) == -0.54
    # with the misprint of Eq. 13 too
    assert round((2 * l1 * l2 - l2 * l4) / denominator, 2) == -0.34
    offset = subpixel(patch[None], "printed")
    assert abs(offset.dx[0] / 128 + 0.34) < 0.01
    assert (offset.dy[0], offset.clamped[0], offset.not_maximum[0]) == (-64, True, False)


def test_six_is_the_inverse_of_the_true_design_matrix() -> None:
    matrix = design(X.reshape(9)[SIX], Y.reshape(9)[SIX])
    assert round(np.linalg.det(matrix)) == -8
    inverse = applied_to_units("six")[:, SIX]
    assert (inverse @ matrix == 2 * np.eye(6)[:5]).all()
    assert not applied_to_units("six")[:, [1, 4, 8]].any()


def test_nine_is_the_least_squares_solution() -> None:
    matrix = design(X.reshape(9), Y.reshape(9))
    assert np.allclose(applied_to_units("nine"), 12 * np.linalg.pinv(matrix)[:5], atol=1e-9)
    assert (applied_to_units("nine") @ matrix == 12 * np.eye(6)[:5]).all()


def test_printed_is_the_product_of_the_papers_matrices() -> None:
    vx = np.array(
        [
            [-1, 1, -1, 1, -1, 1],
            [-1, 1, -1, 1, -1, 1],
            [1, 1, 1, 1, 1, 1],
            [0, 0, 0, 0, 0, 1],
            [1, 1, 1, 1, 1, 1],
            [-1, 1, -1, 1, -1, 1],
        ]
    )
    vy = np.array(
        [
            [-1, 1, -1, 1, -1, 1],
            [0, 0, 0, 0, 0, 1],
            [0, 0, 0, 0, 0, 1],
            [1, 1, 1, 1, 1, 1],
            [-1, 1, -1, 1, -1, 1],
            [1, 1, 1, 1, 1, 1],
        ]
    )
    product = vx @ vy
    assert np.linalg.matrix_rank(product) == 3
    assert (applied_to_units("printed")[:, SIX] == product[:5]).all()


@pytest.mark.parametrize("fit", ["nine", "six"])
def test_height_does_not_matter(fit: Fit) -> None:
    low, high = samples(-100, -70, 20, 31, -17, 0), samples(-100, -70, 20, 31, -17, 2000000)
    assert subpixel(low[None], fit).dx == subpixel(high[None], fit).dx
    assert subpixel(low[None], fit).dy == subpixel(high[None], fit).dy


@pytest.mark.parametrize(
    ("coefficients", "expected"),
    [
        # dx = L3/(2|L0|), dy = L4/(2|L1|) where L2 = 0
        ((-64, -64, 0, 32, -32), (32, -32, False, False)),
        ((-64, -64, 0, 64, -64), (64, -64, False, False)),  # exactly half a pixel is still inside
        ((-64, -64, 0, 65, 0), (64, 0, True, False)),
        ((-64, -64, 0, 0, -65), (0, -64, True, False)),
        ((-64, -64, 0, -640, 32), (-64, 32, True, False)),  # each axis for itself
        ((-64, -64, 0, 10**6, -(10**6)), (64, -64, True, False)),
        ((64, -64, 0, 1, 1), (0, 0, False, True)),  # saddle
        ((-64, 64, 0, 1, 1), (0, 0, False, True)),
        ((64, 64, 0, 1, 1), (0, 0, False, True)),  # minimum
        ((0, 0, 0, 0, 0), (0, 0, False, True)),  # flat
        ((-64, 0, 0, 1, 0), (0, 0, False, True)),  # ridge
        ((-64, -64, 128, 1, 1), (0, 0, False, True)),  # denominator 0
        ((-64, -64, 129, 1, 1), (0, 0, False, True)),  # saddle by its cross term alone
        ((-64, -64, 127, 0, 0), (0, 0, False, False)),
    ],
)
def test_peak_by_hand(coefficients: tuple[int, ...], expected: tuple[int, int, bool, bool]) -> None:
    assert outcome(surface(*coefficients)) == expected


def test_printed_needs_no_maximum_but_a_denominator() -> None:
    # dx = (2 L1 L2 - L2 L4)/(L2² - 4 L0 L1) = 4/12, dy = (2 L0 L4 - L2 L3)/(...) = 2/12
    dx, dy, clamped, not_maximum = outcome(surface(1, 1, 4, 0, 1), printed=True)
    assert not clamped and not not_maximum
    assert abs(dx / 128 - 4 / 12) <= WORST
    assert abs(dy / 128 - 2 / 12) <= WORST
    assert outcome(surface(1, 1, 2, 3, 4), printed=True) == (0, 0, False, True)


Coefficient = st.integers(-(1 << 24), 1 << 24)


@given(st.lists(st.tuples(*[Coefficient] * 5), min_size=1, max_size=20))
def test_peak_equals_the_exact_quotient_within_the_dividers_error(rows: list[tuple[int, ...]]) -> None:
    offset = peak(Surface(*np.array(rows, dtype=np.int64).T))
    for k, (l0, l1, l2, l3, l4) in enumerate(rows):
        denominator = l2**2 - 4 * l0 * l1
        assert offset.not_maximum[k] == (not (l0 < 0 and l1 < 0 and denominator < 0))
        if offset.not_maximum[k]:
            assert offset.dx[k] == offset.dy[k] == 0 and not offset.clamped[k]
            continue
        dx = Fraction(2 * l1 * l3 - l2 * l4, denominator)
        dy = Fraction(2 * l0 * l4 - l2 * l3, denominator)
        assert offset.clamped[k] == (max(abs(dx), abs(dy)) > Fraction(1, 2))
        for measured, exact in ((offset.dx[k], dx), (offset.dy[k], dy)):
            inside = min(max(exact, Fraction(-1, 2)), Fraction(1, 2))
            assert abs(Fraction(int(measured), 128) - inside) <= WORST


@given(st.integers(0, 2**32 - 1), st.sampled_from([10, 130050, 2093058]))
def test_turning_the_samples_turns_the_nine_point_offset(seed: int, top: int) -> None:
    patches = np.random.default_rng(seed).integers(0, top // 2, (20, 3, 3), dtype=np.int32)
    patches[:, 1, 1] += top // 2
    whole = subpixel(patches, "nine")
    mirrored = subpixel(patches[:, :, ::-1], "nine")
    transposed = subpixel(patches.transpose(0, 2, 1), "nine")
    assert (mirrored.dx == -whole.dx).all() and (mirrored.dy == whole.dy).all()
    assert (transposed.dx == whole.dy).all() and (transposed.dy == whole.dx).all()
