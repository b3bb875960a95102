"""Corner response (Eq. 2), by the response function that ``Algorithm.response`` names."""

from __future__ import annotations

from golden.parameters import Parameters
from golden.preprocessing import IntArray
from golden.responses import response_function


def response(a: IntArray, b: IntArray, c: IntArray, parameters: Parameters) -> IntArray:
    """D of the smoothed tensor [A C; C B], from 0 to ``parameters.response_max``."""
    function = response_function(parameters.algorithm.response)
    return function.response(a, b, c, parameters.pixel_bits)
