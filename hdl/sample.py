"""What goes from block to block at each place of a frame."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Value, unsigned
from amaranth.lib import data

from golden.parameters import Parameters
from golden.subpixel import FITS
from hdl.parts.optional import optional


def response_layout(parameters: Parameters) -> data.StructLayout:
    """A response alone: D, or S behind the response filter."""
    return data.StructLayout({"response": unsigned(parameters.response_bits)})


def sample_layout(parameters: Parameters) -> data.StructLayout:
    """D, and what rides along with it: the pixel at its centre, where the fit reads pixels."""
    by_pixels = FITS[parameters.algorithm.fit].by_pixels
    riders = optional(by_pixels, pixel=unsigned(parameters.pixel_bits))
    return data.StructLayout({"response": unsigned(parameters.response_bits), **riders})


def responses(column: Any) -> list[Value]:
    """The responses of a ``Columns`` of samples or of responses, from the top."""
    return [sample.response for sample in column.data]
