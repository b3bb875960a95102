# amaranth: UnusedElaboratable=no
"""Sums with a carry, and comparisons: all pairs of narrow numbers, ends of wide ones; one adder."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.back import rtlil
from amaranth.hdl import Module, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from hdl.build import Build
from hdl.detector import Detector
from hdl.parts.arithmetic import add_with_carry, exceeds
from sim.engine import EngineName
from tests.support.blocks import ENGINES, check_block

Int64 = NDArray[np.int64]


class Sum(wiring.Component):
    """a + b + carry, of signed numbers of these widths."""

    def __init__(self, a_bits: int, b_bits: int) -> None:
        self.i_shape = data.StructLayout({"a": signed(a_bits), "b": signed(b_bits), "carry": 1})
        # one bit more than it can need
        self.o_shape = data.StructLayout({"sum": signed(max(a_bits, b_bits) + 2)})
        super().__init__({"i": In(stream.Signature(self.i_shape)), "o": Out(stream.Signature(self.o_shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        given = self.i.payload
        total = add_with_carry(given.a, given.b, given.carry)
        assert total.shape() == signed(len(self.o.payload.sum) - 1)
        m.d.comb += [
            self.o.valid.eq(self.i.valid),
            self.i.ready.eq(self.o.ready),
            self.o.payload.sum.eq(total),
        ]
        return m


def check(a_bits: int, b_bits: int, a: Int64, b: Int64, name: EngineName = "compiled") -> None:
    """Every a with every b, without and with carry."""
    a, b, carry = (grid.reshape(-1) for grid in np.meshgrid(a, b, [0, 1]))
    given, expected = {"a": a, "b": b, "carry": carry}, {"sum": a + b + carry}
    check_block((Sum, a_bits, b_bits), {"i": given}, {"o": expected}, name, latency=0)


@pytest.mark.parametrize(("a_bits", "b_bits"), [(1, 1), (3, 5), (5, 3), (6, 6)])
def test_every_pair(a_bits: int, b_bits: int) -> None:
    a, b = (np.arange(-(1 << (bits - 1)), 1 << (bits - 1)) for bits in (a_bits, b_bits))
    check(a_bits, b_bits, a, b)


@pytest.mark.parametrize(("a_bits", "b_bits"), [(11, 11), (20, 9), (21, 21)])
def test_wide_ones(a_bits: int, b_bits: int) -> None:
    """Ends, single bits, and anything."""

    def some(bits: int) -> Int64:
        top = 1 << (bits - 1)
        ends = {-top, top - 1, -1, 0, *(1 << k for k in range(bits - 1)), *(-1 << k for k in range(bits - 1))}
        return np.concatenate([sorted(ends), np.random.default_rng(bits).integers(-top, top, 100)])

    check(a_bits, b_bits, some(a_bits), some(b_bits))


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """-16 and 15, and with either carry: no bit is lost at either end."""
    check(5, 5, np.array([-16, 15]), np.array([-16, 15]), name)


def test_it_is_one_adder() -> None:
    text = rtlil.convert(Sum(11, 11), name="top", emit_src=False)
    assert text.count("cell $add ") == 1 and "cell $sub" not in text


class Larger(wiring.Component):
    """a > b, of unsigned numbers."""

    def __init__(self, bits: int) -> None:
        self.i_shape = data.StructLayout({"a": bits, "b": bits})
        self.o_shape = data.StructLayout({"larger": 1})
        super().__init__({"i": In(stream.Signature(self.i_shape)), "o": Out(stream.Signature(self.o_shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        given = self.i.payload
        m.d.comb += [
            self.o.valid.eq(self.i.valid),
            self.i.ready.eq(self.o.ready),
            self.o.payload.larger.eq(exceeds(given.a, given.b)),
        ]
        return m


@pytest.mark.parametrize("bits", [1, 4, 18])
def test_the_larger_one(bits: int) -> None:
    top = (1 << bits) - 1
    some = np.arange(16) if bits == 4 else np.unique([0, 1, top // 2, top // 2 + 1, top - 1, top])
    a, b = (grid.reshape(-1) for grid in np.meshgrid(some, some))
    check_block((Larger, bits), {"i": {"a": a, "b": b}}, {"o": {"larger": a > b}}, latency=0)


def test_a_comparison_is_a_subtraction() -> None:
    text = rtlil.convert(Larger(11), name="top", emit_src=False)
    assert text.count("cell $sub ") == 1 and "cell $gt" not in text and "cell $lt" not in text


@pytest.mark.parametrize("name", ["paper", "robust"])
def test_the_detector_has_no_multiplier(name: str) -> None:
    text = rtlil.convert(Detector(Build.profile(name)), name="top", emit_src=False)
    assert "cell $add " in text
    assert "cell $mul " not in text and "cell $div" not in text and "cell $mod" not in text
