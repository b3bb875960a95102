"""Adaptation to the frame before: the D that a wanted number of its corners exceed.

With a target, this D is the next frame's T1; with a rank, it is Dref, of which T1 is a fraction.

All corners that the texture filter accepts, however small their D is, are counted in a histogram of
D. Its bins are those of a floating-point number: four to the octave, twice as wide in each octave
as in the one below; and below the lowest octave, four more of the same width. The threshold is read
from it: the bins are added up from the largest D downwards to the one in which the wanted number is
exceeded. The place within that bin is found to 1/32 of its width, as if its corners lay evenly.

The histogram does not depend on T1, so there is no control loop that could oscillate: the result is
a function of the last complete frame and the wanted number alone. If the next frame has the same
corners, it misses a target by no more corners than are in that bin. With ``Settings.smoothing``,
the result follows the frames slowly.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.formats import BUDGET_BITS
from golden.parameters import Parameters
from golden.preprocessing import IntArray

BINS_PER_OCTAVE = 4
MAX_OCTAVES = 11
"""Most octaves with bins of their own."""
STEPS = 5
"""Bits of the place within a bin: 1/32 of its width."""
COUNT_MAX = (1 << BUDGET_BITS) - 1
"""Largest count of a bin; no target is larger."""


def octaves(parameters: Parameters) -> int:
    """Number of octaves of D below full scale that have bins of their own.

    The smallest bin is 8 wide. With signed gradients of 8-bit pixels it is 16 wide, and twice as
    wide with each further bit of D.
    """
    return min(MAX_OCTAVES, parameters.response_bits - 5)


def bins(parameters: Parameters) -> int:
    """Number of bins: four for each octave, and four for all that is smaller."""
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
    """The D that about ``target`` corners exceed; 0 if there are no more corners than that.

    ``need`` is the number of corners that the current bin has to supply; in the bin where the
    descent ends it is smaller than the count. need / count is then found bit by bit, as in a
    divider.
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
    """1/2**smoothing of the way from the previous value to the adapted one, rounded down."""
    return previous + ((adapted - previous) >> smoothing)
