# amaranth: UnusedElaboratable=no
"""Square root: every radicand where they are few, else the edges of every root."""

from __future__ import annotations

from math import isqrt
from typing import Any

import numpy as np
import pytest
from amaranth.back import rtlil
from amaranth.hdl import Module
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from golden.square_root import li_chu
from hdl.parts.stream import Pipeline
from hdl.square_root import SquareRoot
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, check_block

SHAPES = [
    *((1, 1, 0), (5, 2, 0), (8, 3, 0), (9, 5, 0), (21, 4, 0), *((17, k, 0) for k in range(1, 6))),
    *((2, 1, 1), (9, 3, 4), (17, 1, 5), (17, 4, 5), (21, 1, 5)),
]
"""Result bits, how many per stage, and how many are looked up."""
WIDEST = 21


class Roots(wiring.Component):
    """Square roots of many shapes on one radicand's low bits, in step: one compilation for all."""

    latency = WIDEST

    def __init__(self) -> None:
        self.roots = data.StructLayout({_name(shape): shape[0] for shape in SHAPES})
        super().__init__(
            {"i": In(stream.Signature(2 * WIDEST)), "o": Out(stream.Signature(self.roots))},
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        for shape in SHAPES:
            name = _name(shape)
            m.submodules[name] = block = SquareRoot(*shape)
            m.d.comb += [
                block.enable.eq(pipe.advance),
                block.radicand.eq(self.i.payload[: 2 * shape[0]]),
                self.o.payload[name].eq(pipe.delay(block.root, self.latency - block.latency, name)),
            ]
        m.d.comb += self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True))
        return m


def _name(shape: tuple[int, int, int]) -> str:
    return "r" + "_".join(map(str, shape))


class Root(wiring.Component):
    """One square root inside a pipeline."""

    def __init__(self, root_bits: int, bits_per_stage: int, looked_up: int) -> None:
        self.root = SquareRoot(root_bits, bits_per_stage, looked_up)
        super().__init__(
            {"i": In(stream.Signature(2 * root_bits)), "o": Out(stream.Signature(root_bits))},
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        m.submodules.root = self.root
        m.d.comb += [
            self.root.enable.eq(pipe.advance),
            self.root.radicand.eq(self.i.payload),
            self.o.payload.eq(self.root.root),
            self.o.valid.eq(pipe.delay(pipe.valid, self.root.latency, "valid", reset=True)),
        ]
        return m


def some_radicands(root_bits: int, count: int) -> NDArray[np.int64]:
    """Zero, full scale, k² - 1 and k² and k² + 2k around roots of all lengths, and random ones."""
    rng = np.random.default_rng(root_bits)
    top = (1 << root_bits) - 1
    near = {k for n in range(root_bits) for k in (1 << n, (2 << n) - 1)}
    near |= set(rng.integers(1, top + 1, count // 4).tolist())
    around = [value for k in sorted(near) for value in (k * k - 1, k * k, k * k + 2 * k)]
    many = rng.integers(0, 1 << (2 * root_bits), count // 4).tolist()
    return np.array([0, 1, 2, 3, (top + 1) ** 2 - 1, *around, *many], np.int64)


def floor_roots(radicand: NDArray[np.int64]) -> NDArray[np.int64]:
    return np.array([isqrt(value) for value in radicand.tolist()], np.int64)


@pytest.mark.parametrize(
    "radicand",
    [np.arange(1 << 18), some_radicands(17, 60_000), some_radicands(21, 30_000)],
    ids=["every one of 18 bits", "34 bits", "42 bits"],
)
def test_every_shape(radicand: NDArray[np.int64]) -> None:
    expected = {}
    for shape in SHAPES:
        low = radicand & ((1 << (2 * shape[0])) - 1)
        expected[_name(shape)] = floor_roots(low)
        assert np.array_equal(li_chu(low, shape[0]), expected[_name(shape)])
    check_block((Roots,), {"i": radicand}, {"o": expected})


def check(
    radicand: NDArray[np.int64],
    shape: tuple[int, int, int],
    latency: int,
    name: EngineName,
    stalls: Stalls = NO_STALLS,
) -> None:
    given, expected = {"i": radicand}, {"o": floor_roots(radicand)}
    check_block((Root, *shape), given, expected, name, stalls, latency=latency)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize(("shape", "latency"), [((17, 1, 0), 17), ((17, 3, 0), 6), ((17, 1, 5), 15)])
def test_stalls(shape: tuple[int, int, int], latency: int, name: EngineName, stalls: Stalls) -> None:
    check(some_radicands(17, 4000 if name == "compiled" else 200), shape, latency, name, stalls)


@pytest.mark.parametrize("shape", SHAPES)
def test_latency(shape: tuple[int, int, int]) -> None:
    """A stage with the last few bits is one of its own; bits looked up take three clocks."""
    (root_bits, bits_per_stage, looked_up), latency = shape, SquareRoot(*shape).latency
    steps = (root_bits - looked_up + bits_per_stage - 1) // bits_per_stage
    assert latency == steps + (3 if looked_up else 0)
    check(some_radicands(root_bits, 40), shape, latency, "amaranth")


def test_more_bits_per_stage_do_not_multiply_the_logic() -> None:
    """A step's result is used several times by the next one: it must be made only once."""
    one = len(rtlil.convert(SquareRoot(17, 1), name="one", emit_src=False))
    all_at_once = len(rtlil.convert(SquareRoot(17, 17), name="all_at_once", emit_src=False))
    assert all_at_once < one
