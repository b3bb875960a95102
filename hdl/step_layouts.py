"""What the parts of the gradient step hand to each other."""

from __future__ import annotations

from amaranth.hdl import signed
from amaranth.lib import data

from golden.divider import HALF
from golden.parameters import Parameters
from golden.subpixel import FITS
from hdl.build import Build

LIMIT = FITS["gradient"].limit
CENTRE_BITS = 3
"""Of the whole pixel in the middle of a window, -2 to 2 from the candidate's."""
STEP_BITS = 11
"""Of a place in 1/128 pixel: that pixel, and a step within the limit."""


def reads_pixels(parameters: Parameters) -> bool:
    """Does the fit take gradient steps?"""
    return FITS[parameters.algorithm.fit].by_pixels


def rows_kept(build: Build) -> int:
    """Rows of the pixel store, a power of two.

    When a row of pixels begins, windows are complete down to a margin above it, or with ``banked``
    buffers some rows more; and a candidate's pixels lie within a margin. The input may be a row
    ahead of the candidates, with several pixels per clock two rows, as these take fewer clocks.
    """
    ahead = 1 if build.pixels_per_clock == 1 else 2
    needed = 2 * build.algorithm.margin + ahead + build.rows_late
    return 1 << needed.bit_length()


def columns_read(build: Build) -> int:
    """Neighbouring columns of pixels that are read at once."""
    return min(build.pixels_per_clock, 4)


def steps_in_flight(build: Build) -> int:
    """Candidates that are worked on at a time.

    Some are solved while another one's window is read, and the faster windows are read, the more.
    """
    return 4 if build.pixels_per_clock == 1 else 8


def pixel_place_layout(build: Build) -> data.StructLayout:
    """Where in the pixel store a candidate lies.

    ``row``: the number of the row a margin above it, before which it needs none; ``x``: its column.
    """
    return data.StructLayout({"row": range(2 * rows_kept(build)), "x": range(build.max_width)})


def step_layout(build: Build) -> data.StructLayout:
    """A step that is to be taken.

    ``from_x``, ``from_y``: the place that it starts from; ``second``: it is not the candidate's
    first step; ``failed``, ``length``, of a second step: that the first one has, and how far it
    led.
    ``no_surface``: that the surface has no peak; ``surface_x``, ``surface_y``, of a second step:
    where it is. Places are in 1/128 pixel, relative to the candidate's pixel.
    """
    place, peak = signed(STEP_BITS), signed(HALF.bit_length() + 1)
    return data.StructLayout(
        {
            "candidate": pixel_place_layout(build),
            "from_x": place,
            "from_y": place,
            "surface_x": peak,
            "surface_y": peak,
            "no_surface": 1,
            "length": STEP_BITS,
            "failed": 1,
            "second": 1,
        }
    )


def under_way_layout(build: Build) -> data.StructLayout:
    """A step whose window is being read or whose equations are being solved, and its centre."""
    centre = signed(CENTRE_BITS)
    return data.StructLayout({"step": step_layout(build), "centre_x": centre, "centre_y": centre})
