"""The texture filters by name, and how each judges the candidates of a frame."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from golden.adaptive_threshold import adaptive_threshold
from golden.algorithm import Patches, Texture
from golden.preprocessing import IntArray
from golden.texture_filter import texture_filter
from golden.thresholds import Thresholds

Judgement = tuple[NDArray[np.bool_], IntArray]
"""(n,) each: True where the corner is accepted, and the response that is reported."""


def _patches(peaks: IntArray, windows: IntArray, limits: Thresholds, patches: Patches) -> Judgement:
    return texture_filter(windows, limits.t2, patches), peaks


def _mean(peaks: IntArray, windows: IntArray, limits: Thresholds, patches: Patches) -> Judgement:
    return adaptive_threshold(peaks, windows, limits.t1, limits.t2)


class TextureTest(NamedTuple):
    """A texture filter as a frame uses it."""

    judge: Callable[[IntArray, IntArray, Thresholds, Patches], Judgement]
    """From peaks (n,), windows (n, 9, 9) of D around them, thresholds and the kind of patches."""
    by_reference: bool
    """Is T2 a fraction of Dref?"""


TEXTURES: dict[Texture, TextureTest] = {
    "patches": TextureTest(_patches, by_reference=True),
    "mean": TextureTest(_mean, by_reference=False),
}
