"""The gradient steps: exact corners, symmetries, trust, and their purpose."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from golden import float_model
from golden.corners import Flag
from golden.derivatives import Derivatives
from golden.frame import Frame
from golden.normal_equations import (
    centre,
    normal_equations,
    window_place,
)
from golden.parameters import Parameters
from golden.settings import Settings
from golden.subpixel import FITS, Offset, derivative_bits, gradient_steps, peak, subpixel
from tests.support.offsets import exact_offsets, offset_bounds
from tests.support.photographs import PHOTOGRAPHS, photograph

STEP = Parameters.profile("precise")
Y, X = np.mgrid[-7:8, -7:8]
FLAT = np.zeros((1, 3, 3), np.int32)
"""Responses without a maximum: the steps start from the pixel."""
PEAKED = np.array([[[0, 1, 0], [1, 4, 3], [0, 1, 0]]], np.int32)
"""A peak a little to the right."""
Int64 = NDArray[np.int64]


def step(pixels: NDArray[np.generic], responses: NDArray[np.int32] = FLAT) -> Offset:
    return subpixel(responses, STEP, pixels)


def only(pixels: NDArray[np.generic]) -> tuple[float, float]:
    offset = step(pixels.astype(np.uint8)[None])
    assert not offset.clamped[0] and not offset.not_maximum[0]
    return offset.dx[0] / 128, offset.dy[0] / 128


@cache
def candidates() -> tuple[NDArray[np.int32], NDArray[np.uint8]]:
    """3x3 responses and pixels of every corner of the photographs, by the default thresholds."""
    responses, pixels = [], []
    for name in PHOTOGRAPHS:
        frame = Frame(photograph(name), STEP, Settings.default(STEP))
        _, limits = frame.own_thresholds()
        samples, windows = frame.surroundings(frame.candidates(limits))
        responses.append(samples)
        pixels.append(windows)
    return np.concatenate(responses), np.concatenate(pixels)


# -- corners


@pytest.mark.parametrize("dx", range(-2, 3))
@pytest.mark.parametrize("dy", range(-2, 3))
def test_a_cross_of_two_lines_is_found_exactly(dx: int, dy: int) -> None:
    """Lines one pixel wide have gradients on both sides alike, so the corner is their crossing."""
    assert only(((dx == X) | (dy == Y)) * 200) == pytest.approx((dx, dy), abs=0.02)


def saddle(x: float, y: float, degrees: float, blur: float = 1.0) -> NDArray[np.float64]:
    """Two smooth edges through (x, y), at right angles."""
    cosine, sine = np.cos(np.deg2rad(degrees)), np.sin(np.deg2rad(degrees))
    u, v = cosine * (X - x) + sine * (Y - y), cosine * (Y - y) - sine * (X - x)
    return np.rint(127 + 100 * np.tanh(u / blur) * np.tanh(v / blur))


@pytest.mark.parametrize("degrees", range(0, 360, 15))
def test_slanted_saddles_are_found(degrees: int) -> None:
    assert only(saddle(0.3, -0.2, degrees)) == pytest.approx((0.3, -0.2), abs=0.03)


@pytest.mark.parametrize("degrees", [0, 20, 45])
def test_soft_saddles_do_not_lock_to_pixels(degrees: int) -> None:
    """Edges as wide as half the window, which moves in 1/16 pixel from where a surface is right."""
    for x in np.arange(-8, 9) / 16:
        pixels = saddle(x, 0.25, degrees, 2.0).astype(np.uint8)[None]
        start = Offset(*(np.array([round(128 * place)]) for place in (x, 0.25)), *[np.zeros(1, bool)] * 2)
        assert gradient_steps(start, pixels, solve).dx[0] / 128 == pytest.approx(x, abs=0.04)


def test_the_largest_response_is_not_the_corner_of_a_square_but_the_steps_lead_there() -> None:
    """A bright square's corner at (30.5, 30.5); the paper's peak is more than a pixel inside."""
    y, x = np.mgrid[:64, :64]
    image = (((x > 30) & (y > 30)) * 160 + 40).astype(np.uint8)
    distances = {}
    for fit in ("nine", "gradient"):
        parameters = STEP.changed(fit=fit)
        frame = Frame(image, parameters, Settings.default(parameters))
        _, limits = frame.own_thresholds()
        place = np.array(frame.candidates(limits)[:2])[:, 0]
        corner = frame.records(limits)[:1]
        found = np.array([int(corner[0]) & 0xFFFFF, int(corner[0]) >> 20 & 0xFFFFF]) / 128
        assert np.abs(place - 30.5).max() < 3
        distances[fit] = np.hypot(*(found - 30.5))
    assert distances["nine"] > 1
    assert distances["gradient"] < 0.15


def test_pixels_are_needed() -> None:
    with pytest.raises(
        ValueError, match=r'^fit is "gradient", which needs pixels; allowed: \(\.\.\., 15, 15\)'
    ):
        subpixel(FLAT, STEP)


# -- trust


def solve(values: Derivatives[Int64]) -> Offset:
    return peak(values, derivative_bits(STEP), 12, FITS["gradient"].limit)


@pytest.mark.parametrize("pixels", [X * 0, X * 0 + 255, X * 16 + 120, Y * 9 + 99, (X > 0) * 200])
def test_parallel_gradients_have_no_corner_but_the_surface_may(pixels: NDArray[np.int64]) -> None:
    pixels = pixels.astype(np.uint8)[None]
    offset = step(pixels)
    assert offset.not_maximum[0] and not offset.clamped[0]
    assert (offset.dx[0], offset.dy[0]) == (0, 0)
    peaked, surface = step(pixels, PEAKED), subpixel(PEAKED, STEP.changed(fit="nine"))
    assert peaked.clamped[0] and not peaked.not_maximum[0]
    assert (peaked.dx[0], peaked.dy[0]) == (surface.dx[0], surface.dy[0]) == (16, 0)


def offset(dx: int, dy: int, *, clamped: bool = False, not_maximum: bool = False) -> Offset:
    return Offset(np.array([dx]), np.array([dy]), np.array([clamped]), np.array([not_maximum]))


SURFACE = offset(10, -20)
NO_PIXELS = np.zeros((1, 15, 15), np.uint8)


def judged(first: Offset, second: Offset, surface: Offset = SURFACE) -> tuple[int, int, bool, bool]:
    """What is made of two solutions of the steps' equations."""
    answers = iter((first, second))
    found = gradient_steps(surface, NO_PIXELS, lambda values: next(answers))
    return int(found.dx[0]), int(found.dy[0]), bool(found.clamped[0]), bool(found.not_maximum[0])


