"""The five numbers from which every subpixel step computes a corner's offset."""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeVar

T = TypeVar("T")


class Derivatives(NamedTuple, Generic[T]):
    """Coefficients of the two equations for the offset (dx, dy), up to one common positive factor:

        [ xx  -xy] [dx]   [x]
        [-xy   yy] [dy] = [y]

    For a fitted surface, they are its second derivatives at the centre pixel (those along an axis
    negated) and its slopes: xx = -2 L0, yy = -2 L1, xy = L2, x = L3, y = L4. At a maximum xx and yy
    are positive. For the gradient step, they are the sums of ``golden.normal_equations``, half of
    the derivatives of the squared distances.
    """

    xx: T
    yy: T
    xy: T
    x: T
    y: T
