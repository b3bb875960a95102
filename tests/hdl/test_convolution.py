# amaranth: UnusedElaboratable=no
"""Convolution unit: the kernel, its one rounding, and its extremes, with and without sign."""

from __future__ import annotations

import numpy as np
import pytest
from amaranth.hdl import Shape, signed, unsigned

from golden.convolution import KERNEL, smooth
from hdl.convolution import ConvolutionUnit
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

SHAPES = [unsigned(16), signed(17)]
IDS = ["unsigned", "signed"]
SIZES = [(5, 5), (11, 19), (5, 40), (20, 6), (6, 5)]


def bounds(shape: Shape) -> tuple[int, int]:
    """Largest and smallest product of real pixels."""
    return 255 * 255, -255 * 255 if shape.signed else 0


def streams(frames: list[Array], shape: Shape) -> tuple[dict[str, Words], dict[str, Words]]:
    block = ConvolutionUnit(shape)
    smoothed = [smooth(frame.astype(np.int32)) for frame in frames]
    given = pack(block.i.payload.shape(), columns(frames, 5))
    return {"i": given}, {"o": pack(block.o.payload.shape(), raster(smoothed))}


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("shape", SHAPES, ids=IDS)
def test_smoothing(shape: Shape, name: EngineName, stalls: Stalls) -> None:
    largest, smallest = bounds(shape)
    sizes = SIZES if name == "compiled" else [(5, 5), (7, 12), (6, 5)]
    given, expected = streams(noise(sizes, largest, smallest=smallest), shape)
    capture = run(engine(name, ConvolutionUnit, shape), given, expected, stalls)
    if stalls == NO_STALLS:
        beats = completing([(height - 4, width) for height, width in sizes], 5)
        assert_timing(capture, ConvolutionUnit.latency, beats)


@pytest.mark.parametrize("shape", SHAPES, ids=IDS)
def test_extremes(shape: Shape) -> None:
    """Also the very ends of the format, which no pixels reach."""
    ends = ((1 << 16) - 1, -(1 << 16) if shape.signed else 0)
    frames = extremes((11, 13), *bounds(shape)) + extremes((11, 13), *ends)
    run(engine("compiled", ConvolutionUnit, shape), *streams(frames, shape))


@pytest.mark.parametrize("shape", SHAPES, ids=IDS)
def test_every_tap(shape: Shape) -> None:
    """A lone 64 in each of the 25 places shows the kernel itself, as printed in Eq. 1 times 64."""
    frames = [np.where(np.arange(25).reshape(5, 5) == place, 64, 0) for place in range(25)]
    given, _ = streams(frames, shape)
    assert KERNEL.sum() == 64
    taps = [1, 2, 2, 2, 1, 2, 4, 4, 4, 2, 2, 4, 4, 4, 2, 2, 4, 4, 4, 2, 1, 2, 2, 2, 1]
    ones = np.ones(25)
    block = ConvolutionUnit(shape)
    expected = pack(block.o.payload.shape(), {"data": np.array(taps), "eol": ones, "eof": ones})
    run(engine("compiled", ConvolutionUnit, shape), given, {"o": expected})


@pytest.mark.parametrize("name", ENGINES)
def test_halves_round_away_from_zero(name: EngineName) -> None:
    """4 times the centre over 64: 8 gives one half, 7 less, 9 more, and likewise 24, 23 and 25 around 1.5."""
    centres = [7, 8, 9, 23, 24, 25, -7, -8, -9, -23, -24, -25, 0]
    rounded = [0, 1, 1, 1, 2, 2, 0, -1, -1, -1, -2, -2, 0]
    shape = signed(17)
    block = ConvolutionUnit(shape)
    frames = [np.where(np.arange(25).reshape(5, 5) == 12, centre, 0) for centre in centres]
    given = pack(block.i.payload.shape(), columns(frames, 5))
    ones = np.ones(len(frames))
    expected = pack(block.o.payload.shape(), {"data": np.array(rounded), "eol": ones, "eof": ones})
    run(engine(name, ConvolutionUnit, shape), {"i": given}, {"o": expected})


def test_latency() -> None:
    assert ConvolutionUnit.latency == 7
