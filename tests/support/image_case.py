"""What a test of an image file is: a file, and the pixels that are right for it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

_Y, _X = np.mgrid[:18, :20]
RAMP = (_Y * 1721 + _X * 1613).astype(np.uint16)
"""18 rows of 20 pixels, no two alike however they are turned; all of its 16 bits count."""
RAMP8 = (RAMP >> 8).astype(np.uint8)
COLOUR = np.dstack([RAMP, 65535 - RAMP[::-1], RAMP[:, ::-1]])
COLOUR8 = (COLOUR >> 8).astype(np.uint8)
ALPHA8 = np.where(_X < 10, 255, 0).astype(np.uint8)

USED, NORMALIZED, REFUSED = "yes", "N", "no"
"""As it is or by its upper bits; with --normalize only; never."""


@dataclass(frozen=True)
class Case:
    """One file.

    ``grey`` are the right numbers, upright and of ``bits``, within ``within``; ``make`` takes what
    the format's writer takes beyond the picture, such as ``orientation``.
    """

    format: str
    layout: str
    depth: str
    outcome: str
    make: Callable[..., bytes]
    grey: NDArray[Any] = field(default_factory=lambda: RAMP8)
    bits: int = 8
    within: int = 0
    remarks: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.format}-{self.layout}-{self.depth}".replace(" ", "_")


def levels(bits: int) -> NDArray[Any]:
    """The picture in fewer bits."""
    return RAMP >> (16 - bits)


def widened(narrow: NDArray[Any], bits: int) -> NDArray[Any]:
    """All ones become 255."""
    return (narrow.astype(np.uint16) * (255 // ((1 << bits) - 1))).astype(np.uint8)


def bt601(rgb: NDArray[Any]) -> NDArray[Any]:
    """Luma of 8-bit colour, rounded as by 16-bit weights."""
    weights = np.array([19595, 38470, 7471])
    return ((rgb.astype(np.uint32) @ weights + 32768) >> 16).astype(np.uint8)


def over_white(grey: NDArray[Any]) -> NDArray[Any]:
    """With the right half transparent."""
    return np.where(ALPHA8 == 0, 255, grey).astype(np.uint8)


def without(narrow: NDArray[Any], key: int, wide: NDArray[Any], white: int = 255) -> NDArray[Any]:
    """Pixels of one level become white."""
    return np.where(narrow == key, white, wide).astype(wide.dtype)


GREYED = ("BT.601",)
LOOKED_UP = ("palette looked up", *GREYED)
LAID = ("laid over white",)
"""Parts of remarks."""
DARKENING = bytes(np.dstack([np.arange(256)[::-1]] * 3).astype(np.uint8))
"""Greys, lightest first."""
