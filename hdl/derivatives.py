"""Formats of the five numbers from which a candidate's offset is found; see ``golden.derivatives``."""

from __future__ import annotations

from typing import NamedTuple

from amaranth.hdl import signed
from amaranth.lib import data

from golden import normal_equations
from golden.algorithm import Fit
from golden.derivatives import Derivatives
from golden.parameters import Parameters


class Format(NamedTuple):
    """How hardware holds a derivative of a surface: without ``zeros`` low bits, the rest at most
    ``largest`` full responses. Of the gradient step: at most ``largest`` full products.
    """

    zeros: int
    largest: int


_SUM = Format(0, normal_equations.STEP_SIZE**2)
_MOMENT = Format(0, normal_equations.LARGEST)
FORMATS: dict[Fit, Derivatives[Format]] = {
    "nine": Derivatives(Format(2, 6), Format(2, 6), Format(0, 6), Format(1, 3), Format(1, 3)),
    "six": Derivatives(Format(1, 5), Format(1, 2), Format(0, 2), Format(0, 1), Format(0, 2)),
    "gradient": Derivatives(_SUM, _SUM, _SUM, _MOMENT, _MOMENT),
}
"""Of golden.subpixel.derivatives and golden.normal_equations."""


def derivatives_layout(parameters: Parameters) -> data.StructLayout:
    """``golden.derivatives.Derivatives``, each signed and without the low bits that are always
    zero.
    """
    if parameters.algorithm.fit not in FORMATS:
        raise ValueError(f"fit is {parameters.algorithm.fit!r}; allowed in hardware: {', '.join(FORMATS)}")
    unit = parameters.product_max if parameters.algorithm.fit == "gradient" else parameters.response_max
    formats = FORMATS[parameters.algorithm.fit]._asdict()
    return data.StructLayout(
        {name: signed((form.largest * unit).bit_length() + 1) for name, form in formats.items()}
    )
