# amaranth: UnusedElaboratable=no
"""Lanes: what lies to the left is found in the same beat or in beats before, never in bubbles."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import C, Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from hdl.parts.lanes import Lanes, counting_lanes, each_lane, lane_name, lanes_of
from hdl.parts.stream import Beat, Pipeline
from sim.stimulus import Stalls
from tests.support.beats import LANES
from tests.support.blocks import NO_STALLS, check_block, tags

BACK = (0, 1, 2, 3, 5, 9)


class Before(wiring.Component):
    """Each column beside those so many columns to its left, a clock after it came in or two."""

    latency = 2

    def __init__(self, lanes: int) -> None:
        self._lanes = lanes
        column = lanes_of(8, lanes)
        found = lanes_of(8 * len(BACK), lanes)
        super().__init__({"i": In(stream.Signature(Beat(column))), "o": Out(stream.Signature(Beat(found)))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        columns = Lanes(pipe, each_lane(self.i.payload.data, self._lanes), "column").register("late")
        found = columns.map(lambda *values: Cat(*values[1:]), *map(columns.back, BACK)).register("found")
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, 2, "valid", reset=True)),
            self.o.payload.data.eq(Cat(found.values)),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, 2, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, 2, "eof")),
        ]
        return m


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.4, 0.4, 3)], ids=["unstalled", "both-stall"])
@pytest.mark.parametrize("lanes", LANES)
def test_columns_to_the_left(lanes: int, stalls: Stalls) -> None:
    """One endless row: the columns before its first are 0, as the registers begin."""
    row = np.random.default_rng(1).integers(0, 256, 40 * lanes)
    padded = np.concatenate([np.zeros(max(BACK), np.int64), row])
    found = sum(padded[max(BACK) - back : len(padded) - back] << 8 * k for k, back in enumerate(BACK))
    shape = (40, lanes) if lanes > 1 else (40,)
    ends = tags([(1, 40)])
    check_block(
        (Before, lanes),
        {"i": {"data": row.reshape(shape), **ends}},
        {"o": {"data": np.asarray(found).reshape(shape), **ends}},
        stalls=stalls,
    )


def test_values_of_different_clocks_do_not_meet() -> None:
    m = Module()
    block = Before(2)
    pipe = Pipeline(m, block.i, block.o)
    lanes = Lanes(pipe, [C(1, 4), C(2, 4)], "x")
    with pytest.raises(ValueError) as caught:
        lanes + lanes.register("y", 2)
    assert str(caught.value) == "x: values of clocks [0, 2]; allowed: of the same clock"


def test_a_beat_of_one_column_is_that_column() -> None:
    assert lanes_of(8, 1) == 8 and lane_name("x", 0, 1) == "x" and lane_name("x", 1, 2) == "x_1"


@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_counting_lanes(lanes: int) -> None:
    """The number of lanes modulo all of them, so 0 is all."""
    m, last, marks = Module(), Signal(range(lanes)), Signal(lanes)
    m.d.comb += marks.eq(Cat(counting_lanes(last, lanes)))
    seen = []

    async def bench(ctx: Any) -> None:
        for number in range(lanes):
            ctx.set(last, number)
            seen.append(ctx.get(marks))

    simulator = Simulator(m)
    simulator.add_testbench(bench)
    simulator.run()
    assert seen == [(1 << lanes) - 1, *((1 << number) - 1 for number in range(1, lanes))]
