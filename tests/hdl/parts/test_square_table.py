# amaranth: UnusedElaboratable=no
"""Squares by look-up and by multipliers: every number of every width, both ports, under stalls."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from hdl.parts.square_table import SquareTable
from hdl.parts.squarer import LATENCY, make_squarer
from hdl.parts.stream import Pipeline
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, check_block

KINDS = {"table": {}, "table with bit 0": {"stores_odd": True}, "multipliers": {"multiplies": True}}


class Squares(wiring.Component):
    """The table, or two multipliers, inside a pipeline."""

    def __init__(self, bits: int, signed_numbers: bool, kind: str = "table") -> None:
        self.table = make_squarer(bits, signed_numbers=signed_numbers, **KINDS[kind])
        super().__init__(
            {
                "i": In(stream.Signature(self.table.x.shape())),
                "o": Out(stream.Signature(self.table.square.shape())),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        m.submodules.table = self.table
        m.d.comb += [
            self.table.enable.eq(pipe.advance),
            self.table.x.eq(self.i.payload),
            self.o.payload.eq(self.table.square),
            self.o.valid.eq(pipe.delay(pipe.valid, self.table.latency, "valid", reset=True)),
        ]
        return m


def check(
    bits: int,
    signed_numbers: bool,
    pairs: NDArray[np.int64],
    name: EngineName,
    stalls: Stalls = NO_STALLS,
    *,
    kind: str = "table",
) -> None:
    block, late = (Squares, bits, signed_numbers, kind), LATENCY
    check_block(block, {"i": pairs}, {"o": pairs**2}, name, stalls, latency=late)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    ("bits", "signed_numbers"), [*((n, False) for n in range(2, 12)), *((n, True) for n in range(3, 12))]
)
def test_every_number(bits: int, signed_numbers: bool, kind: str) -> None:
    """At one port counting up, at the other in no order."""
    low = 1 - (1 << (bits - 1)) if signed_numbers else 0
    numbers = np.arange(low, (1 << (bits - signed_numbers)))
    pairs = np.stack([numbers, np.random.default_rng(bits).permutation(numbers)], axis=1)
    check(bits, signed_numbers, pairs, "amaranth", kind=kind)


@pytest.mark.parametrize("kind", ["table", "multipliers"])
@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_stalls(name: EngineName, stalls: Stalls, kind: str) -> None:
    count = 3000 if name == "compiled" else 200
    check(8, False, np.random.default_rng(1).integers(0, 256, (count, 2)), name, stalls, kind=kind)


def test_memory_bits() -> None:
    """14 of 16 bits of 256 squares, or 15; 6 of 8 bits of 16; signed, 14 of 16 bits of 512."""
    assert SquareTable(8).memory_bits == 14 * 256
    assert SquareTable(8, stores_odd=True).memory_bits == 15 * 256
    assert SquareTable(4).memory_bits == 6 * 16
    assert SquareTable(9, signed_numbers=True).memory_bits == 14 * 512
    assert make_squarer(9, multiplies=True).memory_bits == 0


@pytest.mark.parametrize(("signed_numbers", "fewest"), [(False, 2), (True, 3)])
def test_too_narrow(signed_numbers: bool, fewest: int) -> None:
    with pytest.raises(ValueError, match=f"allowed: whole numbers from {fewest}"):
        SquareTable(fewest - 1, signed_numbers=signed_numbers)
