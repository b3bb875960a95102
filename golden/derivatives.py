"""What a refinement step solves for the corner's offset: five numbers, wherever they come from."""

from __future__ import annotations

from typing import Generic, NamedTuple, TypeVar

T = TypeVar("T")


class Derivatives(NamedTuple, Generic[T]):
    """Coefficients of the two equations for the offset (dx, dy), up to one common positive factor:

        [ xx  -xy] [dx]   [x]
        [-xy   yy] [dy] = [y]

    Of a fitted surface: its second derivatives at the centre pixel, those along an axis negated,
    and its slopes: xx = -2 L0, yy = -2 L1, xy = L2, x = L3, y = L4. At a maximum xx and yy are
    positive. Of the gradient step: half of the squared distances' derivatives; see
    ``golden.normal_equations``.
    """

    xx: T
    yy: T
    xy: T
    x: T
    y: T
