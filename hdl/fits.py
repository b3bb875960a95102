"""Which block finds the equations for a candidate's offset, by the fit."""

from __future__ import annotations

from amaranth.lib import data

from golden.algorithm import Fit
from golden.parameters import Parameters
from hdl.derivatives import layout
from hdl.gradient_step import GradientStep
from hdl.surface import SurfaceFit

EquationsBlock = type[SurfaceFit] | type[GradientStep]

FITS: dict[Fit, EquationsBlock] = {"nine": SurfaceFit, "six": SurfaceFit, "gradient": GradientStep}
"""The block and ``golden.subpixel.FITS`` hold all else that depends on the fit."""


def equations_block(parameters: Parameters) -> EquationsBlock:
    """The block of this fit. Raises ``ValueError`` for one that only the golden model has."""
    fit = parameters.algorithm.fit
    if fit not in FITS:
        raise ValueError(f"fit is {fit!r}; allowed in hardware: {', '.join(FITS)}")
    return FITS[fit]


def derivatives_layout(parameters: Parameters) -> data.StructLayout:
    """The five numbers as this fit's block delivers them; see :func:`hdl.derivatives.layout`."""
    block = equations_block(parameters)
    return layout(block.formats(parameters), block.unit(parameters))