@pytest.mark.parametrize(
    ("first", "second", "trusted"),
    [
        # both windows stay around the pixel; the first step does not move
        (offset(10, -20), offset(10, -20), True),
        (offset(10, -20), offset(18, -12), True),
        (offset(10, -20), offset(19, -20), False),
        (offset(10, -20), offset(10, -29), False),
        # 40 to the first place: half of 40 and 8 to the second
        (offset(50, -20), offset(50, 8), True),
        (offset(50, -20), offset(22, -48), True),
        (offset(50, -20), offset(50, 9), False),
        (offset(50, -60), offset(79, -60), False),
        # one more, of which half is lost
        (offset(51, -20), offset(51, 8), True),
        (offset(51, -20), offset(51, 9), False),
        (offset(52, -20), offset(52, 9), True),
        (offset(50, -20, clamped=True), offset(50, -20), False),
        (offset(50, -20), offset(50, -20, clamped=True), False),
        (offset(50, -20, not_maximum=True), offset(50, -20), False),
        (offset(50, -20), offset(50, -20, not_maximum=True), False),
    ],
)
def test_trust_by_hand(first: Offset, second: Offset, trusted: bool) -> None:
    place = (int(second.dx[0]), int(second.dy[0])) if trusted else (10, -20)
    assert judged(first, second) == (*place, not trusted, False)


@pytest.mark.parametrize(("way", "leads"), [(63, False), (64, True), (-63, False), (-64, True)])
def test_a_long_first_step_counts_by_hand(way: int, leads: bool) -> None:
    """The second one does not agree; windows of whole pixels are those of the pixel itself."""
    start, first = offset(0, 3), offset(way, 3)
    second = offset(-128 if way == 64 else 0, 103)
    assert judged(first, second, start) == ((way, 3) if leads else (0, 3)) + (True, False)
    assert judged(first, offset(0, 0, not_maximum=True), start)[:2] == ((way, 3) if leads else (0, 3))
    # a surface without a maximum says so only where its pixel is what is left
    nothing = offset(0, 0, not_maximum=True)
    assert judged(offset(way, 0), second, nothing) == (way * leads, 0, leads, not leads)
    assert judged(offset(way, 0, clamped=True), second, nothing) == (0, 0, False, True)


