# amaranth: UnusedElaboratable=no
"""Preprocessing: squares of gradients against the golden model, both kinds of gradients, every pixel width."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from golden.parameters import MAX_PIXEL_BITS, MIN_PIXEL_BITS, Gradient, Parameters
from golden.preprocessing import gradients, products
from hdl.preprocessing import Preprocessing
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.hdl.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    Words,
    assert_timing,
    columns,
    completing,
    engine,
    extremes,
    noise,
    pack,
    raster,
    run,
)

GRADIENTS: list[Gradient] = ["absolute", "signed"]
SIZES = [(7, 3), (16, 17), (7, 30), (24, 4), (8, 3)]


def squares(frame: Array, gradient: Gradient) -> Array:
    """a, b and d of every pixel; d follows from the golden products."""
    a, b, c = products(*gradients(frame), gradient)
    return np.stack([a, b, a + b - 2 * c], axis=-1)


def fields(tagged: dict[str, Any]) -> dict[str, Any]:
    """Windows of (n, 3, 5) values as fields of a column."""
    return tagged | {"data": {name: tagged["data"][:, k] for k, name in enumerate("abd")}}


def streams(frames: list[Array], parameters: Parameters) -> tuple[dict[str, Words], dict[str, Words]]:
    block = Preprocessing(parameters)
    windows = [sliding_window_view(squares(frame, parameters.gradient), 5, axis=0) for frame in frames]
    given = pack(block.i.payload.shape(), columns(frames, 7))
    return {"i": given}, {"o": pack(block.o.payload.shape(), fields(raster(windows)))}


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("gradient", GRADIENTS)
def test_squares(gradient: Gradient, name: EngineName, stalls: Stalls) -> None:
    parameters = Parameters(gradient=gradient)
    sizes = SIZES if name == "compiled" else [*SIZES[:1], (9, 9)]
    given, expected = streams(noise(sizes, 255, dtype=np.uint8), parameters)
    capture = run(engine(name, Preprocessing, parameters), given, expected, stalls)
    if stalls == NO_STALLS:
        beats = completing([(height - 6, width) for height, width in sizes], 3)
        assert_timing(capture, Preprocessing.latency, beats)


@pytest.mark.parametrize("gradient", GRADIENTS)
@pytest.mark.parametrize("pixel_bits", range(MIN_PIXEL_BITS, MAX_PIXEL_BITS + 1))
def test_extremes(gradient: Gradient, pixel_bits: int) -> None:
    """Of all pixel widths; every square reaches the end of its format."""
    parameters = Parameters(gradient=gradient, pixel_bits=pixel_bits)
    frames = extremes((12, 14), parameters.pixel_max, dtype=np.uint16)
    frames += noise([(90, 120)], parameters.pixel_max, 1, dtype=np.uint16)
    given, expected = streams(frames, parameters)
    run(engine("compiled", Preprocessing, parameters), given, expected)
    values = np.concatenate([squares(frame, gradient).reshape(-1, 3) for frame in frames]).max(axis=0)
    largest = parameters.product_max
    assert values.tolist() == [largest, largest, largest * (4 if gradient == "signed" else 1)]


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize(("gradient", "first"), [("absolute", 40), ("signed", 180)])
def test_by_hand(gradient: Gradient, first: int, name: EngineName) -> None:
    """gx = 110, -3, -30, 255, 0 and gy = -70, -10, -3, 60, -175, from the top."""
    parameters = Parameters(gradient=gradient)
    block = Preprocessing(parameters)
    frame = np.array(
        [[1, 7, 2], [200, 50, 90], [1, 77, 4], [90, 60, 120], [255, 80, 0], [5, 0, 5], [3, 255, 4]]
    )
    values = {
        "a": np.array([[12100, 9, 900, 65025, 0]]),
        "b": np.array([[4900, 100, 9, 3600, 30625]]),
        "d": np.array([[first**2, 7**2, 27**2, 195**2, 175**2]]),
    }
    one = np.array([1])
    expected = pack(block.o.payload.shape(), {"data": values, "eol": one, "eof": one})
    given = pack(block.i.payload.shape(), columns([frame], 7))
    run(engine(name, Preprocessing, parameters), {"i": given}, {"o": expected})


def test_latency() -> None:
    """Gradients, sizes, tables, the registers behind them."""
    assert Preprocessing.latency == 4


@pytest.mark.parametrize(("gradient", "bits"), [("absolute", 8 * 2816), ("signed", 5 * 2816 + 3 * 6656)])
def test_memory(gradient: Gradient, bits: int) -> None:
    """Fifteen look-ups of 8 bits share eight tables; with signs, five of them are of 9 bits."""
    assert Preprocessing(Parameters(gradient=gradient)).memory_bits == bits
