# amaranth: UnusedElaboratable=no
"""Preprocessing: sizes of gradients against the golden model, all kinds and pixel widths."""

from __future__ import annotations

import numpy as np
import pytest

from golden.algorithm import Derivative, Gradient
from golden.formats import MAX_PIXEL_BITS, MIN_PIXEL_BITS
from golden.parameters import Parameters
from golden.preprocessing import gradients, products
from hdl.build import Build
from hdl.preprocessing import Preprocessing
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    check_block,
    columns,
    extremes,
    noise,
    raster,
)

GRADIENTS: list[Gradient] = ["absolute", "signed"]
DERIVATIVES: list[Derivative] = ["central", "sobel"]
MEMBERS = ("gx", "gy", "difference")
SIZES = [(7, 3), (16, 17), (7, 30), (24, 4), (8, 3)]


def sizes(frame: Array, gradient: Gradient, derivative: Derivative = "central") -> Array:
    """|gx|, |gy| and the size of their difference of every pixel; these make the products."""
    gx, gy = (values.astype(np.int64) for values in gradients(frame, derivative))
    difference = np.abs(gx - gy if gradient == "signed" else np.abs(gx) - np.abs(gy))
    a, b, c = products(gx, gy, gradient)
    assert (gx**2 == a).all() and (gy**2 == b).all() and (a + b - difference**2 == 2 * c).all()
    return np.stack([np.abs(gx), np.abs(gy), difference], axis=-1)


def check(
    parameters: Parameters, frames: list[Array], name: EngineName = "compiled", stalls: Stalls = NO_STALLS
) -> None:
    kinds = parameters.algorithm.gradient, parameters.algorithm.derivative
    expected = columns([sizes(frame, *kinds) for frame in frames], 5, MEMBERS)
    given = columns(frames, 7)
    check_block((Preprocessing, parameters), {"i": given}, {"o": expected}, name, stalls, window=3)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("derivative", DERIVATIVES)
@pytest.mark.parametrize("gradient", GRADIENTS)
def test_sizes(gradient: Gradient, derivative: Derivative, name: EngineName, stalls: Stalls) -> None:
    parameters = Build.profile("paper", gradient=gradient, derivative=derivative)
    shapes = SIZES if name == "compiled" else [*SIZES[:1], (9, 9)]
    check(parameters, noise(shapes, 255, dtype=np.uint8), name, stalls)


@pytest.mark.parametrize(
    ("derivative", "pixel_bits"),
    [
        *(("central", bits) for bits in range(MIN_PIXEL_BITS, MAX_PIXEL_BITS + 1)),
        *(("sobel", bits) for bits in (MIN_PIXEL_BITS, 7, MAX_PIXEL_BITS)),
    ],
)
@pytest.mark.parametrize("gradient", GRADIENTS)
def test_extremes(gradient: Gradient, derivative: Derivative, pixel_bits: int) -> None:
    """All pixel widths; sizes reach the end of their format, except a difference with Sobel."""
    parameters = Build.profile("paper", gradient=gradient, derivative=derivative, pixel_bits=pixel_bits)
    frames = extremes((12, 14), parameters.pixel_max, dtype=np.uint16)
    frames += noise([(90, 120)], parameters.pixel_max, 1, dtype=np.uint16)
    check(parameters, frames)
    values = np.concatenate([sizes(frame, gradient, derivative).reshape(-1, 3) for frame in frames]).max(
        axis=0
    )
    largest = parameters.pixel_max
    if derivative == "sobel":
        # of the eight pixels around, gx - gy has two corners twice, which make half of the largest,
        # and four sides
        assert values[:2].tolist() == [largest, largest] and values[2] <= largest * 3 // 2 + 1
        return
    assert values.tolist() == [largest, largest, largest * (2 if gradient == "signed" else 1)]


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize(("gradient", "first"), [("absolute", 40), ("signed", 180)])
def test_by_hand(gradient: Gradient, first: int, name: EngineName) -> None:
    """gx = 110, -3, -30, 255, 0 and gy = -70, -10, -3, 60, -175, from the top."""
    frame = np.array(
        [[1, 7, 2], [200, 50, 90], [1, 77, 4], [90, 60, 120], [255, 80, 0], [5, 0, 5], [3, 255, 4]]
    )
    column = np.array([[110, 3, 30, 255, 0], [70, 10, 3, 60, 175], [first, 7, 27, 195, 175]])
    expected = raster([column[None, None]], MEMBERS)
    block = Preprocessing, Build.profile("paper", gradient=gradient)
    check_block(block, {"i": columns([frame], 7)}, {"o": expected}, name, window=3)


@pytest.mark.parametrize("name", ENGINES)
def test_sobel_rounds_halves_away_from_zero(name: EngineName) -> None:
    """A pixel of 0 to 8 at the upper left, and upside down: quarters and halves of either sign."""
    frames = []
    for value in range(9):
        frame = np.zeros((8, 4), np.uint8)
        frame[1, 0] = frame[6, 3] = value
        frames.append(frame)
    parameters = Build.profile("paper", gradient="signed", derivative="sobel")
    check(parameters, frames, name)


def test_latency() -> None:
    """Gradients, sizes; with Sobel sums, differences and rounding."""
    assert Preprocessing(Build.profile("paper")).latency == 2
    assert Preprocessing(Build.profile("paper", derivative="sobel")).latency == 4
