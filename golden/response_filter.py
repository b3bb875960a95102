"""Response filter: D is smoothed once more, so that its peaks stay where they are.

Squares of differences have finer detail than the pixels can carry: which of two neighbouring
responses is the larger one often depends on noise, or on how the image lies in the grid of pixels.
A small binomial kernel removes this detail, and merges the peaks that D may have on either side of
a saddle.
"""

from __future__ import annotations

from collections.abc import Callable

from golden.algorithm import ResponseFilter
from golden.preprocessing import IntArray


def response_filter(responses: IntArray) -> IntArray:
    """S from D: (height, width) in, (height-2, width-2) out.

    S is the mean over 3x3 responses with weights [1 2 1]ᵀ[1 2 1], rounded to nearest, halves up; it
    has no more bits than D.
    """
    down = responses[:-2] + 2 * responses[1:-1] + responses[2:]
    return (down[:, :-2] + 2 * down[:, 1:-1] + down[:, 2:] + 8) >> 4


RESPONSE_FILTERS: dict[ResponseFilter, Callable[[IntArray], IntArray]] = {
    "none": lambda responses: responses,
    "binomial": response_filter,
}
"""Each takes ``RESPONSE_FILTER_REACH`` places away at each edge."""
