"""Frames as a detector takes them: beats of several pixels, the leftmost in the lowest bits."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from hdl.build import Build
from sim.stimulus import Words

_WORD_BITS = 64


def beat_count(size: tuple[int, ...], build: Build) -> int:
    """Beats of a frame of this (height, width): every row begins with a beat of its own."""
    height, width = size
    return height * -(-width // build.pixels_per_clock)


def beats(image: NDArray[Any], build: Build, random: np.random.Generator) -> Words:
    """The payloads of a frame, shape (n,) for up to 64 bits, otherwise (n, words).

    Parameters
    ----------
    image
        Pixels, shape (height, width), of at most ``build.pixel_bits``.
    random
        Makes the pixels of a row's last beat that lie beyond the width. They differ from row to
        row, so that a detector that uses them is noticed.
    """
    height, width = image.shape
    lanes = build.pixels_per_clock
    beyond = random.integers(build.pixel_max, size=(height, -width % lanes), endpoint=True)
    return _packed(np.hstack([image, beyond]).astype(np.uint64).reshape(-1, lanes), build.pixel_bits)


def _packed(pixels: Words, bits: int) -> Words:
    """Rows of pixels, each packed into one number without gaps."""
    lanes = pixels.shape[1]
    words = np.zeros((len(pixels), -(-lanes * bits // _WORD_BITS)), np.uint64)
    for lane in range(lanes):
        word, low = divmod(lane * bits, _WORD_BITS)
        words[:, word] |= pixels[:, lane] << np.uint64(low)
        if low + bits > _WORD_BITS:
            words[:, word + 1] |= pixels[:, lane] >> np.uint64(_WORD_BITS - low)
    return words[:, 0] if words.shape[1] == 1 else words
