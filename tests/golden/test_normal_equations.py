"""The gradient step: sums by hand, exact corners, symmetries, and its purpose."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden.corner_detection import corner_detection
from golden.float_model import gradient_step
from golden.frame import response_map
from golden.normal_equations import LARGEST, PIXEL_SIZE, largest, normal_equations
from golden.parameters import Parameters
from golden.settings import Settings
from golden.subpixel import FITS, Offset, derivative_bits, subpixel
from golden.thresholds import thresholds
from tests.support.offsets import exact_offsets, offset_bounds
from tests.support.photographs import PHOTOGRAPHS, photograph

STEP = Parameters.profile("robust", fit="gradient")
Y, X = np.mgrid[-4:5, -4:5]
NO_RESPONSES = np.zeros((1, 3, 3), np.int32)
Pixels = NDArray[np.uint8]


def step(pixels: Pixels, parameters: Parameters = STEP) -> Offset:
    return subpixel(NO_RESPONSES, parameters, pixels)


def only(pixels: NDArray[np.generic]) -> tuple[float, float]:
    offset = step(pixels.astype(np.uint8)[None])
    assert not offset.clamped[0] and not offset.not_maximum[0]
    return offset.dx[0] / 128, offset.dy[0] / 128


@cache
def windows() -> Pixels:
    """The pixels around every corner of the photographs, by the default thresholds."""
    found, settings = [], Settings.default(STEP)
    for name in PHOTOGRAPHS:
        responses = response_map(photograph(name), STEP)
        t1, _ = thresholds(settings, max(int(responses.max()), settings.floor), STEP)
        rows, columns = np.nonzero(corner_detection(responses[3:-3, 3:-3], t1, STEP.algorithm.ties))
        found.append(sliding_window_view(photograph(name), (PIXEL_SIZE, PIXEL_SIZE))[rows + 3, columns + 3])
    return np.concatenate(found)


def test_sums_by_hand() -> None:
    """A lone pixel of 10: gx is -10 left and 10 right of it, gy above and below, never both."""
    pixels = np.zeros((1, 9, 9), np.uint8)
    pixels[0, 4 + 1, 4 + 2] = 10
    xx, yy, xy, x, y = (int(value[0]) for value in normal_equations(pixels))
    assert (xx, yy, xy) == (200, 200, 0)
    # gradients at u = 1 and 3, and at v = 0 and 2
    assert (x, y) == (100 * (1 + 3), 100 * (0 + 2))


def test_a_mixed_product_by_hand() -> None:
    """Both gradients are only at the place (-3, 3), with opposite signs: C = -6."""
    pixels = np.zeros((1, 9, 9), np.uint8)
    pixels[0, 4 + 3, 4 - 4] = 2  # left of it: gx = 2
    pixels[0, 4 + 4, 4 - 3] = 3  # below it: gy = -3
    xx, yy, xy, x, y = (int(value[0]) for value in normal_equations(pixels))
    assert (xx, yy, xy) == (4, 9, 6)
    assert x == 4 * -3 + -6 * 3 and y == -6 * -3 + 9 * 3


@pytest.mark.parametrize("dx", range(-2, 3))
@pytest.mark.parametrize("dy", range(-2, 3))
def test_a_cross_of_two_lines_is_found_exactly(dx: int, dy: int) -> None:
    """Lines one pixel wide have gradients on both sides alike, so the corner is their crossing."""
    assert only(((dx == X) | (dy == Y)) * 200) == pytest.approx((dx, dy), abs=0.04)


@pytest.mark.parametrize("angle", range(0, 360, 15))
def test_slanted_saddles_are_found(angle: int) -> None:
    """Two smooth edges through (0.3, -0.2), at right angles."""
    cosine, sine = np.cos(np.deg2rad(angle)), np.sin(np.deg2rad(angle))
    u, v = cosine * (X - 0.3) + sine * (Y + 0.2), cosine * (Y + 0.2) - sine * (X - 0.3)
    dx, dy = only(np.rint(127 + 100 * np.tanh(u) * np.tanh(v)))
    # at 45 degrees the window cuts the asymmetry of the corner off: 0.062
    assert np.hypot(dx - 0.3, dy + 0.2) < 0.065


def test_the_largest_response_is_not_the_corner_of_a_square_but_the_step_leads_there() -> None:
    """A bright square's corner at (30.5, 30.5); the paper's peak is more than a pixel inside."""
    y, x = np.mgrid[:64, :64]
    image = (((x > 30) & (y > 30)) * 160 + 40).astype(np.uint8)
    distances = {}
    for fit in ("nine", "gradient"):
        parameters = Parameters.profile("robust", fit=fit)
        responses = response_map(image, parameters)
        row, column = np.unravel_index(responses.argmax(), responses.shape)
        offset = subpixel(
            responses[None, row - 1 : row + 2, column - 1 : column + 2],
            parameters,
            image[None, row + 3 - 4 : row + 3 + 5, column + 3 - 4 : column + 3 + 5],
        )
        place = column + 3 + offset.dx[0] / 128, row + 3 + offset.dy[0] / 128
        distances[fit] = np.hypot(place[0] - 30.5, place[1] - 30.5)
    assert distances["nine"] > 1
    assert distances["gradient"] < 0.25


def test_pixels_are_needed() -> None:
    with pytest.raises(
        ValueError, match=r'^fit is "gradient", which needs pixels; allowed: \(\.\.\., 9, 9\)'
    ):
        subpixel(NO_RESPONSES, STEP)


@pytest.mark.parametrize("pixels", [X * 0, X * 0 + 255, X * 20 + 100, Y * 9 + 99, (X > 0) * 200])
def test_parallel_gradients_have_no_corner(pixels: NDArray[np.int64]) -> None:
    offset = step(pixels.astype(np.uint8)[None])
    assert offset.not_maximum[0] and not offset.clamped[0]
    assert (offset.dx[0], offset.dy[0]) == (0, 0)


def test_far_corners_are_clamped_to_four_pixels() -> None:
    """Two lines that meet eight pixels to the left."""
    lines = 100 * np.exp(-((Y - 0.4 * (X + 8)) ** 2)) + 50 * np.exp(-((Y + 0.4 * (X + 8)) ** 2))
    offset = step(np.rint(100 + lines).astype(np.uint8)[None])
    assert offset.clamped[0] and offset.dx[0] == -FITS["gradient"].limit == -512
    assert abs(offset.dy[0]) < 20


def test_offsets_are_within_their_bounds_on_photographs() -> None:
    values = normal_equations(windows())
    offset, exact = step(windows()), exact_offsets(values, STEP)
    limits = offset_bounds(values, STEP)
    assert len(limits) > 11_000 and np.isfinite(limits).mean() > 0.999
    assert (np.abs(offset.dx / 128 - exact.dx) <= limits).all()
    assert (np.abs(offset.dy / 128 - exact.dy) <= limits).all()
    assert (offset.not_maximum == ~exact.maximum)[np.isfinite(limits)].all()


def test_error_of_photographs_corners() -> None:
    """Median, 95th and 99th percentile in pixels of the mantissas' error; rounding makes 1/256."""
    offset, exact = step(windows()), exact_offsets(normal_equations(windows()), STEP)
    error = np.hypot(offset.dx / 128 - exact.dx, offset.dy / 128 - exact.dy)
    assert np.quantile(error, 0.5) <= 0.0035
    assert np.quantile(error, 0.95) <= 0.0065
    assert np.quantile(error, 0.99) <= 0.025


