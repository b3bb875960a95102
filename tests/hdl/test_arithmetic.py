# amaranth: UnusedElaboratable=no
"""Squares and products out of adders: exhaustively where narrow, at their ends where wide; and no multipliers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.back import rtlil
from amaranth.hdl import Module
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from golden import profile
from hdl.arithmetic import add_tree, multiply, square, tree_latency
from hdl.detector import Detector
from hdl.stream import Pipeline
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.hdl.blocks import NO_STALLS, RUN_IDS, RUNS, Words, assert_timing, engine, pack, run

Int64 = NDArray[np.int64]

A_BITS, B_BITS = 21, 18
SQUARES = (1, 2, 3, 4, 7, 8, 9, 10, 17, 21)
PRODUCTS = ((1, 1), (3, 2), (8, 8), (10, 10), (20, 18), (5, 17), (21, 1))
TREES = (1, 2, 3, 5, 9)
LATENCY = 5


class Products(wiring.Component):
    """Squares, products and sums of the low bits of two numbers, all in step."""

    i_shape = data.StructLayout({"a": A_BITS, "b": B_BITS})
    o_shape = data.StructLayout(
        {f"square_{n}": 2 * n for n in SQUARES}
        | {f"product_{n}_{k}": n + k for n, k in PRODUCTS}
        | {f"sum_{n}": A_BITS + 4 for n in TREES}
    )

    def __init__(self) -> None:
        super().__init__({"i": In(stream.Signature(self.i_shape)), "o": Out(stream.Signature(self.o_shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        a, b = self.i.payload.a, self.i.payload.b
        results = {f"square_{n}": (square(pipe, a[:n], f"s{n}"), n) for n in SQUARES}
        results |= {f"product_{n}_{k}": (multiply(pipe, a[:n], b[:k], f"p{n}_{k}"), k) for n, k in PRODUCTS}
        results |= {f"sum_{n}": (add_tree(pipe, [a, b, a, b, a, b, a, b, a][:n], f"t{n}"), n) for n in TREES}
        for name, (value, terms) in results.items():
            wait = LATENCY - tree_latency(terms)
            m.d.comb += self.o.payload[name].eq(pipe.delay(value, wait, f"{name}_wait"))
        m.d.comb += self.o.valid.eq(pipe.delay(pipe.valid, LATENCY, "valid", reset=True))
        return m


def streams(a: Int64, b: Int64) -> tuple[dict[str, Words], dict[str, Words]]:
    expected = {f"square_{n}": (a & ((1 << n) - 1)) ** 2 for n in SQUARES}
    expected |= {f"product_{n}_{k}": (a & ((1 << n) - 1)) * (b & ((1 << k) - 1)) for n, k in PRODUCTS}
    expected |= {f"sum_{n}": sum(([a, b] * 5)[:n], np.zeros_like(a)) for n in TREES}
    return {"i": pack(Products.i_shape, {"a": a, "b": b})}, {"o": pack(Products.o_shape, expected)}


def some(count: int) -> tuple[Int64, Int64]:
    """All pairs of ends and single bits, then random ones of every length."""
    rng = np.random.default_rng(1)
    ends_a, ends_b = (
        np.array(sorted({0, *(1 << k for k in range(bits)), *((2 << k) - 1 for k in range(bits))}))
        for bits in (A_BITS, B_BITS)
    )
    a, b = (grid.reshape(-1) for grid in np.meshgrid(ends_a, ends_b))
    more_a, more_b = (
        rng.integers(0, 1 << bits, count) >> rng.integers(0, bits, count) for bits in (A_BITS, B_BITS)
    )
    return np.concatenate([more_a, a]), np.concatenate([more_b, b])


def test_all_bytes() -> None:
    """Every pair of 8-bit numbers, and with them every narrower one."""
    a, b = (grid.reshape(-1) for grid in np.mgrid[:256, :256].astype(np.int64))
    assert_timing(run(engine("compiled", Products), *streams(a, b)), LATENCY)


def test_every_square_of_17_bits() -> None:
    """Those of the response."""
    a = np.arange(1 << 17)
    run(engine("compiled", Products), *streams(a, a[::-1]))


def test_ends_and_single_bits() -> None:
    run(engine("compiled", Products), *streams(*some(20_000)))


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_stalls(name: EngineName, stalls: Stalls) -> None:
    a, b = some(2000 if name == "compiled" else 100)
    count = 3000 if name == "compiled" else 100
    capture = run(engine(name, Products), *streams(a[:count], b[:count]), stalls)
    if stalls == NO_STALLS:
        assert_timing(capture, LATENCY)


def test_tree_latency() -> None:
    assert [tree_latency(terms) for terms in (1, 2, 3, 4, 5, 8, 9, 16, 17)] == [0, 1, 2, 2, 3, 3, 4, 4, 5]


@pytest.mark.parametrize("name", ["paper", "robust"])
def test_the_detector_has_no_multiplier(name: str) -> None:
    text = rtlil.convert(Detector(profile(name)), name="top", emit_src=False)
    assert "cell $add " in text
    assert "cell $mul " not in text and "cell $div" not in text and "cell $mod" not in text
