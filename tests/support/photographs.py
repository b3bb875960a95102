"""The photographs that come with scikit-image, as the detector takes them."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray
from skimage import data

PHOTOGRAPHS = ("camera", "brick", "grass", "gravel", "coins", "text", "page", "moon", "cell", "clock")
"""All of these are grey, 8 bits, and part of scikit-image's own package: nothing is downloaded."""


@cache
def photograph(name: str) -> NDArray[np.uint8]:
    """One of ``PHOTOGRAPHS``: (height, width) uint8, not writable."""
    image = np.ascontiguousarray(getattr(data, name)())
    assert image.dtype == np.uint8 and image.ndim == 2
    image.flags.writeable = False
    return image
