# amaranth: UnusedElaboratable=no
"""Convolution: smoothed products against the golden model, every tap, exact rounding."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from golden.algorithm import Gradient
from golden.convolution import KERNEL, smooth
from golden.formats import MAX_PIXEL_BITS, MIN_PIXEL_BITS
from golden.parameters import Parameters
from golden.preprocessing import products
from hdl.build import Build
from hdl.convolution import Convolution, products_layout
from hdl.parts.stream import Beat
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
    unpack,
)

GRADIENTS: list[Gradient] = ["absolute", "signed"]
SIZES = [(5, 5), (11, 19), (5, 40), (20, 6), (6, 5)]
Pair = tuple[Array, Array]


def sizes_of(frames: list[Pair], parameters: Parameters) -> dict[str, Any]:
    """Columns of the sizes of gradients, (gx, gy)."""
    sizes = [np.stack([abs(gx), abs(gy), difference(gx, gy, parameters)], axis=-1) for gx, gy in frames]
    return columns(sizes, 5, ("gx", "gy", "difference"))


def check(
    parameters: Parameters, frames: list[Pair], name: EngineName = "compiled", stalls: Stalls = NO_STALLS
) -> dict[str, Array]:
    """Frames of gradients, (gx, gy), against the smoothed golden products; these are returned."""
    tensors = [products(gx, gy, parameters.algorithm.gradient) for gx, gy in frames]
    smoothed = [np.stack([smooth(channel) for channel in tensor], axis=-1) for tensor in tensors]
    given, expected = {"i": sizes_of(frames, parameters)}, {"o": raster(smoothed, "abc")}
    capture = check_block((Convolution, parameters), given, expected, name, stalls, window=5)
    seen: dict[str, Array] = unpack(Beat(products_layout(parameters)), capture.outputs["o"])["data"]
    return seen


def difference(gx: Array, gy: Array, parameters: Parameters) -> Array:
    """Its square is gx² + gy² - 2·gx·gy, with or without signs."""
    return np.abs(gx - gy if parameters.algorithm.gradient == "signed" else np.abs(gx) - np.abs(gy))


def pairs(gx: list[Array], gy: list[Array]) -> list[Pair]:
    return list(zip(gx, gy, strict=True))


def noisy(sizes: list[tuple[int, int]], largest: int) -> list[Pair]:
    return pairs(*(noise(sizes, largest, seed, smallest=-largest) for seed in (1, 2)))


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("gradient", GRADIENTS)
def test_smoothing(gradient: Gradient, name: EngineName, stalls: Stalls) -> None:
    parameters = Build.profile("paper", gradient=gradient)
    sizes = SIZES if name == "compiled" else [(5, 5), (7, 12), (6, 5)]
    check(parameters, noisy(sizes, 255), name, stalls)


@pytest.mark.parametrize("gradient", GRADIENTS)
@pytest.mark.parametrize("pixel_bits", range(MIN_PIXEL_BITS, MAX_PIXEL_BITS + 1))
def test_extremes(gradient: Gradient, pixel_bits: int) -> None:
    """Gradients of nothing but their two ends, in step and out of step; then any."""
    parameters = Build.profile("paper", gradient=gradient, pixel_bits=pixel_bits)
    largest = parameters.pixel_max
    patterns = extremes((11, 13), largest, -largest)
    frames = [(gx, gy) for gx in patterns for gy in (gx, -gx, patterns[2], 0 * gx)]
    smoothed = check(parameters, frames + noisy([(40, 50)], largest))
    most = parameters.product_max
    assert (smoothed["a"].max(), smoothed["b"].max(), smoothed["c"].max()) == (most, most, most)
    assert smoothed["c"].min() == (-most if gradient == "signed" else 0)


@pytest.mark.parametrize("gradient", GRADIENTS)
def test_every_tap(gradient: Gradient) -> None:
    """A lone product of 64 in each of 25 places shows the kernel, which is Eq. 1 times 64."""
    place = [np.arange(25).reshape(5, 5) == k for k in range(25)]
    assert KERNEL.sum() == 64
    taps = np.array([1, 2, 2, 2, 1, 2, 4, 4, 4, 2, 2, 4, 4, 4, 2, 2, 4, 4, 4, 2, 1, 2, 2, 2, 1])
    parameters = Build.profile("paper", gradient=gradient)
    # the three squares are those of 8·8, 8·0, 0·8
    for gx, gy, expected in ((8, 8, (1, 1, 1)), (8, 0, (1, 0, 0)), (0, -8, (0, 1, 0))):
        given = sizes_of([(np.where(p, gx, 0), np.where(p, gy, 0)) for p in place], parameters)
        values = {name: taps * factor for name, factor in zip("abc", expected, strict=True)}
        tagged = {"data": values, "eol": np.ones(25), "eof": np.ones(25)}
        check_block((Convolution, parameters), {"i": given}, {"o": tagged}, window=5)


@pytest.mark.parametrize("name", ENGINES)
def test_halves_round_away_from_zero(name: EngineName) -> None:
    """4 times the centre over 64: 8 gives one half; likewise 24 gives 1.5; and around both."""
    centres = [7, 8, 9, 23, 24, 25, -7, -8, -9, -23, -24, -25, 0]
    rounded = [0, 1, 1, 1, 2, 2, 0, -1, -1, -1, -2, -2, 0]
    parameters = Build.profile("paper", gradient="signed")
    middle = np.arange(25).reshape(5, 5) == 12
    frames = [(np.where(middle, centre, 0), np.where(middle, 1, 0)) for centre in centres]
    assert check(parameters, frames, name)["c"].tolist() == rounded


@pytest.mark.parametrize(("gradient", "clocks"), [("absolute", 5), ("signed", 6)])
def test_latency(gradient: Gradient, clocks: int) -> None:
    """Tables 2, outer rows, all rows, the window; with signs one more for rounding."""
    assert Convolution(Build.profile("paper", gradient=gradient)).latency == clocks


@pytest.mark.parametrize(("gradient", "bits"), [("absolute", 8 * 3584), ("signed", 5 * 3584 + 3 * 8192)])
def test_memory(gradient: Gradient, bits: int) -> None:
    """Fifteen look-ups of 8 bits share eight tables; with signs, five of them are of 9 bits."""
    assert Convolution(Build.profile("paper", gradient=gradient)).memory_bits == bits
