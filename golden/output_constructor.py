"""Output construction (Sec. 3.5) and the one description of the 64-bit record.

======  ==========================================================================
bits    corner record
======  ==========================================================================
19:0    x, unsigned, 7 fractional bits (1/128 pixel), first pixel centre = 0
39:20   y, likewise
60:40   D, the corner response, unsigned (with 8-bit pixels 16 bits are used, or
        17 with signed gradients)
61      CLAMPED: the peak lay half a pixel away or more in x or y and was
        clamped. By ``fit="gradient"``: its steps cannot be trusted; this is
        the peak of the response, or where the first step leads
62      NOT_MAXIMUM: the fitted surface has no maximum and, by
        ``fit="gradient"``, its steps cannot be trusted; the offset is (0, 0)
63      TEXTURED: rejected by the texture filter (only if those are reported)
======  ==========================================================================

A corner is never CLAMPED and NOT_MAXIMUM at once, so both together flag the one end-of-frame record
that closes every frame, also a frame without corners:

======  ==========================================================================
bits    end-of-frame record
======  ==========================================================================
23:0    number of corner records in the frame (without those that cells or
        ``Settings.max_corners`` left out)
39:24   frame number since reset, modulo 65536
60:40   largest D of the pixels at which a corner may be: the next frame's
        reference
62:61   both are set
63      CUT: the frame was cut short. It then lacks corners, and bits 60:40 are 0.
        The detector by itself never cuts one; see ``golden.video``
======  ==========================================================================

Edges with registers can send one more record after it, as the last of a packet. With these flags
and D above 0 it is nothing else, and whoever reads a packet up to its end-of-frame record never
comes to it:

======  ==========================================================================
bits    time record
======  ==========================================================================
59:0    the clock in which the frame's first pixel was taken, counted from reset;
        the counter has 64 bits, of which the highest are 0 for 182 years at
        200 MHz
63:60   all are set
======  ==========================================================================
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from golden.checks import check_integer, is_whole
from golden.corners import Corners, Flag
from golden.formats import COORDINATE_BITS, OFFSET_BITS
from golden.preprocessing import IntArray
from golden.subpixel import Offset

Records = NDArray[np.uint64]

RECORD_BITS = 64
RESPONSE_SHIFT = 2 * COORDINATE_BITS
RESPONSE_FIELD_BITS = 21
FLAG_SHIFT = RESPONSE_SHIFT + RESPONSE_FIELD_BITS
COUNT_BITS = 24
NO_LIMIT = (1 << COUNT_BITS) - 1
"""``max_records`` that no frame reaches."""
FRAME_BITS = 16


END_OF_FRAME = Flag.CLAMPED | Flag.NOT_MAXIMUM
CUT_SHIFT = 63
TIME_BITS = 60
TIME_RECORD = 0b1111
"""The bits of a time record above its time."""


class FrameEnd(NamedTuple):
    """Fields of an end-of-frame record."""

    records: int
    frame: int
    maximum: int
    cut: bool = False


def encode(
    x: IntArray, y: IntArray, response: IntArray, offset: Offset, textured: NDArray[np.bool_]
) -> Records:
    """(n,) uint64 records of corners at whole pixels (x, y): X = x + dx, Y = y + dy (Eqs. 14-17).

    Eqs. 16 and 17 print the sum of x and Eq. 14, which has already added x; here it is added once.
    """
    x_fixed = (x.astype(np.int64) << OFFSET_BITS) + offset.dx
    y_fixed = (y.astype(np.int64) << OFFSET_BITS) + offset.dy
    flags = (
        offset.clamped * np.uint64(Flag.CLAMPED)
        | offset.not_maximum * np.uint64(Flag.NOT_MAXIMUM)
        | textured * np.uint64(Flag.TEXTURED)
    )
    return (
        x_fixed.astype(np.uint64)
        | (y_fixed.astype(np.uint64) << np.uint64(COORDINATE_BITS))
        | (response.astype(np.uint64) << np.uint64(RESPONSE_SHIFT))
        | (flags.astype(np.uint64) << np.uint64(FLAG_SHIFT))
    )


def encode_frame_end(end: FrameEnd) -> int:
    """The record that closes a frame."""
    frame = end.frame % (1 << FRAME_BITS)
    return (
        end.records
        | (frame << COUNT_BITS)
        | (end.maximum << RESPONSE_SHIFT)
        | (int(END_OF_FRAME) << FLAG_SHIFT)
        | (int(end.cut) << CUT_SHIFT)
    )


def encode_frame_time(clock: int) -> int:
    """The time record of a frame whose first pixel was taken in that clock."""
    return clock % (1 << TIME_BITS) | TIME_RECORD << TIME_BITS


def decode(words: Records) -> Corners:
    """Corners of an array of 64-bit records, (n,) uint64; all other records are left out.

    Anything else raises ``TypeError`` or ``ValueError``: other types do not hold the same 64 bits.
    """
    if not isinstance(words, np.ndarray):
        raise TypeError(f"records are a {type(words).__name__}; allowed: a NumPy array of uint64")
    if not np.issubdtype(words.dtype, np.uint64):
        raise TypeError(f"records have dtype {words.dtype}; allowed: uint64")
    if words.ndim != 1:
        raise ValueError(f"records have shape {words.shape}; allowed: (n,)")
    flags = (words >> np.uint64(FLAG_SHIFT)).astype(np.uint8)
    corners = (flags & END_OF_FRAME) != END_OF_FRAME
    words, flags = words[corners], flags[corners]

    def field(shift: int, bits: int) -> NDArray[np.int64]:
        return ((words >> np.uint64(shift)) & np.uint64((1 << bits) - 1)).astype(np.int64)

    return Corners(
        x=field(0, COORDINATE_BITS) / (1 << OFFSET_BITS),
        y=field(COORDINATE_BITS, COORDINATE_BITS) / (1 << OFFSET_BITS),
        response=field(RESPONSE_SHIFT, RESPONSE_FIELD_BITS),
        flags=flags,
    )


def decode_frame_end(word: int) -> FrameEnd:
    """Fields of one end-of-frame record.

    Raises
    ------
    TypeError
        The word is not a whole number.
    ValueError
        It has more than 64 bits, or is another record.
    """
    word = _record(word)
    if (word >> FLAG_SHIFT) & END_OF_FRAME != END_OF_FRAME or word >> TIME_BITS == TIME_RECORD:
        raise ValueError(
            f"record {word:#018x} is not an end-of-frame record "
            "(bits 62:61 must be 0b11, and bits 63:60 not 0b1111)"
        )
    return FrameEnd(
        records=word & ((1 << COUNT_BITS) - 1),
        frame=(word >> COUNT_BITS) & ((1 << FRAME_BITS) - 1),
        maximum=(word >> RESPONSE_SHIFT) & ((1 << RESPONSE_FIELD_BITS) - 1),
        cut=bool(word >> CUT_SHIFT),
    )


def decode_frame_time(word: int) -> int:
    """The clock in which a frame's first pixel was taken, modulo 2**60, from its time record.

    Raises
    ------
    TypeError
        The word is not a whole number.
    ValueError
        It has more than 64 bits, or is another record.
    """
    word = _record(word)
    if word >> TIME_BITS != TIME_RECORD:
        raise ValueError(f"record {word:#018x} is not a time record (bits 63:60 must be 0b1111)")
    return word & ((1 << TIME_BITS) - 1)


def _record(word: int) -> int:
    """The word as Python's ``int``, if it is one of 64 bits."""
    if not is_whole(word):
        raise TypeError(f"record is a {type(word).__name__}; allowed: a whole number")
    check_integer("record", word, 0, (1 << RECORD_BITS) - 1)
    return int(word)
