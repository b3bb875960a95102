# amaranth: UnusedElaboratable=no
"""Subpixel refinement: every kind of surface, every fit, every pixel width, as fast as it says."""

from __future__ import annotations

from itertools import product
from typing import get_args

import numpy as np
import pytest

from golden.algorithm import Divider, Fit
from golden.derivatives import Derivatives
from golden.normal_equations import FARTHEST, normal_equations
from golden.subpixel import FITS as GOLDEN_FITS
from golden.subpixel import Int64, derivative_bits, peak
from hdl.build import Build
from hdl.fits import solved_formats, solved_layout
from hdl.subpixel import Subpixel, offset_layout
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import ENGINES, NO_STALLS, RUN_IDS, RUNS, Array, check_block, latency, unpack

Y, X = np.mgrid[-1:2, -1:2]
# each fit with a divider, and each divider with a fit: they meet in a few signals only
every_fit = pytest.mark.parametrize(("fit", "divider"), [("nine", "table"), ("six", "serial")])
with_step = pytest.mark.parametrize(
    ("fit", "divider"),
    [("nine", "table"), ("six", "serial"), ("gradient", "serial"), ("gradient", "table")],
)
one_bit_or_two = pytest.mark.parametrize("bits_per_clock", [1, 2], ids=["one-bit", "two-bits"])
every_width = pytest.mark.parametrize("pixel_bits", [4, 8, 10])


def check(
    fit: Fit,
    patches: Array,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    pixel_bits: int = 8,
    divider: Divider = "table",
    bits_per_clock: int = 1,
) -> Capture:
    """``patches``: (n, 3, 3)."""
    assert patches.min() >= 0 and patches.max() <= Build.profile("paper", pixel_bits=pixel_bits).response_max
    values = GOLDEN_FITS[fit].derivatives(patches)
    return check_derivatives(fit, values, name, stalls, pixel_bits, divider, bits_per_clock)


def check_derivatives(
    fit: Fit,
    values: Derivatives[Int64],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    pixel_bits: int = 8,
    divider: Divider = "table",
    bits_per_clock: int = 1,
) -> Capture:
    """``values`` as the golden model has them."""
    parameters = Build.profile("paper", fit=fit, divider=divider, pixel_bits=pixel_bits)
    formats = solved_formats(parameters)
    golden_fit = GOLDEN_FITS[fit]
    offset = peak(
        values, derivative_bits(parameters), golden_fit.mantissa_bits, golden_fit.limit, divider=divider
    )
    fields = {
        "dx": offset.dx,
        "dy": offset.dy,
        "clamped": offset.clamped,
        "not_maximum": offset.not_maximum,
    }
    given = {
        field: value >> form.zeros
        for (field, value), form in zip(values._asdict().items(), formats, strict=True)
    }
    block = (Subpixel, parameters, None, bits_per_clock)
    interval = Subpixel(*block[1:]).interval
    return check_block(block, {"i": given}, {"o": fields}, name, stalls, clocks=interval)


def peaks(count: int, largest: int, seed: int = 0) -> Array:
    """Random patches whose centre is the largest, from flat to steep."""
    rng = np.random.default_rng(seed)
    centre = rng.integers(1, largest, count, endpoint=True)
    depth = rng.integers(0, centre, endpoint=True)
    patches = centre[:, None, None] - rng.integers(0, depth[:, None, None], (count, 3, 3), endpoint=True)
    patches[:, 1, 1] = centre
    return patches


def paraboloids(count: int, largest: int, seed: int = 0) -> Array:
    """Rounded paraboloids with their peak anywhere in the patch: what corners look like."""
    rng = np.random.default_rng(seed)
    px, py = rng.uniform(-1, 1, (2, count, 1, 1))
    a, b = rng.uniform(0.02, 0.2, (2, count, 1, 1))
    c = rng.uniform(-2, 2, (count, 1, 1)) * np.sqrt(a * b)
    x, y = X - px, Y - py
    surface = 1 - np.clip(a * x * x + b * y * y + c * x * y, 0, 1)
    return (surface * largest).astype(np.int64)


