"""Subpixel refinement (Sec. 3.4): the peak of a quadratic surface fitted to the 3x3 responses, or a
gradient step.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from golden import normal_equations
from golden.algorithm import Fit
from golden.derivatives import Derivatives
from golden.divider import HALF, divide, reaches
from golden.formats import OFFSET_BITS
from golden.parameters import Parameters
from golden.preprocessing import Image, IntArray

Int64 = NDArray[np.int64]


class Surface(NamedTuple):
    """f(x, y) = L0 x² + L1 y² + L2 xy + L3 x + L4 y + L5 (Eq. 10), times a positive whole scale.

    L5 does not move the peak and is left out.
    """

    l0: Int64
    l1: Int64
    l2: Int64
    l3: Int64
    l4: Int64


MANTISSA_BITS = 10
"""Bits of a surface's curvatures and slopes, beside their sign, that go into the products of Eq.
13.
"""
STEP_MANTISSA_BITS = 12
"""Those of the gradient step, whose two equations are closer to each other where an edge is much
the stronger.
"""


@dataclass(frozen=True)
class Offset:
    """Corner relative to the centre pixel: dx, dy in 1/128 pixel within ±:func:`offset_limit`, and
    what became of it.

    clamped: it lies the limit away or more, along x or y. not_maximum: the surface has no peak, or
    all gradients are parallel.
    """

    dx: Int64
    dy: Int64
    clamped: NDArray[np.bool_]
    not_maximum: NDArray[np.bool_]


def fit_nine(s: IntArray) -> Surface:
    """Least squares over the nine samples (..., 3, 3), times 12. Sums only: x, y are -1, 0, 1 on
    the grid.
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
    """The one surface through the paper's six samples, times 2: the inverse of the true design
    matrix.
    """
    s0, s3, s5, s7, s2, s6 = _six_samples(s)
    return Surface(
        l0=s0 - s2 - 2 * s3 + 2 * s5 + 2 * s6 - 2 * s7,
        l1=s0 - 2 * s3 + s6,
        l2=s0 - s2 - s3 + s5,
        l3=s5 - s3,
        l4=s6 - s2 - s3 + s5,
    )


def fit_printed(s: IntArray) -> Surface:
    """L = (Vx · Vy) S with the two ``vander`` matrices of Eqs. 11 and 12, times 6: rank 3, no fit
    at all.
    """
    x, y = np.array([-1, -1, 1, 0, 1, -1]), np.array([-1, 0, 0, 1, -1, 1])
    weights = np.vander(x) @ np.vander(y)
    samples = np.stack(_six_samples(s), axis=-1)
    return Surface(*(samples @ weights[k] for k in range(5)))


FITS: dict[Fit, Callable[[IntArray], Surface]] = {
    "nine": fit_nine,
    "six": fit_six,
    "printed": fit_printed,
}


def offset_limit(fit: Fit) -> int:
    """Largest offset along an axis, in 1/128 pixel.

    A surface through 3x3 responses means nothing beyond half a pixel. A corner of the gradient step
    may lie anywhere in its window and, where it is at its edge, a little outside.
    """
    return 4 << OFFSET_BITS if fit == "gradient" else HALF


def mantissa_bits(fit: Fit) -> int:
    """Bits of the five values, beside their sign, that go into the products of Eq. 13."""
    return STEP_MANTISSA_BITS if fit == "gradient" else MANTISSA_BITS


def derivative_bits(parameters: Parameters) -> int:
    """Width of the largest derivative that the fit can give, without its sign."""
    if parameters.algorithm.fit == "gradient":
        return normal_equations.largest(parameters).bit_length()
    # each is a weighted sum of the samples: it is largest where only those with weights of one sign
    # are not zero
    units = np.eye(9, dtype=np.int64).reshape(9, 3, 3)
    weights = np.stack(derivatives(FITS[parameters.algorithm.fit](units)))
    largest = np.maximum(np.maximum(weights, 0).sum(-1), np.maximum(-weights, 0).sum(-1)).max()
    return (int(largest) * parameters.response_max).bit_length()


