"""Rendered views: places of dots, which can be measured."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from evaluation.inputs.sources import NamedImage
from evaluation.inputs.views import VIEWS, View, rendered_pairs
from evaluation.sections.repeatability import project


def dotted() -> NDArray[np.uint8]:
    """Soft dots, 60 pixels apart."""
    y, x = np.mgrid[0:300, 0:400]
    image = np.full((300, 400), 40.0)
    for down in range(60, 300, 60):
        for across in range(60, 400, 60):
            image += 150 * np.exp(-((x - across - 0.3) ** 2 + (y - down) ** 2) / (2 * 4.0**2))
    return np.rint(image).astype(np.uint8)


def centroid(image: NDArray[np.uint8], near: NDArray[np.float64]) -> NDArray[np.float64]:
    """Centre of the bright dot around a point."""
    left, top = (np.rint(near) - 14).astype(int)
    part = image[top : top + 29, left : left + 29].astype(np.float64)
    part = np.maximum(part - np.median(part) - 12, 0)
    y, x = np.mgrid[0:29, 0:29]
    return np.array([(part * x).sum(), (part * y).sum()]) / part.sum() + (left, top)


@pytest.mark.parametrize("view", VIEWS, ids=lambda view: view.name)
def test_the_homography_says_where_things_went(view: View) -> None:
    (pair,) = rendered_pairs([NamedImage("dots", dotted(), "marks")], (view,))
    assert pair.homography is not None
    checked = 0
    for down in range(60, 300, 60):
        for across in range(60, 400, 60):
            # pixel centres are at whole numbers in the photograph and in the view, at 0.7 of the
            # size
            there = np.array([(across + 0.3 + 0.5) * 0.7 - 0.5, (down + 0.5) * 0.7 - 0.5])
            (expected,) = project(there[None], pair.homography)
            height, width = pair.second.shape
            if not (20 < expected[0] < width - 20 and 20 < expected[1] < height - 20):
                continue
            assert centroid(pair.first, there) == pytest.approx(there, abs=0.15)
            assert centroid(pair.second, expected) == pytest.approx(expected, abs=0.3)
            checked += 1
    assert checked >= 8


def test_light_blur_and_noise() -> None:
    (plain,) = rendered_pairs([NamedImage("dots", dotted(), "marks")], (View("same", noise=0),))
    (dark,) = rendered_pairs(
        [NamedImage("dots", dotted(), "marks")], (View("dark", gain=0.5, bias=10, noise=0),)
    )
    assert dark.second == pytest.approx(0.5 * plain.second.astype(float) + 10, abs=1)
    (noisy,) = rendered_pairs([NamedImage("dots", dotted(), "marks")], (View("noisy", noise=8),))
    assert np.std(noisy.second.astype(float) - plain.second) == pytest.approx(8, rel=0.05)
    (blurred,) = rendered_pairs([NamedImage("dots", dotted(), "marks")], (View("blurred", blur=3, noise=0),))
    assert blurred.second.max() < plain.second.max() - 20


def test_every_view_has_noise_of_its_own() -> None:
    image = NamedImage("grey", np.full((100, 100), 128, np.uint8), "flat")
    one, other = rendered_pairs([image], (View("one"), View("other")))
    assert not np.array_equal(one.first, one.second)
    assert not np.array_equal(one.second, other.second)
    (again, _) = rendered_pairs([image], (View("one"), View("other")))
    assert np.array_equal(one.second, again.second)