@pytest.mark.parametrize(("far", "fails"), [(511, False), (512, True), (-511, False), (-512, True)])
def test_corners_are_less_than_four_pixels_away(far: int, fails: bool) -> None:
    """The second window is two pixels away, and its middle is where solutions count from."""
    second = offset(far - (256 if far > 0 else -256), -3)
    first = offset(400 if far > 0 else -400, 0)
    assert judged(first, second) == ((int(first.dx[0]), 0, True, False) if fails else (far, -3, False, False))
    # the first window is one pixel away
    assert judged(offset(far - 128, 0), offset(200, 0), offset(64, 0))[2] or far == 511
    assert judged(offset(384, -2), offset(0, 0), offset(64, 0))[:2] == (64, 0)


def test_windows_are_where_the_surface_and_the_first_step_lead() -> None:
    """Half a pixel of the surface counts; (128 + 72)/128 is 25/16, and -20/128 is -2/16."""
    pixels = ((X * Y) % 251).astype(np.uint8)[None]
    answers, asked = iter((offset(72, -20), offset(0, 0))), []

    def answer(values: Derivatives[Int64]) -> Offset:
        asked.append(values)
        return next(answers)

    gradient_steps(offset(70, -1), pixels, answer)
    assert asked == [normal_equations(pixels, np.array([x]), np.array([y])) for x, y in ((8, 0), (25, -2))]


