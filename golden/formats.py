"""Geometry and number formats that every detector has: written here and nowhere else."""

from __future__ import annotations

SMOOTHING_SIZE = 5
"""Side of the smoothing kernel (Eq. 1)."""
WINDOW_SIZE = 9
"""Side of the response window that the texture filter reads."""

OFFSET_BITS = 7
"""Fractional bits of a corner's position: one unit is 1/128 pixel."""
COORDINATE_BITS = 20
"""Bits of x and of y in a record; OFFSET_BITS of them are fractional."""
SIGMA_BITS = 16
"""Fractional bits of sigma1 and sigma2."""
SIGMA2_INTEGER_BITS = 4
"""Bits of sigma2 before the point: it is below 16.

tau cannot exceed 8 times the frame's largest D; with that as Dref, 8 would be enough.
"""
MEAN_WEIGHT_BITS, MEAN_WEIGHT_FRACTION_BITS = 4, 3
"""sigma2 where the texture filter is an adaptive threshold: 0 to 15 eighths."""
MAX_SUPPRESSION = WINDOW_SIZE // 2
"""Largest radius of the non-maximum suppression: the whole response window."""
BUDGET_BITS = 16
"""Width of ``Settings.max_corners``, ``target_corners`` and ``reference_rank``."""
SMOOTHING_BITS = 2
"""Width of ``Settings.smoothing``."""
BUDGET_SETTINGS = {
    **dict.fromkeys(("max_corners", "target_corners", "reference_rank"), BUDGET_BITS),
    "smoothing": SMOOTHING_BITS,
}
"""Fields of ``Settings`` that only a detector built with ``budget`` has, and their widths.

0 switches each of them off.
"""
MIN_CELL, MAX_CELL = 8, 128
"""Sides of a cell in pixels, ``Settings.cell_width`` and ``cell_height``."""
MAX_PER_CELL = 16
"""Most corners of a cell that any detector chooses."""
CELL_SETTINGS = {
    **dict.fromkeys(("cell_width", "cell_height"), MAX_CELL.bit_length()),
    "per_cell": MAX_PER_CELL.bit_length(),
}
"""Fields of ``Settings`` that only a detector built with ``max_per_cell`` has, and their widths."""
MAX_SIDE = 1 << (COORDINATE_BITS - OFFSET_BITS)
"""Largest width and height of a frame: positions fit a record."""
MIN_PIXEL_BITS, MAX_PIXEL_BITS = 4, 10
