"""Grey numbers of any depth as pixels of the detector's."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Numbers = NDArray[Any]
Pixels = NDArray[np.unsignedinteger[Any]]


def fitted(grey: Numbers, bits: int, pixel_bits: int, remarks: list[str], hint: str = "") -> Pixels:
    """Pixels of ``pixel_bits`` from unsigned numbers of ``bits``: their upper bits, or shifted up.

    Where the uppermost bits are never set, as in the 16-bit files of 12-bit cameras, the remark
    says so: the pixels are darker than they could be, and ``hint`` may name a remedy.
    """
    dtype = np.uint8 if pixel_bits <= 8 else np.uint16
    if bits > pixel_bits:
        largest = int(grey.max())
        empty = min(bits - largest.bit_length(), pixel_bits)
        told = f", {empty} of them empty: the largest number is {largest}" if empty else ""
        remarks.append(f"{bits}-bit grey: the upper {pixel_bits} bits are used{told}{hint}")
        return (grey >> (bits - pixel_bits)).astype(dtype)
    if bits < pixel_bits:
        remarks.append(f"{bits}-bit grey: shifted up by {_counted(pixel_bits - bits)}")
    return np.left_shift(grey.astype(dtype), pixel_bits - bits)


def _counted(bits: int) -> str:
    return f"{bits} bit" + ("s" if bits > 1 else "")


def normalized(grey: Numbers, pixel_bits: int, remarks: list[str]) -> Pixels:
    """The range of the numbers stretched to all of ``pixel_bits``.

    ``ValueError`` if that is not possible.
    """
    low, high = grey.min().item(), grey.max().item()
    span = high - low
    if not np.isfinite(span):
        raise ValueError("its pixels are not all finite numbers of a finite range")
    if span == 0:
        raise ValueError(f"all its pixels are {low}")
    white = (1 << pixel_bits) - 1
    form = ".7g" if grey.dtype.kind == "f" else "d"
    remarks.append(f"normalized: {low:{form}} to {high:{form}} become 0 to {white}")
    pixels = np.rint((grey.astype(np.float64) - low) * white / span)
    return pixels.astype(np.uint8 if pixel_bits <= 8 else np.uint16)


def eight_bits(pixels: Pixels, pixel_bits: int) -> NDArray[np.uint8]:
    """Pixels as they are shown: all ones become white."""
    white = (1 << pixel_bits) - 1
    return (
        pixels.astype(np.uint8)
        if pixel_bits == 8
        else (pixels.astype(np.uint32) * 255 // white).astype(np.uint8)
    )