def derivatives(surface: Surface) -> Derivatives[Int64]:
    """Derivatives at the centre pixel, in units of the surface's scale."""
    return Derivatives(-2 * surface.l0, -2 * surface.l1, surface.l2, surface.l3, surface.l4)


def mantissas(values: Derivatives[Int64], bits: int, kept: int = MANTISSA_BITS) -> Derivatives[Int64]:
    """The five values as block floating point: ``kept`` bits and a sign each, all with one
    exponent.

    The peak depends on ratios only. So all are shifted up until the largest, of ``bits`` bits at
    most, is at the top, or until nothing would be lost, and cut (rounded down).
    """
    low = max(bits - kept, 0)
    largest = np.maximum.reduce([np.where(value < 0, ~value, value) for value in values])
    shift = np.minimum(bits - bit_length(largest), low)
    return Derivatives(*((value << shift) >> low for value in values))


def bit_length(values: Int64) -> Int64:
    """Number of bits of integers from 0 to 2**53."""
    return np.frexp(values.astype(np.float64))[1].astype(np.int64)


def peak(
    values: Derivatives[Int64],
    bits: int,
    *,
    printed: bool = False,
    limit: int = HALF,
    kept: int = MANTISSA_BITS,
) -> Offset:
    """Stationary point of the surface (Eq. 13), kept only where it is a maximum, and within
    ``limit``.

        dx = (2 L1 L3 - L2 L4) / (L2² - 4 L0 L1) = (yy·x + xy·y) / (xx·yy - xy²)
        dy = (2 L0 L4 - L2 L3) / (L2² - 4 L0 L1) = (xx·y + xy·x) / (xx·yy - xy²)

    Where a curvature or the denominator has the wrong sign the offset is (0, 0); beyond the limit,
    in 1/128 pixel, it is clamped, each axis for itself. ``bits`` is the width of the largest value
    (:func:`derivative_bits`), ``kept`` that of the factors (:func:`mantissa_bits`).

    ``printed`` keeps the misprint 2 L1 L2 in the first numerator, and, as the paper, does not ask
    for a maximum: Eqs. 11 and 12 turn nearly every corner into a surface without one. It is clamped
    all the same.
    """
    xx, yy, xy, x, y = mantissas(values, bits, kept)
    denominator = xx * yy - xy * xy
    usable = denominator != 0 if printed else (xx >= 0) & (denominator > 0)
    divisor = np.where(usable, np.abs(denominator), 1)

    def quotient(products: Int64) -> tuple[Int64, NDArray[np.bool_]]:
        numerator = np.where(usable, np.sign(denominator) * products, 0)
        return divide(numerator, divisor, limit), reaches(numerator, divisor, limit)

    dx, beyond_x = quotient(yy * (xy if printed else x) + xy * y)
    dy, beyond_y = quotient(xx * y + xy * x)
    return Offset(dx, dy, beyond_x | beyond_y, ~usable)


def subpixel(patches: IntArray, parameters: Parameters, pixels: Image | None = None) -> Offset:
    """Offset of the corners around which (..., 3, 3) responses are given, by the fit of
    ``parameters``.

    ``pixels``, (..., 9, 9) around the same places, are what ``fit="gradient"`` goes by, and only
    that.
    """
    if parameters.algorithm.fit == "gradient":
        if pixels is None:
            raise ValueError('fit is "gradient", which needs pixels; allowed: (..., 9, 9) around each corner')
        values = normal_equations.normal_equations(pixels)
    else:
        values = derivatives(FITS[parameters.algorithm.fit](patches))
    return peak(
        values,
        derivative_bits(parameters),
        printed=parameters.algorithm.fit == "printed",
        limit=offset_limit(parameters.algorithm.fit),
        kept=mantissa_bits(parameters.algorithm.fit),
    )
