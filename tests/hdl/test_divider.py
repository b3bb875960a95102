# amaranth: UnusedElaboratable=no
"""Divider: all pairs of narrow operands, wide ones around every step, pauses between bits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from golden.divider import HALF, QUOTIENT_BITS, divide
from hdl.divider import Divider
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import ENGINES, NO_STALLS, RUN_IDS, RUNS, check_block, unpack

USED = 17
"""Width in the subpixel refinement."""
WIDTHS = [1, 2, 5, 8, USED, 24]
RESULT = data.StructLayout({"quotient": QUOTIENT_BITS, "reached": 1})

Int64 = NDArray[np.int64]


class Dividing(wiring.Component):
    """The divider as a stream: a bit in every clock in which the sink is ready."""

    latency = QUOTIENT_BITS + 1

    def __init__(self, bits: int) -> None:
        self._divider = Divider(bits)
        operands = data.StructLayout({"numerator": bits, "denominator": bits})
        super().__init__({"i": In(stream.Signature(operands)), "o": Out(stream.Signature(RESULT))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.divider = divider = self._divider
        denominator = Signal.like(divider.denominator)
        left = Signal(range(QUOTIENT_BITS + 1))
        m.d.comb += [
            self.i.ready.eq(~self.o.valid & (left == 0) | self.o.valid & self.o.ready),
            divider.load.eq(self.i.valid & self.i.ready),
            divider.enable.eq((left != 0) & self.o.ready),
            divider.numerator.eq(self.i.payload.numerator),
            divider.denominator.eq(denominator),
            self.o.payload.quotient.eq(divider.quotient),
            self.o.payload.reached.eq(divider.reached),
        ]
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(left == 1)
        with m.If(divider.load):
            m.d.sync += [denominator.eq(self.i.payload.denominator), left.eq(QUOTIENT_BITS)]
        with m.Elif(divider.enable):
            m.d.sync += left.eq(left - 1)
        return m


def check(
    bits: int,
    numerator: Int64,
    denominator: Int64,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
) -> Capture:
    quotient = np.minimum((numerator << QUOTIENT_BITS) // denominator, 2 * HALF)
    # what the golden model makes of it
    assert np.array_equal((quotient + 1) >> 1, divide(numerator, denominator))
    return check_block(
        (Dividing, bits),
        {"i": {"numerator": numerator, "denominator": denominator}},
        {"o": {"quotient": quotient, "reached": 2 * numerator >= denominator}},
        name,
        stalls,
        clocks=Dividing.latency,
    )


def operands(bits: int, count: int, seed: int = 0) -> tuple[Int64, Int64]:
    """Divisors of every length; dividends around half of them, around every step, and above."""
    rng = np.random.default_rng([bits, seed])
    length = rng.integers(1, bits + 1, count)
    denominator = (1 << (length - 1)) + rng.integers(0, 1 << (length - 1))
    below = rng.integers(0, denominator // 2 + 1)
    step = -(-rng.integers(0, 2 * HALF + 1, count) * denominator // (4 * HALF))
    kind = np.arange(count) % 10
    choices = [
        0 * below,
        denominator // 2,
        denominator // 2 + 1,
        denominator,
        rng.integers(0, 1 << bits, count),
    ]
    choices += [step - 1, step, step + 1]
    numerator = np.select([kind == k for k in range(len(choices))], choices, below)
    return np.clip(numerator, 0, (1 << bits) - 1), denominator


@pytest.mark.parametrize("bits", WIDTHS)
def test_operands_of_every_length(bits: int) -> None:
    numerator, denominator = operands(bits, 30_000)
    check(bits, numerator, denominator)


@pytest.mark.parametrize("bits", [1, 2, 5, 8])
def test_every_pair(bits: int) -> None:
    numerator, denominator = (
        grid.reshape(-1) for grid in np.mgrid[: 1 << bits, 1 : 1 << bits].astype(np.int64)
    )
    check(bits, numerator, denominator)


@pytest.mark.parametrize("denominator", [1 << 16, (1 << 17) - 1, 99_991])
def test_every_dividend(denominator: int) -> None:
    """Operands of the used width: all up to more than half of a wide divisor."""
    numerator = np.arange(denominator // 2 + 3)
    check(USED, numerator, np.full_like(numerator, denominator))


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_stalls(name: EngineName, stalls: Stalls) -> None:
    """Clocks without enable between any two bits change nothing."""
    numerator, denominator = operands(USED, 2000 if name == "compiled" else 100)
    check(USED, numerator, denominator, name, stalls)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """0, 1/4, 1/3 = 85.3/256, just below a half, a half, and beyond."""
    cases = [(0, 5, 0, 0), (1, 4, 64, 0), (33_333, 100_000, 85, 0), (499, 1000, 127, 0), (500, 1000, 128, 1)]
    cases += [(501, 1000, 128, 1), (3, 2, 128, 1), ((1 << 17) - 1, 1, 128, 1), (1, (1 << 17) - 1, 0, 0)]
    numerator, denominator, quotient, reached = np.array(cases).T
    seen = unpack(RESULT, check(USED, numerator, denominator, name).outputs["o"])
    assert (seen["quotient"].tolist(), seen["reached"].tolist()) == (quotient.tolist(), reached.tolist())
