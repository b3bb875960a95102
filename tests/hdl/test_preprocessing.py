# amaranth: UnusedElaboratable=no
"""Preprocessing: gradients and their products against the golden model, both signs, every pixel width."""

from __future__ import annotations

import numpy as np
import pytest

from golden.parameters import Gradient, Parameters
from golden.preprocessing import gradients, products
from hdl.preprocessing import Preprocessing, products_layout
from hdl.stream import Beat
from sim.engine import Engine, EngineName
from sim.stimulus import Stalls
from tests.hdl.blocks import (
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
    unpack,
)

GRADIENTS: list[Gradient] = ["absolute", "signed"]
SIZES = [(3, 3), (12, 17), (3, 30), (20, 4), (4, 3)]


def streams(
    frames: list[Array], parameters: Parameters
) -> tuple[Engine, Engine, dict[str, Words], dict[str, Words]]:
    block = Preprocessing(parameters)
    results = [products(*gradients(frame), parameters.gradient) for frame in frames]
    tagged = raster([np.stack(result, axis=-1) for result in results])
    tagged["data"] = {name: tagged["data"][:, k] for k, name in enumerate("abc")}
    given = pack(block.i.payload.shape(), columns(frames, 3))
    expected = pack(block.o.payload.shape(), tagged)
    compiled, amaranth = (engine(name, Preprocessing, parameters) for name in ("compiled", "amaranth"))
    return compiled, amaranth, {"i": given}, {"o": expected}


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("gradient", GRADIENTS)
def test_products(gradient: Gradient, name: EngineName, stalls: Stalls) -> None:
    parameters = Parameters(gradient=gradient)
    sizes = SIZES if name == "compiled" else [*SIZES[:1], (5, 9)]
    frames = noise(sizes, 255, dtype=np.uint8)
    compiled, amaranth, given, expected = streams(frames, parameters)
    capture = run(compiled if name == "compiled" else amaranth, given, expected, stalls)
    if stalls == NO_STALLS:
        beats = completing([(height - 2, width) for height, width in sizes], 3)
        assert_timing(capture, Preprocessing(parameters).latency, beats)


@pytest.mark.parametrize(
    ("gradient", "pixel_bits"), [("absolute", 8), ("signed", 8), ("signed", 10), ("absolute", 4)]
)
def test_extremes(gradient: Gradient, pixel_bits: int) -> None:
    parameters = Parameters(gradient=gradient, pixel_bits=pixel_bits)
    frames = extremes((9, 14), parameters.pixel_max, dtype=np.uint16)
    frames += noise([(30, 40)], parameters.pixel_max, 1, dtype=np.uint16)
    compiled, _, given, expected = streams(frames, parameters)
    run(compiled, given, expected)
    cross = unpack(Beat(products_layout(parameters)), expected["o"])["data"]["c"]
    assert cross.max() == parameters.product_max
    assert cross.min() == (-parameters.product_max if gradient == "signed" else 0)


@pytest.mark.parametrize(("gradient", "sign"), [("absolute", 1), ("signed", -1)])
def test_by_hand(gradient: Gradient, sign: int) -> None:
    """Left 200, right 90, above 7, below 77: gx = 110, gy = -70."""
    frame = np.array([[1, 7, 2], [200, 50, 90], [3, 77, 4]])
    parameters = Parameters(gradient=gradient)
    block = Preprocessing(parameters)
    tensor = {"a": np.array([12100]), "b": np.array([4900]), "c": np.array([sign * 7700])}
    one = np.array([1])
    expected = pack(block.o.payload.shape(), {"data": tensor, "eol": one, "eof": one})
    given = pack(block.i.payload.shape(), columns([frame], 3))
    run(engine("amaranth", Preprocessing, parameters), {"i": given}, {"o": expected})


def test_latency() -> None:
    """Window and difference, size, trees of 8 (or 10, or 4) partial products, result."""
    latencies = [Preprocessing(Parameters(pixel_bits=bits)).latency for bits in (4, 8, 10)]
    assert latencies == [6, 7, 8]
