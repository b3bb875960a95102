# amaranth: UnusedElaboratable=no
"""Squares by look-up: every number of every width, at both ports, under stalls."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from hdl.square_table import SquareTable
from hdl.stream import Pipeline
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.hdl.blocks import NO_STALLS, RUN_IDS, RUNS, assert_timing, engine, pack, run

WIDTHS = range(3, 12)


class Squares(wiring.Component):
    """The table inside a pipeline."""

    def __init__(self, bits: int) -> None:
        self.table = SquareTable(bits)
        super().__init__(
            {
                "i": In(stream.Signature(data.ArrayLayout(bits, 2))),
                "o": Out(stream.Signature(data.ArrayLayout(2 * bits, 2))),
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


def check(bits: int, pairs: NDArray[np.int64], name: EngineName, stalls: Stalls = NO_STALLS) -> None:
    block = Squares(bits)
    inputs = {"i": pack(block.i.payload.shape(), pairs)}
    capture = run(engine(name, Squares, bits), inputs, {"o": pack(block.o.payload.shape(), pairs**2)}, stalls)
    if stalls == NO_STALLS:
        assert_timing(capture, SquareTable.latency)


@pytest.mark.parametrize("bits", WIDTHS)
def test_every_number(bits: int) -> None:
    """At one port counting up, at the other in no order."""
    numbers = np.arange(1 << bits)
    check(bits, np.stack([numbers, np.random.default_rng(bits).permutation(numbers)], axis=1), "amaranth")


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_stalls(name: EngineName, stalls: Stalls) -> None:
    count = 3000 if name == "compiled" else 200
    check(8, np.random.default_rng(1).integers(0, 256, (count, 2)), name, stalls)


def test_memory_bits() -> None:
    """11 of 16 bits of 256 squares; 3 of 8 bits of 16."""
    assert SquareTable(8).memory_bits == 11 * 256
    assert SquareTable(4).memory_bits == 3 * 16


def test_too_narrow() -> None:
    with pytest.raises(ValueError, match="bits is 2; allowed: whole numbers from 3"):
        SquareTable(2)
