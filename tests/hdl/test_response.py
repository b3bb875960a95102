# amaranth: UnusedElaboratable=no
"""Response: D of smoothed tensors, real and made up, against the golden model."""

from __future__ import annotations

from math import isqrt
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import ResetInserter, Signal
from amaranth.sim import Simulator
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.algorithm import Gradient
from golden.convolution import smooth
from golden.formats import MAX_PIXEL_BITS, MIN_PIXEL_BITS
from golden.parameters import Parameters
from golden.preprocessing import gradients, products
from golden.response import response
from hdl.build import Build
from hdl.response import Response
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    check_block,
    extremes,
    noise,
    raster,
)

ABSOLUTE = Build.profile("paper")
SIGNED = Build.profile("paper", gradient="signed", sqrt_bits_per_stage=3)
SHALLOW = Build.profile("paper", gradient="absolute", pixel_bits=4, sqrt_bits_per_stage=17)
WIDE = Build.profile("paper", gradient="signed", pixel_bits=10, sqrt_bits_per_stage=4)
DETECTORS = {"absolute": ABSOLUTE, "signed": SIGNED, "4-bit": SHALLOW, "10-bit": WIDE}


def check(
    parameters: Parameters, tensors: list[Array], name: EngineName = "compiled", stalls: Stalls = NO_STALLS
) -> Capture:
    """``tensors``: frames (height, width, 3) of A, B and C."""
    responses = [response(*np.moveaxis(frame, -1, 0), parameters) for frame in tensors]
    given, expected = {"i": raster(tensors, "abc")}, {"o": raster(responses)}
    return check_block((Response, parameters), given, expected, name, stalls)


def smoothed(images: list[Array], gradient: Gradient) -> list[Array]:
    return [
        np.stack([smooth(product) for product in products(*gradients(image), gradient)], axis=-1)
        for image in images
    ]


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("parameters", [ABSOLUTE, SIGNED], ids=["absolute", "signed"])
def test_noise(parameters: Parameters, name: EngineName, stalls: Stalls) -> None:
    sizes = [(40, 50), (7, 7), (20, 31)] if name == "compiled" else [(9, 10), (7, 7)]
    images = noise(sizes, 255, dtype=np.uint8)
    check(parameters, smoothed(images, parameters.algorithm.gradient), name, stalls)


@pytest.mark.parametrize("parameters", DETECTORS.values(), ids=DETECTORS.keys())
def test_extremes(parameters: Parameters) -> None:
    images = extremes((16, 18), parameters.pixel_max, dtype=np.uint16)
    images += noise([(40, 40)], parameters.pixel_max, 3, dtype=np.uint16)
    check(parameters, smoothed(images, parameters.algorithm.gradient))


@pytest.mark.parametrize("parameters", DETECTORS.values(), ids=DETECTORS.keys())
@given(data=st.data())
@settings(max_examples=30)
def test_any_tensor(parameters: Parameters, data: st.DataObject) -> None:
    """Tensors up to the ends of the format, C up to the root of AB, half of them at it.

    With absolute gradients, C is not so small that A + B - 2C exceeds the response's full scale.
    """
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32 - 1)))
    top = data.draw(st.sampled_from([1, 2, 7, parameters.product_max]))
    a, b = rng.integers(0, top, (2, 200), endpoint=True)
    limit = np.array([isqrt(x * y) for x, y in zip(a.tolist(), b.tolist(), strict=True)])
    least = np.maximum(-(-(a + b - parameters.response_max) // 2), 0)
    c = np.where(rng.random(200) < 0.5, limit, rng.integers(least, limit, endpoint=True))
    if parameters.algorithm.gradient == "signed":
        c *= rng.choice([-1, 1], 200)
    check(parameters, [np.stack([a, b, c], axis=-1)[None]])


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """Roots of 0, 5, 8, 25, 2 and of full scale; two of them exceed A + B, so D is clamped."""
    full, half = ABSOLUTE.product_max, ABSOLUTE.response_max // 2
    tensors = [(10, 10, 0, 20), (8, 3, 0, 6), (9, 6, 4, 7), (10, 3, 12, 0), (1, 0, 1, 0)]
    tensors += [(half, half, 0, 2 * half), (full, full, full, 0), (full, 0, 0, 0), (0, 0, 0, 0)]
    frame = np.array(tensors)[None]
    assert response(*(frame[..., k] for k in range(3)), ABSOLUTE).tolist() == [[row[3] for row in tensors]]
    check(ABSOLUTE, [frame[..., :3]], name)


@pytest.mark.parametrize("bits", range(MIN_PIXEL_BITS, MAX_PIXEL_BITS + 1))
@pytest.mark.parametrize("gradient", ["absolute", "signed"])
def test_every_pixel_width(gradient: Gradient, bits: int) -> None:
    """Noise, and black and white, whose tensors reach the ends of the format."""
    parameters = Build.profile("paper", gradient=gradient, pixel_bits=bits)
    images = noise([(12, 14)], parameters.pixel_max, bits, dtype=np.uint16)
    images += [parameters.pixel_max * image for image in noise([(12, 14)], 1, bits, dtype=np.uint16)]
    check(parameters, smoothed(images, gradient), "amaranth")


def test_latency() -> None:
    """A - B, sizes, difference of halves, look-up 2, sum, radicand; root 17, or 6 for 3 bits; D."""
    assert Response(ABSOLUTE).latency == 7 + 17 + 1
    assert Response(SIGNED).latency == 7 + 6 + 1


def test_memory_bits() -> None:
    """Tables of 256 and 512 squares without two low bits, and the delay lines."""
    tables = 14 * (2 * 256 + 512)
    wait, radicand = 19 * (23 - 2), 2 * (10 * 2 + 14 * 3)
    assert Response(ABSOLUTE).memory_bits == tables + wait + radicand


@pytest.mark.parametrize("lanes", [1, 2])
def test_no_beat_outlives_a_reset(lanes: int) -> None:
    """Whenever it comes while beats are under way, also where they wait in memory."""
    build = SHALLOW.changed(pixels_per_clock=lanes)
    dut, reset = Response(build), Signal()

    async def bench(ctx: Any) -> None:
        ctx.set(dut.o.ready, 1)
        for before in (1, dut.latency // 2, dut.latency - 1, 2 * dut.latency):
            ctx.set(dut.i.valid, 1)
            for _ in range(before):
                await ctx.tick()
            ctx.set(reset, 1)
            await ctx.tick()
            ctx.set(reset, 0)
            # one beat at once; nothing comes out but this
            seen = []
            for clock in range(2 * dut.latency):
                seen.append(ctx.get(dut.o.valid))
                await ctx.tick()
                if clock == 0:
                    ctx.set(dut.i.valid, 0)
            assert seen == [k == dut.latency for k in range(2 * dut.latency)]

    simulator = Simulator(ResetInserter(reset)(dut))
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
