"""Cell selection: the strongest corners of each cell, for an even spread over the frame.

A grid of cells, ``Settings.cell_width`` by ``cell_height`` pixels, begins with the frame's first
pixel; the cells at its right and lower edge may be parts of one. A corner belongs to the cell of
the pixel at which its response is a maximum, wherever its refined position lies. Of each cell, the
``Settings.per_cell`` corners with the largest responses are reported; of equal responses, the first
ones in raster order. All others are surplus, and are counted.

The cells come in raster order, so a row of cells can be reported as soon as it is complete. In a
cell, the strongest corner comes first; equal ones come in raster order.

Corners have passed T1 and the texture filter before. So a small T1 asks for corners in dark cells,
too, and the cells keep bright ones from having too many: no cell needs a threshold of its own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from golden.preprocessing import IntArray
from golden.settings import Settings


def strongest(
    x: NDArray[np.int64], y: NDArray[np.int64], response: IntArray, settings: Settings
) -> NDArray[np.intp]:
    """Indices of the corners that the cells choose, in the order in which they are reported.

    ``x``, ``y`` and ``response``: (n,) pixels and responses of corners in raster order.
    """
    rows, columns = y // settings.cell_height, x // settings.cell_width
    # the sort is stable: what is equal stays in raster order
    order = np.lexsort((-response.astype(np.int64), columns, rows))
    first = np.ones(len(order), dtype=np.bool_)
    first[1:] = (np.diff(rows[order]) != 0) | (np.diff(columns[order]) != 0)
    place = np.arange(len(order))
    rank = place - np.maximum.accumulate(np.where(first, place, 0))
    return order[rank < settings.per_cell]


def last_row(y: NDArray[np.int64], settings: Settings) -> NDArray[np.int64]:
    """The last row of pixels that belongs to the same cells as row ``y``."""
    return (y // settings.cell_height + 1) * settings.cell_height - 1
