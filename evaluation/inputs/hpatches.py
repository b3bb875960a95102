"""Pairs as SuperPoint's authors and its best known repository compare detectors on HPatches.

Every image is resized to 320x240 and made grey, and its homography follows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from evaluation.inputs.packages import opencv
from evaluation.inputs.sources import Image, Pair

SIZE = (320, 240)
"""Width and height."""
ILLUMINATION, VIEWPOINT = "illumination", "viewpoint"
SEQUENCES = {"i": ILLUMINATION, "v": VIEWPOINT}
"""What changes in a sequence, by the first letter of its folder: ``i_NAME``, ``v_NAME``."""
IMAGES = 6
"""Images of a sequence, ``1.ppm`` to ``6.ppm``; ``H_1_2`` to ``H_1_6`` lead from the first to the
others.
"""


def prepared(pairs: list[Pair]) -> list[Pair]:
    """The same pairs at 320x240: shrunk so that they just cover this, and cut about the middle.

    Interpolation is linear between the four nearest pixels, also where an image is shrunk by more
    than two: that is how the published figures were made. Pairs that share an image still do.
    """
    resized: dict[int, Image] = {}
    found = []
    for pair in pairs:
        assert pair.homography is not None, f"{pair.scene}, {pair.name} has no homography"
        first, second = (_to_size(image.shape) for image in (pair.first, pair.second))
        for image, to_size in ((pair.first, first), (pair.second, second)):
            if id(image) not in resized:
                resized[id(image)] = _resized(image, to_size)
        homography = second @ pair.homography @ np.linalg.inv(first)
        one, other = (resized[id(image)] for image in (pair.first, pair.second))
        found.append(replace(pair, first=one, second=other, homography=homography))
    return found


def _to_size(shape: tuple[int, ...]) -> NDArray[np.float64]:
    height, width = shape
    scale = max(SIZE[0] / width, SIZE[1] / height)
    # whole pixels are cut off
    left, top = (
        max(int(side * scale + 1e-6) - wanted, 0) // 2
        for side, wanted in zip((width, height), SIZE, strict=True)
    )
    return np.array([[scale, 0, -left], [0, scale, -top], [0, 0, 1]])


def _resized(image: Image, to_size: NDArray[np.float64]) -> Image:
    cv2 = opencv()
    border = cv2.BORDER_REPLICATE
    return np.asarray(
        cv2.warpAffine(image, to_size[:2], SIZE, flags=cv2.INTER_LINEAR, borderMode=border), np.uint8
    )
