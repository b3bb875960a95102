"""Subpixel refinement (Sec. 3.4): the peak of a quadratic surface, or gradient steps from there."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from golden import normal_equations
from golden.algorithm import Divider, Fit
from golden.derivatives import Derivatives
from golden.divider import HALF, divide, reaches
from golden.formats import OFFSET_BITS
from golden.parameters import Parameters
from golden.preprocessing import Image, IntArray
from golden.table_divider import divide_by_table

Int64 = NDArray[np.int64]


class Surface(NamedTuple):
    """f(x, y) = L0 x² + L1 y² + L2 xy + L3 x + L4 y + L5 (Eq. 10), times a positive whole scale.

    L5 does not move the peak, and is left out.
    """

    l0: Int64
    l1: Int64
    l2: Int64
    l3: Int64
    l4: Int64


@dataclass(frozen=True)
class Offset:
    """Place of corners relative to their pixels."""

    dx: Int64
    """In 1/128 pixel, within ±:attr:`SubpixelFit.limit`."""
    dy: Int64
    """Likewise."""
    clamped: NDArray[np.bool_]
    """The corner lies as far away as the limit or farther, along x or y.

    By ``fit="gradient"``: its steps cannot be trusted; see :func:`gradient_steps`.
    """
    not_maximum: NDArray[np.bool_]
    """There is no maximum and, by ``fit="gradient"``, no step to trust either; dx and dy are 0."""


def fit_nine(s: IntArray) -> Surface:
    """Least squares over the nine samples (..., 3, 3), times 12.

    It consists of sums only, because x and y are -1, 0 or 1 on the grid.
    """
    s = s.astype(np.int64)
    left, middle, right = s[..., 0].sum(-1), s[..., 1].sum(-1), s[..., 2].sum(-1)
    top, centre, bottom = s[..., 0, :].sum(-1), s[..., 1, :].sum(-1), s[..., 2, :].sum(-1)
    return Surface(
        l0=2 * (left - 2 * middle + right),
        l1=2 * (top - 2 * centre + bottom),
        l2=3 * (s[..., 0, 0] - s[..., 0, 2] - s[..., 2, 0] + s[..., 2, 2]),
        l3=2 * (right - left),
        l4=2 * (bottom - top),
    )


def _six_samples(s: IntArray) -> tuple[Int64, ...]:
    # S0 S3 S5 S7 S2 S6, numbered in raster order (Fig. 7)
    flat = s.astype(np.int64).reshape(*s.shape[:-2], 9)
    return tuple(flat[..., k] for k in (0, 3, 5, 7, 2, 6))


def fit_six(s: IntArray) -> Surface:
    """The surface through the paper's six samples, times 2, by the inverse of the design matrix."""
    s0, s3, s5, s7, s2, s6 = _six_samples(s)
    return Surface(
        l0=s0 - s2 - 2 * s3 + 2 * s5 + 2 * s6 - 2 * s7,
        l1=s0 - 2 * s3 + s6,
        l2=s0 - s2 - s3 + s5,
        l3=s5 - s3,
        l4=s6 - s2 - s3 + s5,
    )


def fit_printed(s: IntArray) -> Surface:
    """L = (Vx · Vy) S with the two ``vander`` matrices of Eqs. 11 and 12, times 6.

    The product has rank 3, so this is not a fit at all.
    """
    x, y = np.array([-1, -1, 1, 0, 1, -1]), np.array([-1, 0, 0, 1, -1, 1])
    weights = np.vander(x) @ np.vander(y)
    samples = np.stack(_six_samples(s), axis=-1)
    return Surface(*(samples @ weights[k] for k in range(5)))


def derivatives(surface: Surface) -> Derivatives[Int64]:
    """Derivatives at the centre pixel, in units of the surface's scale."""
    return Derivatives(-2 * surface.l0, -2 * surface.l1, surface.l2, surface.l3, surface.l4)


@dataclass(frozen=True)
class SubpixelFit:
    """One way to refine a corner.

    Parameters
    ----------
    derivatives
        The five values of a surface fitted to (..., 3, 3) responses.
    largest
        The largest size of one of the five values in a detector with these parameters.
    limit
        Largest offset along an axis, in 1/128 pixel, a power of two.
    mantissa_bits
        Bits of the five values, beside their sign, that go into the products of Eq. 13.
    by_pixels
        The surface's peak is where gradient steps start, which read pixels.
    printed
        Eq. 13 with its misprint, and without asking for a maximum; see :func:`peak`.
    """

    derivatives: Callable[[IntArray], Derivatives[Int64]]
    largest: Callable[[Parameters], int]
    limit: int
    mantissa_bits: int
    by_pixels: bool = False
    printed: bool = False


