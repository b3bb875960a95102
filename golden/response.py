"""Corner response: which function it is, ``Algorithm.response`` says."""

from __future__ import annotations

from golden.parameters import Parameters
from golden.preprocessing import IntArray
from golden.responses import response_function


def response(a: IntArray, b: IntArray, c: IntArray, parameters: Parameters) -> IntArray:
    """D of the smoothed tensor [A C; C B], from 0 to ``parameters.response_max``."""
    function = response_function(parameters.algorithm.response)
    return function.response(a, b, c, parameters.pixel_bits)
