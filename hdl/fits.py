"""Layouts of what is solved for a candidate's offset, by the fit."""

from __future__ import annotations

from amaranth.lib import data

from golden.parameters import Parameters
from hdl import normal_equations
from hdl.build import Build
from hdl.derivatives import Formats, layout
from hdl.step_layouts import pixel_place_layout, reads_pixels
from hdl.surface import SurfaceFit


def derivatives_layout(parameters: Parameters) -> data.StructLayout:
    """The five numbers as the surface fit delivers them; see :func:`hdl.derivatives.layout`."""
    return layout(SurfaceFit.formats(parameters), SurfaceFit.unit(parameters))


def candidate_layout(build: Build) -> data.StructLayout:
    """A candidate's surface and, where pixels are read, its place among them."""
    surface = derivatives_layout(build)
    if not reads_pixels(build):
        return surface
    return data.StructLayout({"surface": surface, "place": pixel_place_layout(build)})


def solved_formats(parameters: Parameters) -> Formats:
    """Formats of the numbers that are solved; those of a gradient step hold a surface's, too."""
    return normal_equations.FORMATS if reads_pixels(parameters) else SurfaceFit.formats(parameters)


def solved_layout(parameters: Parameters) -> data.StructLayout:
    """The five numbers as they are solved; see :func:`hdl.derivatives.layout`."""
    unit = parameters.product_max if reads_pixels(parameters) else SurfaceFit.unit(parameters)
    return layout(solved_formats(parameters), unit)
