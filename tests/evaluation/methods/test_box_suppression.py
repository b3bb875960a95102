"""Boxes of 4x4 pixels that overlap by more than a tenth of their union suppress each other."""

from __future__ import annotations

import numpy as np
import pytest

from evaluation.methods.box_suppression import suppressed


@pytest.mark.parametrize(
    ("dx", "dy", "kept"),
    [
        # shared / union: 4/28, 3/29 and 2/30 for boxes that touch in one, 3 and 2 corners' pixels
        (3, 0, False),
        (4, 0, True),
        (2, 2, False),
        (3, 1, False),
        (3, 2, True),
        (-3, 3, True),
        (0, -3.3, True),
        (0, -3.2, False),
    ],
)
def test_neighbours(dx: float, dy: float, kept: bool) -> None:
    points = np.array([(20.0, 20.0), (20 + dx, 20 + dy)])
    assert len(suppressed(points, 9)) == 1 + kept


def test_the_strongest_come_first_and_what_is_suppressed_suppresses_nothing() -> None:
    points = np.array([(10, 10), (12, 10), (14, 10), (16, 10), (30, 30)], np.float64)
    assert suppressed(points, 9).tolist() == points[[0, 2, 4]].tolist()
    assert suppressed(points, 2).tolist() == points[[0, 2]].tolist()
    assert suppressed(points[:0], 2).shape == (0, 2)
