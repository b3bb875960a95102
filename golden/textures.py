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


def _none(peaks: IntArray, windows: IntArray, limits: Thresholds, patches: Patches) -> Judgement:
    return np.ones(len(peaks), np.bool_), peaks


class TextureTest(NamedTuple):
    """A texture filter as a frame uses it."""

    judge: Callable[[IntArray, IntArray, Thresholds, Patches], Judgement]
    """From peaks (n,), windows (n, size, size) of D, thresholds and the kind of patches.

    The size is ``Algorithm.window_size``.
    """
    by_reference: bool
    """Is T2 a fraction of Dref?"""


TEXTURES: dict[Texture, TextureTest] = {
    "patches": TextureTest(_patches, by_reference=True),
    "mean": TextureTest(_mean, by_reference=False),
    "none": TextureTest(_none, by_reference=False),
}
