"""Quadratic fits of exact surfaces, and their peaks."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from golden.algorithm import Divider, Fit
from golden.divider import HALF
from golden.parameters import Parameters
from golden.subpixel import (
    FITS,
    Derivatives,
    Int64,
    Surface,
    bit_length,
    derivative_bits,
    derivatives,
    fit_nine,
    fit_printed,
    fit_six,
    mantissas,
    peak,
    subpixel,
)
from tests.support.offsets import bounds, exact_peaks

Y, X = np.mgrid[-1:2, -1:2]
SIX = [0, 3, 5, 7, 2, 6]
BITS = 26
"""Width of derivatives where there is no detector."""
MANTISSA_BITS = 10
"""Mantissa bits of a surface."""


def samples(l0: int, l1: int, l2: int, l3: int, l4: int, l5: int) -> NDArray[np.int64]:
    return l0 * X * X + l1 * Y * Y + l2 * X * Y + l3 * X + l4 * Y + l5


def design(x: NDArray[np.int64], y: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.stack([x * x, y * y, x * y, x, y, np.ones_like(x)], axis=1)


def applied_to_units(fit: Fit) -> NDArray[np.int64]:
    """The fit as a matrix: column k is the result of a single 1 at sample k."""
    fits = {"nine": fit_nine, "six": fit_six, "printed": fit_printed}
    return np.array(fits[fit](np.eye(9, dtype=np.int32).reshape(9, 3, 3)))


def surface(*coefficients: int) -> Derivatives[Int64]:
    return derivatives(Surface(*(np.array([value], dtype=np.int64) for value in coefficients)))


def outcome(
    values: Derivatives[Int64], bits: int = BITS, printed: bool = False
) -> tuple[int, int, bool, bool]:
    offset = peak(values, bits, MANTISSA_BITS, HALF, printed=printed)
    return int(offset.dx[0]), int(offset.dy[0]), bool(offset.clamped[0]), bool(offset.not_maximum[0])


PEAK_AT_03_02 = (-1000, -1500, 200, 640, -660, 5000)
"""f has its maximum at (0.3, -0.2): -2000·0.3 + 200·(-0.2) + 640 = 0 and -3000·(-0.2) + 200·0.3 -
660 = 0.
"""


@pytest.mark.parametrize(("fit", "scale"), [(fit_nine, 12), (fit_six, 2)])
def test_fit_recovers_the_coefficients_of_a_paraboloid(fit, scale: int) -> None:
    fitted = fit(samples(*PEAK_AT_03_02))
    assert [int(value) for value in fitted] == [scale * value for value in PEAK_AT_03_02[:5]]


@pytest.mark.parametrize(
    ("fit", "divider", "dx"),
    [("nine", "serial", 38), ("six", "serial", 38), ("nine", "table", 38), ("six", "table", 39)],
)
def test_fit_recovers_the_peak_of_a_paraboloid(fit: Fit, divider: Divider, dx: int) -> None:
    patches = samples(*PEAK_AT_03_02)[None]
    parameters = Parameters.profile("paper", fit=fit, divider=divider)
    offset = subpixel(patches, parameters)
    # 38.4 and -25.6 of 128
    assert (offset.dx[0], offset.dy[0]) == (dx, -26)
    assert exact_peaks(patches, parameters)[:2] == (pytest.approx(0.3), pytest.approx(-0.2))
    assert not offset.clamped[0] and not offset.not_maximum[0]


def test_printed_formulas_do_not_recover_it() -> None:
    """f = 1000 - 100 (x - 0.3)² - 100 (y + 0.2)²: Eqs. 11, 12 move its peak to (0.04, -0.54)."""
    patch = samples(-100, -100, 0, 60, -40, 1000 - 9 - 4)
    l0, l1, l2, l3, l4 = (int(value) for value in fit_printed(patch))
    denominator = l2 * l2 - 4 * l0 * l1
    assert round((2 * l1 * l3 - l2 * l4) / denominator, 2) == 0.04
    assert round((2 * l0 * l4 - l2 * l3) / denominator, 2) == -0.54
    # with the misprint of Eq. 13 too
    assert round((2 * l1 * l2 - l2 * l4) / denominator, 2) == -0.34
    offset = subpixel(patch[None], Parameters.profile("paper", fit="printed"))
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
    parameters = Parameters.profile("paper", fit=fit)
    low, high = samples(-100, -70, 20, 31, -17, 0), samples(-100, -70, 20, 31, -17, 2000000)
    assert subpixel(low[None], parameters).dx == subpixel(high[None], parameters).dx
    assert subpixel(low[None], parameters).dy == subpixel(high[None], parameters).dy


@pytest.mark.parametrize(
    ("coefficients", "expected"),
    [
        # dx = L3/(2|L0|), dy = L4/(2|L1|) where L2 = 0
        ((-64, -64, 0, 32, -32), (32, -32, False, False)),
        ((-64, -64, 0, 63, -63), (63, -63, False, False)),
        ((-64, -64, 0, 64, 0), (64, 0, True, False)),  # half a pixel is the end
        ((-64, -64, 0, 0, -64), (0, -64, True, False)),
        ((-64, -64, 0, 65, 0), (64, 0, True, False)),
        ((-64, -64, 0, 0, -65), (0, -64, True, False)),
        ((-64, -64, 0, -640, 32), (-64, 32, True, False)),  # each axis for itself
        ((-64, -64, 0, 10**4, -(10**4)), (64, -64, True, False)),
        ((-64, -64, 0, 10**6, 0), (0, 0, False, True)),  # so steep that the curvatures' mantissas are 0
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
    # dx = (2 L1 L2 - L2 L4)/(L2² - 4 L0 L1) = 4000/12000, dy = (2 L0 L4 - L2 L3)/(...) = 2000/12000
    assert outcome(surface(32, 32, 128, 0, 32), printed=True) == (43, 21, False, False)
    assert outcome(surface(32, 32, 64, 96, 128), printed=True) == (0, 0, False, True)


# -- mantissas


def test_bit_length() -> None:
    values = sorted({(1 << k) + d for k in range(54) for d in (-1, 0, 1) if (1 << k) + d <= 1 << 53})
    assert bit_length(np.array(values)).tolist() == [value.bit_length() for value in values]


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ((0, 0, 0, 0, 0), (0, 0, 0, 0, 0)),
        ((1023, -1, 5, 0, -1024), (1023, -1, 5, 0, -1024)),  # ten bits and a sign: nothing is cut
        ((1024, -1, 5, 0, -1024), (512, -1, 2, 0, -512)),
        ((3, 2, 1, -1, -1025), (1, 1, 0, -1, -513)),  # a negative one may be the largest
        ((5000, -5, 7, 8, -4096), (625, -1, 0, 1, -512)),
        ((1 << 25, (1 << 16) - 1, 1 << 16, -1, -(1 << 25)), (512, 0, 1, -1, -512)),
    ],
)
def test_mantissas_by_hand(values: tuple[int, ...], expected: tuple[int, ...]) -> None:
    seen = mantissas(Derivatives(*(np.array([value]) for value in values)), BITS, MANTISSA_BITS)
    assert tuple(int(value[0]) for value in seen) == expected


Value = st.one_of(st.integers(-(1 << 24), 1 << 24), st.integers(-2000, 2000), st.integers(-40, 40))
Rows = st.lists(st.tuples(*[Value] * 5), min_size=1, max_size=20)


def cut_to_ten_bits(values: tuple[int, ...]) -> list[int]:
    """The definition: all are divided by the power of two that leaves ten bits of the largest."""
    largest = max(max(value, -value - 1) for value in values)
    return [value >> max(largest.bit_length() - MANTISSA_BITS, 0) for value in values]


@given(Rows, st.integers(25, 36))
def test_mantissas_equal_their_definition_whatever_the_width(rows: list[tuple[int, ...]], bits: int) -> None:
    seen = mantissas(Derivatives(*np.array(rows).T), bits, MANTISSA_BITS)
    assert np.array(seen).T.tolist() == [cut_to_ten_bits(row) for row in rows]


def limited_quotient(numerator: int, denominator: int) -> tuple[int, bool]:
    """The nearest multiple of 1/128, halves away from zero, and whether it is one half or more."""
    magnitude = Fraction(abs(numerator), denominator)
    nearest = int(128 * min(magnitude, Fraction(1, 2)) + Fraction(1, 2))
    return nearest * (1 if numerator >= 0 else -1), magnitude >= Fraction(1, 2)


@given(Rows, st.booleans())
def test_peak_equals_the_exact_quotient_of_the_mantissas(rows: list[tuple[int, ...]], printed: bool) -> None:
    offset = peak(Derivatives(*np.array(rows).T), BITS, MANTISSA_BITS, HALF, printed=printed)
    for k, row in enumerate(rows):
        xx, yy, xy, x, y = cut_to_ten_bits(row)
        denominator = xx * yy - xy * xy
        by_x, by_y = yy * (xy if printed else x) + xy * y, xx * y + xy * x
        assert offset.not_maximum[k] == (denominator == 0 if printed else not (xx >= 0 and denominator > 0))
        if offset.not_maximum[k]:
            assert offset.dx[k] == offset.dy[k] == 0 and not offset.clamped[k]
            continue
        if denominator < 0:
            denominator, by_x, by_y = -denominator, -by_x, -by_y
        dx, beyond_x = limited_quotient(by_x, denominator)
        dy, beyond_y = limited_quotient(by_y, denominator)
        assert (offset.dx[k], offset.dy[k], offset.clamped[k]) == (dx, dy, beyond_x or beyond_y)


# -- symmetries


@given(st.integers(0, 2**32 - 1), st.sampled_from([10, 130050, 2093058]))
def test_turning_the_samples_turns_the_nine_point_offset(seed: int, top: int) -> None:
    """Exchanging x and y is exact. A mirror is not: negative mantissas are rounded down, too."""
    parameters = Parameters.profile("paper", pixel_bits=10)
    patches = np.random.default_rng(seed).integers(0, top // 2, (20, 3, 3), dtype=np.int32)
    patches[:, 1, 1] += top // 2
    whole = subpixel(patches, parameters)
    transposed = subpixel(patches.transpose(0, 2, 1), parameters)
    assert (transposed.dx == whole.dy).all() and (transposed.dy == whole.dx).all()
    assert (transposed.clamped == whole.clamped).all()
    assert (transposed.not_maximum == whole.not_maximum).all()
    for turned, x, y in (
        (patches[:, :, ::-1], -1, 1),
        (patches[:, ::-1], 1, -1),
        (patches[:, ::-1, ::-1], -1, -1),
    ):
        mirrored = subpixel(turned, parameters)
        both = 128 * (bounds(patches, parameters) + bounds(turned, parameters))
        assert (np.abs(x * mirrored.dx - whole.dx) <= both).all()
        assert (np.abs(y * mirrored.dy - whole.dy) <= both).all()
        assert (mirrored.not_maximum == whole.not_maximum)[np.isfinite(both)].all()


@given(st.integers(0, 2**32 - 1), st.sampled_from(["nine", "six"]), st.integers(1, 8))
def test_powers_of_two_change_nothing(seed: int, fit: Fit, bits: int) -> None:
    """Contrast does not matter, as soon as the largest derivative fills its mantissa."""
    parameters = Parameters.profile("paper", pixel_bits=10, fit=fit)
    rng = np.random.default_rng(seed)
    patches = rng.integers(0, parameters.response_max >> (bits + rng.integers(0, 3)), (20, 3, 3))
    values = derivatives((fit_nine if fit == "nine" else fit_six)(patches))
    full = (np.abs(values) >= 1 << MANTISSA_BITS).any(axis=0)
    assert full.any()
    one, other = subpixel(patches[full], parameters), subpixel(patches[full] << bits, parameters)
    for field in ("dx", "dy", "clamped", "not_maximum"):
        assert (getattr(one, field) == getattr(other, field)).all()


@given(st.integers(0, 2**32 - 1), st.sampled_from(["nine", "six", "printed"]))
def test_wider_pixels_of_the_same_values_change_nothing(seed: int, fit: Fit) -> None:
    patches = np.random.default_rng(seed).integers(0, 450, (20, 3, 3), endpoint=True)
    formats = [
        Parameters.profile("paper", pixel_bits=pixel_bits, fit=fit, gradient="signed")
        for pixel_bits in (4, 8, 10)
    ]
    offsets = [subpixel(patches, parameters) for parameters in formats]
    for field in ("dx", "dy", "clamped", "not_maximum"):
        assert all((getattr(offsets[0], field) == getattr(other, field)).all() for other in offsets[1:])


def test_what_a_fit_implies() -> None:
    for fit in ("nine", "six", "printed"):
        assert (FITS[fit].mantissa_bits, FITS[fit].limit, FITS[fit].by_pixels) == (MANTISSA_BITS, 64, False)
    step = FITS["gradient"]
    assert (step.mantissa_bits, step.limit, step.by_pixels) == (12, 512, True)
    assert [fit for fit, each in FITS.items() if each.printed] == ["printed"]


@pytest.mark.parametrize("fit", ["nine", "six", "printed"])
def test_derivative_bits_are_reached(fit: Fit) -> None:
    """One bit less would not hold all patches of 0 and full scale."""
    for pixel_bits in range(4, 11):
        parameters = Parameters.profile("paper", pixel_bits=pixel_bits, fit=fit)
        corners = np.array(np.unravel_index(np.arange(512), (2,) * 9)).T.reshape(-1, 3, 3)
        fits = {"nine": fit_nine, "six": fit_six, "printed": fit_printed}
        values = derivatives(fits[fit](corners * parameters.response_max))
        largest = max(int(np.abs(value).max()) for value in values)
        assert largest.bit_length() == derivative_bits(parameters)