def trusted_on_board(square: int) -> float:
    """Share of trusted steps from the corners of sharp squares, where a pixel's part they begin."""
    windows = []
    for shift in range(8):
        samples = np.indices((120, 120)) - 56 + shift
        fine = (samples // (8 * square)).sum(0) % 2 * 160.0 + 40
        windows.append(fine.reshape(15, 8, 15, 8).mean((1, 3)))
    found = step(np.rint(windows).astype(np.uint8), np.repeat(PEAKED, 8, axis=0))
    return float((~found.clamped).mean())


def test_steps_are_not_trusted_where_a_window_holds_several_corners() -> None:
    assert trusted_on_board(7) == 1
    assert trusted_on_board(5) == 0


# -- photographs


def places(offsets: Offset) -> tuple[Int64, Int64]:
    return window_place(offsets.dx), window_place(offsets.dy)


def test_first_steps_are_within_their_bounds_on_photographs() -> None:
    responses, pixels = candidates()
    surface = subpixel(responses, STEP.changed(fit="nine"))
    values = normal_equations(pixels, *places(surface))
    found, exact = solve(values), exact_offsets(values, STEP)
    limits = offset_bounds(values, STEP)
    assert len(limits) > 8_000 and np.isfinite(limits).mean() > 0.999
    assert (np.abs(found.dx / 128 - exact.dx) <= limits).all()
    assert (np.abs(found.dy / 128 - exact.dy) <= limits).all()
    assert (found.not_maximum == ~exact.maximum)[np.isfinite(limits)].all()
    error = np.hypot(found.dx / 128 - exact.dx, found.dy / 128 - exact.dy)
    for share, most in ((0.5, 0.0035), (0.95, 0.0065), (0.99, 0.025)):
        assert np.quantile(error, share) <= most


def test_where_steps_of_photographs_are_not_trusted_the_surface_or_the_first_one_stands() -> None:
    responses, pixels = candidates()
    found, surface = step(pixels, responses), subpixel(responses, STEP.changed(fit="nine"))
    # most photographs show textures, where edges are short
    trusted = ~found.clamped & ~found.not_maximum
    assert 0.4 < trusted.mean() < 0.6 and found.not_maximum.mean() < 0.01
    assert not (found.clamped & found.not_maximum).any()
    moved = np.maximum(np.abs(found.dx - surface.dx), np.abs(found.dy - surface.dy))
    # the surface has two mantissa bits more here than in the other fit
    stands, leads = moved <= 2, moved >= 64 - 2
    assert (stands | leads)[~trusted].mean() > 0.995
    assert 0.5 < leads[~trusted].mean() < 0.95 and stands[trusted].mean() < 0.1
    assert np.abs([found.dx, found.dy]).max() < FITS["gradient"].limit == 512


def test_least_squares_over_all_equations_says_the_same() -> None:
    """The float model, which has no normal equations, with windows at the same places."""
    responses, pixels = (each[::97] for each in candidates())
    x, y = places(subpixel(responses, STEP.changed(fit="nine")))
    values = normal_equations(pixels, x, y)
    found, limits = solve(values), offset_bounds(values, STEP)
    assert np.isfinite(limits).all()
    for k, window in enumerate(pixels):
        exact = float_model.gradient_step(window, x[k] / 16, y[k] / 16)
        assert exact is not None
        dx, dy = np.clip(np.array(exact) - (centre(x[k]), centre(y[k])), -4, 4)
        assert abs(found.dx[k] / 128 - dx) <= limits[k] + 1e-6
        assert abs(found.dy[k] / 128 - dy) <= limits[k] + 1e-6


def test_steps_of_the_float_model_are_near() -> None:
    """Its windows may be anywhere, which moves the next step by a part of the difference."""
    responses, pixels = (each[::47] for each in candidates())
    found, errors, agreed = step(pixels, responses), [], []
    for k, samples in enumerate(responses):
        start = float_model.peak(float_model.surface(samples, "gradient"))
        dx, dy, flag = float_model.gradient_steps(pixels[k], start)
        agreed.append(bool(flag) == (found.clamped[k] or found.not_maximum[k]))
        errors.append(max(abs(found.dx[k] / 128 - dx), abs(found.dy[k] / 128 - dy)))
    assert np.mean(agreed) > 0.97
    assert np.median(np.array(errors)[agreed]) <= 2 / 128
    assert np.quantile(np.array(errors)[agreed], 0.95) <= 0.06


def test_the_float_model_knows_no_corner_of_parallel_gradients() -> None:
    for pixels in (X * 0, X * 16 + 120):
        assert float_model.gradient_steps(pixels, (0.25, -0.1, Flag(0))) == (0.25, -0.1, Flag.CLAMPED)


# -- symmetries


def test_turning_the_pixels_turns_the_offset() -> None:
    """Exchanging x and y is exact. A mirror is not: halves and negative mantissas are rounded."""
    responses, pixels = (each[::13] for each in candidates())
    whole = step(pixels, responses)
    transposed = step(pixels.transpose(0, 2, 1), responses.transpose(0, 2, 1))
    assert (transposed.dx == whole.dy).all() and (transposed.dy == whole.dx).all()
    assert (transposed.clamped == whole.clamped).all()
    for way, x, y in (((1, -1), -1, 1), ((-1, 1), 1, -1), ((-1, -1), -1, -1)):
        mirrored = step(pixels[:, :: way[0], :: way[1]], responses[:, :: way[0], :: way[1]])
        apart = np.maximum(np.abs(x * mirrored.dx - whole.dx), np.abs(y * mirrored.dy - whole.dy))
        assert (apart <= 1).mean() > 0.7 and (apart <= 8).mean() > 0.9
        assert (mirrored.clamped == whole.clamped).mean() > 0.97


@given(st.integers(0, 2**32 - 1), st.integers(1, 155))
def test_brightness_and_polarity_change_nothing(seed: int, brightness: int) -> None:
    pixels = np.random.default_rng(seed).integers(0, 100, (4, 15, 15), dtype=np.uint8)
    one = step(pixels)
    for changed in (pixels + np.uint8(brightness), np.uint8(100) - pixels):
        other = step(changed)
        for field in ("dx", "dy", "clamped", "not_maximum"):
            assert (getattr(one, field) == getattr(other, field)).all()


@given(st.integers(0, 2**32 - 1))
def test_wider_pixels_of_the_same_values_change_nothing(seed: int) -> None:
    pixels = np.random.default_rng(seed).integers(0, 16, (4, 15, 15), dtype=np.uint16)
    offsets = [subpixel(FLAT, STEP.changed(pixel_bits=bits), pixels) for bits in (4, 8, 10)]
    for field in ("dx", "dy", "clamped", "not_maximum"):
        assert all((getattr(offsets[0], field) == getattr(other, field)).all() for other in offsets[1:])