def _by_surface(fit: Callable[[IntArray], Surface], printed: bool = False) -> SubpixelFit:
    """The peak of a surface, which has no meaning beyond half a pixel."""
    # each value is a weighted sum of the samples: it is largest where only those with weights of
    # one sign are not zero
    units = np.eye(9, dtype=np.int64).reshape(9, 3, 3)
    weights = np.stack(derivatives(fit(units)))
    gain = int(np.maximum(np.maximum(weights, 0).sum(-1), np.maximum(-weights, 0).sum(-1)).max())
    return SubpixelFit(
        derivatives=lambda responses: derivatives(fit(responses)),
        largest=lambda parameters: gain * parameters.response_max,
        limit=HALF,
        mantissa_bits=10,
        printed=printed,
    )


def _by_gradients(surface: SubpixelFit) -> SubpixelFit:
    """Steps from the surface's peak; a corner may lie anywhere in a window or a little outside."""
    return replace(
        surface,
        largest=lambda parameters: max(surface.largest(parameters), normal_equations.largest(parameters)),
        limit=4 << OFFSET_BITS,
        # the two equations are close to each other where one edge is much the stronger
        mantissa_bits=12,
        by_pixels=True,
    )


_NINE = _by_surface(fit_nine)
FITS: dict[Fit, SubpixelFit] = {
    "nine": _NINE,
    "six": _by_surface(fit_six),
    "printed": _by_surface(fit_printed, printed=True),
    "gradient": _by_gradients(_NINE),
}
"""All that depends on ``Algorithm.fit``."""


def derivative_bits(parameters: Parameters) -> int:
    """Width of the largest derivative that the fit can give, without its sign."""
    return FITS[parameters.algorithm.fit].largest(parameters).bit_length()


def mantissas(values: Derivatives[Int64], bits: int, mantissa_bits: int) -> Derivatives[Int64]:
    """The five values as block floating point, with one exponent for all.

    Each mantissa has ``mantissa_bits`` and a sign.
    The peak depends on ratios only. So all values are shifted up until the largest, which has
    ``bits`` bits at most, is at the top, or until nothing would be lost; then they are rounded
    down.
    """
    low = max(bits - mantissa_bits, 0)
    largest = np.maximum.reduce([np.where(value < 0, ~value, value) for value in values])
    shift = np.minimum(bits - bit_length(largest), low)
    return Derivatives(*((value << shift) >> low for value in values))


def bit_length(values: Int64) -> Int64:
    """Number of bits of integers from 0 to 2**53."""
    return np.frexp(values.astype(np.float64))[1].astype(np.int64)


def peak(
    values: Derivatives[Int64],
    bits: int,
    mantissa_bits: int,
    limit: int,
    *,
    divider: Divider = "serial",
    printed: bool = False,
) -> Offset:
    """Stationary point of the surface (Eq. 13) where that is a maximum, clamped to ``limit``.

        dx = (2 L1 L3 - L2 L4) / (L2² - 4 L0 L1) = (yy·x + xy·y) / (xx·yy - xy²)
        dy = (2 L0 L4 - L2 L3) / (L2² - 4 L0 L1) = (xx·y + xy·x) / (xx·yy - xy²)

    Where a curvature or the denominator has the wrong sign, the offset is (0, 0). Beyond the limit,
    in 1/128 pixel, each axis is clamped by itself. ``bits`` is the width of the largest value
    (:func:`derivative_bits`), ``mantissa_bits`` that of the factors.

    ``printed`` leaves the misprint 2 L1 L2 in the first numerator and, as the paper, does not ask
    for a maximum: Eqs. 11 and 12 turn nearly every corner into a surface without one. The offset is
    clamped all the same.
    """
    xx, yy, xy, x, y = mantissas(values, bits, mantissa_bits)
    denominator = xx * yy - xy * xy
    usable = denominator != 0 if printed else (xx >= 0) & (denominator > 0)
    divisor = np.where(usable, np.abs(denominator), 1)

    def quotient(products: Int64) -> tuple[Int64, NDArray[np.bool_]]:
        numerator = np.where(usable, np.sign(denominator) * products, 0)
        if divider == "table":
            # without a maximum the mantissas' signs let a denominator be twice as large
            return divide_by_table(numerator, divisor, 2 * (mantissa_bits + printed), limit)
        return divide(numerator, divisor, limit), reaches(numerator, divisor, limit)

    dx, beyond_x = quotient(yy * (xy if printed else x) + xy * y)
    dy, beyond_y = quotient(xx * y + xy * x)
    return Offset(dx, dy, beyond_x | beyond_y, ~usable)