def named(largest: int) -> Array:
    """Flat, ridges, saddles, ramps, lone corners and holes, at full scale and one above nothing."""
    shapes = [
        X * 0,
        X * 0 + 1,
        1 - abs(X),
        1 - abs(Y),
        (X == Y) * 1,
        (X == -Y) * 1,
        abs(X),
        X * X - Y * Y + 1,
        Y * Y - X * X + 1,
        X * Y + 1,
        1 - X * Y,
        X + 1,
        1 - Y,
        X + Y + 2,
        2 - X + Y,
        (X == 0) & (Y == 0),
        (X != 0) | (Y != 0),
        2 - X * X - Y * Y,
        4 - abs(X + Y) - abs(X),
    ]
    return np.stack([s * height // s.max() if s.max() else s for s in shapes for height in (largest, 4)])


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@every_fit
@one_bit_or_two
def test_peaks(fit: Fit, divider: Divider, bits_per_clock: int, name: EngineName, stalls: Stalls) -> None:
    count = 2000 if name == "compiled" else 60
    full = Build.profile("paper").response_max
    patches = np.concatenate([peaks(count, full), paraboloids(count, full)])
    capture = check(fit, patches, name, stalls, divider=divider, bits_per_clock=bits_per_clock)
    if not stalls.outputs:
        # starved or not: never longer, and the next one when this one has moved on
        build = Build.profile("paper", fit=fit, divider=divider)
        block = Subpixel(build, bits_per_clock=bits_per_clock)
        assert (latency(capture) == block.latency).all()
        assert (np.diff(capture.input_clocks["i"]) >= block.interval).all()


@every_fit
@every_width
@one_bit_or_two
def test_many_patches(fit: Fit, divider: Divider, pixel_bits: int, bits_per_clock: int) -> None:
    full = Build.profile("paper", pixel_bits=pixel_bits).response_max
    rng = np.random.default_rng(pixel_bits)
    anything = rng.integers(0, full, (20_000, 3, 3), endpoint=True)
    small = rng.integers(0, 3, (20_000, 3, 3), endpoint=True)
    patches = [peaks(20_000, full, 1), peaks(20_000, 9, 2), paraboloids(30_000, full, 3), anything, small]
    # responses of every height: every shift
    patches += [peaks(500, full >> k, k) for k in range(full.bit_length() - 1)]
    capture = check(
        fit,
        np.concatenate(patches),
        pixel_bits=pixel_bits,
        divider=divider,
        bits_per_clock=bits_per_clock,
    )
    seen = unpack(offset_layout(), capture.outputs["o"])
    inside = ~(seen["clamped"] | seen["not_maximum"]).astype(bool)
    # the test would say nothing if these did not occur
    assert inside.any() and seen["clamped"].any() and seen["not_maximum"].any()
    assert set(range(-63, 64)) <= set(seen["dx"][inside].tolist())
    assert set(range(-63, 64)) <= set(seen["dy"][inside].tolist())


@every_fit
@every_width
def test_extremes(fit: Fit, divider: Divider, pixel_bits: int) -> None:
    """Every patch of nothing but 0 and full scale: all 512, and the named ones."""
    full = Build.profile("paper", pixel_bits=pixel_bits).response_max
    corners = np.array(list(product((0, full), repeat=9))).reshape(-1, 3, 3)
    check(fit, np.concatenate([corners, named(full)]), pixel_bits=pixel_bits, divider=divider)


@with_step
@every_width
@one_bit_or_two
def test_any_derivatives(fit: Fit, divider: Divider, pixel_bits: int, bits_per_clock: int) -> None:
    """Values that no patch has: each of the five at its ends, around 0, and of every length."""
    parameters = Build.profile("paper", fit=fit, divider=divider, pixel_bits=pixel_bits)
    rng = np.random.default_rng(pixel_bits)
    values = []
    formats = solved_formats(parameters)
    for (_, field), form in zip(solved_layout(parameters), formats, strict=True):
        top = (1 << (field.width - 1)) - 1
        ends = rng.choice([-top - 1, -top, -1, 0, 1, top], 20_000)
        anything = rng.integers(-top - 1, top, 20_000, endpoint=True)
        lengths = anything[:20_000] >> rng.integers(0, field.width, 20_000)
        # curvatures and slopes whose products nearly cancel
        near = (top >> 3) - rng.integers(0, 1 << rng.integers(1, field.width - 4, 20_000))
        values.append(np.concatenate([ends, anything, lengths, near]) << form.zeros)
    capture = check_derivatives(
        fit,
        Derivatives(*values),
        pixel_bits=pixel_bits,
        divider=divider,
        bits_per_clock=bits_per_clock,
    )
    seen = unpack(offset_layout(fit), capture.outputs["o"])
    assert (
        seen["clamped"].any()
        and seen["not_maximum"].any()
        and not (seen["clamped"] & seen["not_maximum"]).any()
    )


@every_fit
@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(fit: Fit, divider: Divider, name: EngineName) -> None:
    """4000 - 1000x² - 1500y² + 200xy + 640x - 660y peaks at (0.3, -0.2): 38.4 and -25.6 of 128.

    With -200 xy and +660 y it is at (0.3, 0.2).
    """
    surface = 4000 - 1000 * X * X - 1500 * Y * Y + 200 * X * Y + 640 * X - 660 * Y
    other = 4000 - 1000 * X * X - 1500 * Y * Y - 200 * X * Y + 640 * X + 660 * Y
    flat, ridge, bowl = X * 0 + 9, 5 - X * X, X * X + Y * Y
    steep = 100 * (4 - (X - 1) * (X - 1) - Y * Y)
    half = 200 - 64 * (X * X + Y * Y) - 64 * Y
    capture = check(
        fit, np.stack([surface, flat, ridge, bowl, steep + 200, half, other]), name, divider=divider
    )
    seen = unpack(offset_layout(), capture.outputs["o"])
    assert seen["dx"].tolist() == [38, 0, 0, 0, 64, 0, 38]
    # nine points give larger numbers, of which more is cut: 25 is nearer to what is left
    assert seen["dy"].tolist() == [-26, 0, 0, 0, 0, -64, {"nine": 25, "six": 26}[fit]]
    assert seen["not_maximum"].tolist() == [0, 1, 1, 1, 0, 0, 0]
    assert seen["clamped"].tolist() == [0, 0, 0, 0, 1, 1, 0]


@every_fit
def test_lone_candidates(fit: Fit, divider: Divider) -> None:
    """Each finds the unit idle, and leaves it idle: nothing of one is left for the next."""
    full = Build.profile("paper").response_max
    patches = np.concatenate([named(full), peaks(300, full)])
    capture = check(fit, patches, stalls=Stalls(inputs=0.995, seed=1), divider=divider)
    block = Subpixel(Build.profile("paper", fit=fit, divider=divider))
    assert (latency(capture) == block.latency).all()
    assert np.quantile(np.diff(capture.input_clocks["i"]), 0.5) > block.latency


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_gradient_steps(name: EngineName, stalls: Stalls) -> None:
    """Windows with every kind of corner, at every contrast."""
    rng = np.random.default_rng(4)
    count = 4000 if name == "compiled" else 60
    contrast = rng.integers(1, 255, (count, 1, 1), endpoint=True)
    v, u = np.mgrid[-7:8, -7:8]
    angles = rng.uniform(0, 2 * np.pi, (2, count, 1, 1))
    u, v = u - rng.uniform(-9, 9, (count, 1, 1)), v - rng.uniform(-9, 9, (count, 1, 1))
    sides = [np.cos(angle) * u + np.sin(angle) * v > 0 for angle in angles]
    pixels = np.where(sides[0] & sides[1], contrast, 0)
    pixels[::2] = np.where(sides[0] ^ sides[1], contrast, 0)[::2]
    pixels += rng.integers(0, 1 + (255 - contrast) // 8, pixels.shape)
    # without any gradient, and with parallel ones
    pixels[7], pixels[8] = 7, 3 * np.arange(15)
    x, y = rng.integers(-FARTHEST, FARTHEST, (2, count), endpoint=True)
    equations = normal_equations(pixels.astype(np.uint8), x, y)
    capture = check_derivatives("gradient", equations, name, stalls, divider="serial")
    seen = unpack(offset_layout("gradient"), capture.outputs["o"])
    inside = ~(seen["clamped"] | seen["not_maximum"]).astype(bool)
    assert inside.any()
    if name == "compiled":
        assert seen["clamped"].any() and seen["not_maximum"].any()
        assert len(np.unique(seen["dx"][inside])) > 400


def test_latency_of_the_gradient_step() -> None:
    """32 bits, of which 12 go on: to shift them takes longer than either division."""
    for divider in get_args(Divider):
        build = Build.profile("paper", fit="gradient", divider=divider)
        for bits_per_clock, interval in ((1, 21), (2, {"serial": 12, "table": 11}[divider])):
            block = Subpixel(build, bits_per_clock=bits_per_clock)
            assert block.interval == interval and block.latency == 3 * interval + 1


@every_fit
@every_width
def test_latency(fit: Fit, divider: Divider, pixel_bits: int) -> None:
    """A clock per cut bit in the first stage, bits and one in the second, and one to move on."""
    parameters = Build.profile("paper", fit=fit, divider=divider, pixel_bits=pixel_bits)
    block = Subpixel(parameters)
    assert block.interval == 1 + max(derivative_bits(parameters) - 10, 12)
    assert block.latency == 3 * block.interval + 1
    # two bits per clock: eight clocks of either divider, as many as of products
    assert Subpixel(parameters, bits_per_clock=2).interval == 9


def test_the_printed_fit_is_refused() -> None:
    with pytest.raises(ValueError, match="fit is 'printed'; allowed in hardware: nine, six, gradient"):
        Subpixel(Build.profile("paper", fit="printed"))
