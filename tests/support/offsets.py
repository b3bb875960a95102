"""Offsets in exact arithmetic, and how far the golden model's mantissas may be from them.

Mantissas are whole numbers: each stands for a value less than one above it, so that a Hessian H =
[[xx, -xy], [-xy, yy]] of mantissas is off by E with norm 2 at most, and slopes by e with norm
sqrt(2). With q the peak by H and p the exact one, H (q - p) = E p - e, and so |q - p| <= (sqrt(2) +
2 |p|) / l with l the smaller eigenvalue of H. Values of as many bits or less are not cut, and
exact. The quotient is rounded to 1/128; by the table of reciprocals it is up to 1/128 off.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from golden.algorithm import Divider
from golden.derivatives import Derivatives
from golden.formats import OFFSET_BITS
from golden.parameters import Parameters
from golden.preprocessing import IntArray
from golden.subpixel import FITS, derivative_bits, mantissas

DIVIDER_ERRORS: dict[Divider, float] = {"serial": 1 / 256, "table": 1 / 128}
"""Largest error of a quotient, in pixels."""

Float64 = NDArray[np.float64]
Int64 = NDArray[np.int64]


class Peaks(NamedTuple):
    """Offsets of candidates: (0, 0) without a maximum, otherwise clamped along each axis."""

    dx: Float64
    dy: Float64
    maximum: NDArray[np.bool_]


def exact_peaks(patches: IntArray, parameters: Parameters) -> Peaks:
    """By exact sums and float64 quotients, of (n, 3, 3) responses."""
    return exact_offsets(FITS[parameters.algorithm.fit].derivatives(patches), parameters)


def exact_offsets(values: Derivatives[Int64], parameters: Parameters) -> Peaks:
    """By float64 quotients."""
    limit = FITS[parameters.algorithm.fit].limit / (1 << OFFSET_BITS)
    x, y, maximum = _peaks(*values)
    return Peaks(np.clip(x, -limit, limit), np.clip(y, -limit, limit), maximum)


def bounds(patches: IntArray, parameters: Parameters) -> Float64:
    """Bound of the golden model's error along either axis; inf if no maximum is certain."""
    return offset_bounds(FITS[parameters.algorithm.fit].derivatives(patches), parameters)


def offset_bounds(values: Derivatives[Int64], parameters: Parameters) -> Float64:
    """The same of the five values themselves."""
    kept = FITS[parameters.algorithm.fit].mantissa_bits
    x, y, _ = _peaks(*values)
    cut = np.maximum.reduce([np.where(v < 0, ~v, v) for v in values]) >= 1 << kept
    mantissa = mantissas(values, derivative_bits(parameters), kept)
    _, _, maximum = _peaks(*mantissa)
    xx, yy, xy, *_ = (value.astype(np.float64) for value in mantissa)
    smaller = (xx + yy - np.hypot(xx - yy, 2 * xy)) / 2
    # the exact Hessian's eigenvalues are at most 2 from those of the mantissas
    sure = maximum & (smaller > 2 * cut)
    with np.errstate(divide="ignore", invalid="ignore"):
        by_cut = cut * (np.sqrt(2) + 2 * np.hypot(x, y)) / smaller
    return np.where(sure, by_cut + DIVIDER_ERRORS[parameters.algorithm.divider], np.inf)


def _peaks(
    xx: IntArray, yy: IntArray, xy: IntArray, x: IntArray, y: IntArray
) -> tuple[Float64, Float64, NDArray[np.bool_]]:
    """x and y of Eq. 13, and whether it is a maximum; x = y = 0 where it is none."""
    denominator = xx * yy - xy * xy
    maximum = (xx > 0) & (denominator > 0)
    divisor = np.where(maximum, denominator, 1)
    return (
        np.where(maximum, (yy * x + xy * y) / divisor, 0.0),
        np.where(maximum, (xx * y + xy * x) / divisor, 0.0),
        maximum,
    )
