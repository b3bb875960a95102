"""Adaptation to the frame before: the D that a wanted number of its corners exceed.

With a target that is the next frame's T1; with a rank it is Dref, of which T1 is a fraction.

All corners of a frame that the texture filter keeps, however small their D, are counted into a
histogram of D. Its bins are those of a floating-point number: four to the octave, twice as wide
from octave to octave; below the lowest octave four more of that one's width. The threshold is read
off it: from the largest D downwards the bins are added up to the one in which the number is
exceeded, and within that, as if its corners lay evenly, to 1/32 of its width.

The histogram does not depend on T1, so there is no loop that could swing: what comes out is a
function of the last complete frame and the number alone. If the next frame has the same corners, it
misses a target by no more than are in that bin. ``Settings.smoothing`` averages over frames: then
it follows slowly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.formats import BUDGET_BITS
from golden.parameters import Parameters
from golden.preprocessing import IntArray

BINS_PER_OCTAVE = 4
MAX_OCTAVES = 11
STEPS = 5
"""Bits of the place within a bin."""
COUNT_MAX = (1 << BUDGET_BITS) - 1
"""Where the count in a bin stops, as no target is larger."""


def octaves(parameters: Parameters) -> int:
    """Octaves of D below full scale that have bins of their own.

    The smallest bin is 8 wide; 16 with signed gradients of 8-bit pixels, twice as much with each
    bit of D more.
    """
    return min(MAX_OCTAVES, parameters.response_bits - 5)


def bins(parameters: Parameters) -> int:
    """Of the histogram: four of each octave, and four for all that is smaller."""
    return BINS_PER_OCTAVE * (octaves(parameters) + 1)


def bin_edges(parameters: Parameters) -> list[int]:
    """Smallest D of each bin, in ascending order; then the end of the last, 2**response_bits."""
    smallest = 1 << (parameters.response_bits - octaves(parameters) - 2)
    mantissas = range(BINS_PER_OCTAVE)
    edges = [mantissa * smallest for mantissa in mantissas]
    for octave in range(octaves(parameters)):
        edges += [((BINS_PER_OCTAVE + mantissa) << octave) * smallest for mantissa in mantissas]
    return [*edges, 1 << parameters.response_bits]


def histogram(responses: IntArray, parameters: Parameters) -> NDArray[np.int64]:
    """Count of the responses (n,) in each bin, at most COUNT_MAX."""
    places = np.searchsorted(bin_edges(parameters), responses, side="right") - 1
    return np.minimum(np.bincount(places, minlength=bins(parameters)), COUNT_MAX).astype(np.int64)


def adapted_threshold(counts: NDArray[np.int64], target: int, parameters: Parameters) -> int:
    """The D that about ``target`` corners exceed; 0 if there are no more than that.

    need is how many are wanted of the bin that is looked at, and is smaller than its count in the
    one where the descent ends. How much of that is wanted is found as a divider finds its bits.
    """
    edges = bin_edges(parameters)
    need = target
    for k in reversed(range(len(counts))):
        count = int(counts[k])
        if need < count:
            edge, width = edges[k + 1], edges[k + 1] - edges[k]
            for _ in range(STEPS):
                need, width = 2 * need, width // 2
                if need >= count:
                    need, edge = need - count, edge - width
            return edge - 1
        need -= count
    return 0


def smoothed(previous: int, adapted: int, smoothing: int) -> int:
    """What is used of ``adapted``: 1/2**smoothing of the way there, rounded down."""
    return previous + ((adapted - previous) >> smoothing)