Solve = Callable[[Derivatives[Int64]], Offset]

DISAGREEMENT = 16
"""Twice what a second step may be long, in 1/128 pixel, beside the length of the first."""


def gradient_steps(surface: Offset, pixels: Image, solve: Solve) -> Offset:
    """Two gradient steps: from the surface's peak, and from where the first one leads.

    A step halves the way to the corner at least, unless edges are wider than the window, or other
    corners are in it. A step fails where its equations have no solution within their limit, or the
    corner is as far from its pixel as :attr:`SubpixelFit.limit` or farther. With s the larger part,
    along x or y, of a step's way, the steps are trusted if neither fails and

        2·s(second) <= s(first) + DISAGREEMENT

    Elsewhere the corner is flagged ``clamped``, and is the surface's peak: a window with several
    corners in it misleads steps more. But if the first step has not failed and s(first) is half a
    pixel or more, it is where that leads: a surface says nothing about what is so far away.

    Parameters
    ----------
    surface
        Peak of the surface; where that has none, the corner's pixel. No more than half a pixel of
        it counts.
    pixels
        (..., 15, 15) around each corner.
    solve
        Solution of normal equations, within the limit of a step.
    """
    surface = replace(surface, dx=np.clip(surface.dx, -HALF, HALF), dy=np.clip(surface.dy, -HALF, HALF))
    first, first_fails = _gradient_step(surface, pixels, solve)
    second, second_fails = _gradient_step(first, pixels, solve)
    way = _apart(surface, first)
    trusted = ~first_fails & ~second_fails & (2 * _apart(first, second) <= way + DISAGREEMENT)
    leads = ~first_fails & (way >= HALF)

    def chosen(steps: list[Int64], otherwise: Int64) -> Int64:
        return np.select([trusted, leads], steps, otherwise)

    return Offset(
        dx=chosen([second.dx, first.dx], surface.dx),
        dy=chosen([second.dy, first.dy], surface.dy),
        clamped=~trusted & (leads | ~surface.not_maximum),
        not_maximum=~trusted & ~leads & surface.not_maximum,
    )


def _gradient_step(start: Offset, pixels: Image, solve: Solve) -> tuple[Offset, NDArray[np.bool_]]:
    """Where a step from there leads, relative to the corner's pixel, and whether it fails."""
    x, y = (normal_equations.window_place(offset) for offset in (start.dx, start.dy))
    found = solve(normal_equations.normal_equations(pixels, x, y))
    dx = (normal_equations.centre(x) << OFFSET_BITS) + found.dx
    dy = (normal_equations.centre(y) << OFFSET_BITS) + found.dy
    far = np.maximum(np.abs(dx), np.abs(dy)) >= FITS["gradient"].limit
    return replace(found, dx=dx, dy=dy), found.clamped | found.not_maximum | far


def _apart(one: Offset, other: Offset) -> Int64:
    return np.maximum(np.abs(one.dx - other.dx), np.abs(one.dy - other.dy))


def subpixel(responses: IntArray, parameters: Parameters, pixels: Image | None = None) -> Offset:
    """Offset of corners, by the fit of ``parameters``.

    Parameters
    ----------
    responses
        (..., 3, 3) around each corner; a surface is fitted to these.
    pixels
        (..., 15, 15) around each corner, as they came; only ``fit="gradient"`` reads them.

    Raises
    ------
    ValueError
        There are no pixels where they are needed.
    """
    fit = FITS[parameters.algorithm.fit]

    def solve(values: Derivatives[Int64]) -> Offset:
        bits, divider = derivative_bits(parameters), parameters.algorithm.divider
        return peak(values, bits, fit.mantissa_bits, fit.limit, divider=divider, printed=fit.printed)

    surface = solve(fit.derivatives(responses))
    if not fit.by_pixels:
        return surface
    if pixels is None:
        raise ValueError('fit is "gradient", which needs pixels; allowed: (..., 15, 15) around each corner')
    return gradient_steps(surface, pixels, solve)
