"""Response filter: D smoothed once more, so that its peaks stay where they are.

Squares of differences have finer detail than the pixels can carry: which of two neighbouring
responses is the larger is often a matter of noise, or of how the image lies in the grid of pixels.
A small binomial kernel takes that away, and merges the peaks that D may have on either side of a
saddle.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from golden.algorithm import ResponseFilter
from golden.preprocessing import IntArray


def response_filter(responses: IntArray) -> IntArray:
    """S out of D: (height, width) in, (height-2, width-2) out.

    The mean over 3x3 with weights [1 2 1]ᵀ[1 2 1], rounded to nearest, halves up; no wider than D.
    """
    down = responses[:-2] + 2 * responses[1:-1] + responses[2:]
    return (down[:, :-2] + 2 * down[:, 1:-1] + down[:, 2:] + 8) >> 4


class ChosenFilter(NamedTuple):
    """A response filter: by how many pixels it makes each side shorter, and what it does."""

    reach: int
    apply: Callable[[IntArray], IntArray]


RESPONSE_FILTERS: dict[ResponseFilter, ChosenFilter] = {
    "none": ChosenFilter(0, lambda responses: responses),
    "binomial": ChosenFilter(1, response_filter),
}
