"""Gradients and products, by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from golden.algorithm import Gradient
from golden.preprocessing import gradients, products


def test_vertical_step_has_gx_on_both_sides_of_the_edge() -> None:
    image = np.full((5, 8), 10, np.uint8)
    image[:, 4:] = 50
    gx, gy = gradients(image)
    # columns 1 to 6 of the image: the step lies between columns 3 and 4, I(x-1) - I(x+1) = 10 - 50
    assert gx.tolist() == [[0, 0, -40, -40, 0, 0]] * 3
    assert not gy.any()


def test_horizontal_step_has_gy_on_both_sides_of_the_edge() -> None:
    image = np.full((6, 5), 90, np.uint8)
    image[3:] = 20
    gx, gy = gradients(image)
    assert gy.tolist() == [[0] * 3, [70] * 3, [70] * 3, [0] * 3]
    assert not gx.any()


def test_ramp_has_the_same_gradient_everywhere() -> None:
    y, x = np.mgrid[:7, :9]
    gx, gy = gradients((20 + 3 * x + 5 * y).astype(np.uint8))
    assert gx.shape == gy.shape == (5, 7)
    assert (gx == -6).all() and (gy == -10).all()


@pytest.mark.parametrize(("dtype", "top"), [(np.uint8, 15), (np.uint8, 255), (np.uint16, 1023)])
def test_single_pixel_gives_both_signs_without_wrapping(dtype: type, top: int) -> None:
    image = np.zeros((5, 5), dtype)
    image[2, 2] = top
    gx, gy = gradients(image)
    # left of the pixel it is the right neighbour, so it counts negative
    assert gx.tolist() == [[0, 0, 0], [-top, 0, top], [0, 0, 0]]
    assert gy.tolist() == [[0, -top, 0], [0, 0, 0], [0, top, 0]]


@pytest.mark.parametrize(
    ("gx", "gy", "gradient", "expected"),
    [
        (3, 5, "signed", (9, 25, 15)),
        (-3, 5, "signed", (9, 25, -15)),
        (3, -5, "signed", (9, 25, -15)),
        (-3, -5, "signed", (9, 25, 15)),
        (-3, 5, "absolute", (9, 25, 15)),
        (3, -5, "absolute", (9, 25, 15)),
        (-3, -5, "absolute", (9, 25, 15)),
        (0, -7, "signed", (0, 49, 0)),
        (255, -255, "signed", (65025, 65025, -65025)),
        (-255, 255, "absolute", (65025, 65025, 65025)),
        (-1023, 1023, "signed", (1046529, 1046529, -1046529)),
    ],
)
def test_products(gx: int, gy: int, gradient: Gradient, expected: tuple[int, int, int]) -> None:
    a, b, c = products(np.array([[gx]], np.int16), np.array([[gy]], np.int16), gradient)
    assert (a.item(), b.item(), c.item()) == expected


def test_sobel_smooths_across_and_rounds_halves_away_from_zero() -> None:
    image = np.array([[10, 0, 0], [20, 0, 0], [31, 0, 0]], np.uint8)
    gx, gy = gradients(image, "sobel")
    # (10 + 2·20 + 31) / 4 = 20.25; (1·10 - 1·31) / 4 = -5.25
    assert (gx.item(), gy.item()) == (20, -5)
    for value, rounded in ((1, 0), (2, 1), (3, 1), (5, 1), (6, 2)):
        corner = np.zeros((3, 3), np.uint8)
        corner[0, 0] = value
        assert [g.item() for g in gradients(corner, "sobel")] == [rounded, rounded]
        assert [g.item() for g in gradients(corner[::-1, ::-1], "sobel")] == [-rounded, -rounded]


def test_sobel_of_ramps_and_steps_is_as_without_smoothing() -> None:
    y, x = np.mgrid[:7, :9]
    gx, gy = gradients((20 + 3 * x + 5 * y).astype(np.uint8), "sobel")
    assert gx.shape == gy.shape == (5, 7)
    assert (gx == -6).all() and (gy == -10).all()
    image = np.zeros((5, 8), np.uint8)
    image[:, 4:] = 255
    gx, gy = gradients(image, "sobel")
    assert gx.tolist() == [[0, 0, -255, -255, 0, 0]] * 3
    assert not gy.any()


@pytest.mark.parametrize("turn", [np.fliplr, np.flipud, np.transpose])
def test_sobel_of_turned_images(turn: Callable[[Any], Any]) -> None:
    image = np.random.default_rng(3).integers(0, 256, (20, 30), np.uint8)
    sizes = {name: np.abs(g) for name, g in zip("xy", gradients(image, "sobel"), strict=True)}
    gx, gy = (np.abs(g) for g in gradients(turn(image), "sobel"))
    across, down = ("y", "x") if turn is np.transpose else ("x", "y")
    assert np.array_equal(gx, turn(sizes[across])) and np.array_equal(gy, turn(sizes[down]))