def test_least_squares_over_49_equations_says_the_same() -> None:
    """The float model, which has no normal equations."""
    some = windows()[::97]
    limits = offset_bounds(normal_equations(some), STEP)
    offset = step(some)
    for k in np.flatnonzero(np.isfinite(limits)):
        dx, dy, flag = gradient_step(some[k])
        assert abs(offset.dx[k] / 128 - dx) <= limits[k] + 1e-6
        assert abs(offset.dy[k] / 128 - dy) <= limits[k] + 1e-6
        assert not offset.clamped[k] or flag or max(abs(dx), abs(dy)) > 4 - limits[k]


def test_turning_the_pixels_turns_the_offset() -> None:
    """Exchanging x and y is exact. A mirror is not: negative mantissas are rounded down, too."""
    some = windows()[::13]
    whole, transposed = step(some), step(some.transpose(0, 2, 1))
    assert (transposed.dx == whole.dy).all() and (transposed.dy == whole.dx).all()
    limits = 128 * offset_bounds(normal_equations(some), STEP)
    for turned, x, y in ((some[:, :, ::-1], -1, 1), (some[:, ::-1], 1, -1), (some[:, ::-1, ::-1], -1, -1)):
        mirrored = step(turned)
        both = limits + 128 * offset_bounds(normal_equations(turned), STEP)
        assert (np.abs(x * mirrored.dx - whole.dx) <= both).all()
        assert (np.abs(y * mirrored.dy - whole.dy) <= both).all()


@given(st.integers(0, 2**32 - 1), st.integers(1, 155))
def test_brightness_and_polarity_change_nothing(seed: int, brightness: int) -> None:
    pixels = np.random.default_rng(seed).integers(0, 100, (4, 9, 9), dtype=np.uint8)
    one = step(pixels)
    for changed in (pixels + np.uint8(brightness), np.uint8(100) - pixels):
        other = step(changed)
        for field in ("dx", "dy", "clamped", "not_maximum"):
            assert (getattr(one, field) == getattr(other, field)).all()


@given(st.integers(0, 2**32 - 1))
def test_wider_pixels_of_the_same_values_change_nothing(seed: int) -> None:
    pixels = np.random.default_rng(seed).integers(0, 16, (4, 9, 9), dtype=np.uint16)
    offsets = [step(pixels, Parameters.profile("robust", pixel_bits=bits)) for bits in (4, 8, 10)]
    for field in ("dx", "dy", "clamped", "not_maximum"):
        assert all((getattr(offsets[0], field) == getattr(other, field)).all() for other in offsets[1:])


@pytest.mark.parametrize("pixel_bits", range(4, 11))
def test_bound_of_the_sums(pixel_bits: int) -> None:
    """Stripes along both diagonals have gx = ±gy of full size where their contrast is largest."""
    parameters = Parameters.profile("robust", pixel_bits=pixel_bits)
    assert LARGEST == 168 and largest(parameters) == 168 * parameters.product_max
    assert derivative_bits(parameters) == largest(parameters).bit_length()
    rng = np.random.default_rng(pixel_bits)
    pixels = (rng.integers(0, 2, (50_000, 9, 9)) * parameters.pixel_max).astype(np.uint16)
    assert max(int(np.abs(value).max()) for value in normal_equations(pixels)) <= largest(parameters)
