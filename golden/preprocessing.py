"""Preprocessing (Sec. 3.1): gradients, and the products A, B, C of the structure tensor."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.algorithm import Derivative, Gradient

Image = NDArray[np.unsignedinteger[Any]]
"""(height, width) or windows (..., height, width), unsigned pixels."""
IntArray = NDArray[np.signedinteger[Any]]


def gradients(image: Image, derivative: Derivative = "central") -> tuple[IntArray, IntArray]:
    """Signed differences whose absolute values are the paper's gradients.

        gx = I(x-1, y) - I(x+1, y)        gy = I(x, y-1) - I(x, y+1)

    With ``"sobel"``, each is the mean of this difference and the two beside it, across its
    direction, with weights 1 2 1, rounded to nearest, halves away from zero. It is no larger than a
    pixel either, and mirrored images have mirrored gradients.

    (..., height, width) pixels in, two (..., height-2, width-2) int16 arrays out: the outermost
    pixels have no gradient.
    """
    return _DERIVATIVES[derivative](image.astype(np.int16))


def _central(pixels: IntArray) -> tuple[IntArray, IntArray]:
    gx = pixels[..., 1:-1, :-2] - pixels[..., 1:-1, 2:]
    gy = pixels[..., :-2, 1:-1] - pixels[..., 2:, 1:-1]
    return gx, gy


def _sobel(pixels: IntArray) -> tuple[IntArray, IntArray]:
    down = pixels[..., :-2, :] + 2 * pixels[..., 1:-1, :] + pixels[..., 2:, :]
    across = pixels[..., :, :-2] + 2 * pixels[..., :, 1:-1] + pixels[..., :, 2:]
    return _quarter(down[..., :, :-2] - down[..., :, 2:]), _quarter(across[..., :-2, :] - across[..., 2:, :])


def _quarter(sums: IntArray) -> IntArray:
    return (sums + 1 + (sums >= 0)) >> 2


_DERIVATIVES: dict[Derivative, Callable[[IntArray], tuple[IntArray, IntArray]]] = {
    "central": _central,
    "sobel": _sobel,
}


def products(gx: IntArray, gy: IntArray, gradient: Gradient) -> tuple[IntArray, IntArray, IntArray]:
    """A = gx², B = gy², C = gx·gy (``"signed"``) or |gx|·|gy| (``"absolute"``), int32."""
    gx32, gy32 = gx.astype(np.int32), gy.astype(np.int32)
    cross = gx32 * gy32
    if gradient == "absolute":
        np.abs(cross, out=cross)
    return gx32 * gx32, gy32 * gy32, cross
