"""What goes from block to block at each place of a frame, or in each beat of several places."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import ShapeLike, Value, unsigned
from amaranth.lib import data

from golden.parameters import Parameters
from hdl.build import Build
from hdl.parts.lanes import lanes_of


def pixels_shape(build: Build) -> ShapeLike:
    """The pixels of a beat: unsigned(pixel_bits), or an array of them, the leftmost first."""
    return lanes_of(unsigned(build.pixel_bits), build.pixels_per_clock)


def responses_shape(build: Build) -> ShapeLike:
    """The responses of a beat: ``response_layout(build)``, or an array, the leftmost first."""
    return lanes_of(response_layout(build), build.pixels_per_clock)


def response_layout(parameters: Parameters) -> data.StructLayout:
    """A response: D, or S behind the response filter."""
    return data.StructLayout({"response": unsigned(parameters.response_bits)})


def responses(column: Any) -> list[Value]:
    """The responses of a ``Columns``, from the top."""
    return [sample.response for sample in column.data]
