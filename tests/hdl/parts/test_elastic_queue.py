# amaranth: UnusedElaboratable=no
"""The queue behind a pipeline that never stops: in order, at full rate, and nothing is lost."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.parts.elastic_queue import PLACES, ElasticQueue
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import RUN_IDS, RUNS, check_block

BITS = 16
LONG = Stalls(0.0, 0.98, 3)


class Behind(wiring.Component):
    """So many registers without enable, and the queue."""

    def __init__(self, clocks: int) -> None:
        self._clocks = clocks
        self.latency = clocks + ElasticQueue.latency
        super().__init__({"i": In(stream.Signature(BITS)), "o": Out(stream.Signature(BITS))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.queue = queue = ElasticQueue(BITS, self._clocks)
        m.d.comb += self.i.ready.eq(queue.room)
        valid, value = self.i.valid & queue.room, self.i.payload
        for k in range(self._clocks):
            valid_late, value_late = Signal(name=f"valid_{k}"), Signal(BITS, name=f"value_{k}")
            m.d.sync += [valid_late.eq(valid), value_late.eq(value)]
            valid, value = valid_late, value_late
        m.d.comb += [queue.i.valid.eq(valid), queue.i.payload.eq(value)]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m


@pytest.mark.parametrize(("name", "stalls"), [*RUNS, ("amaranth", LONG)], ids=[*RUN_IDS, "amaranth-full"])
@pytest.mark.parametrize("clocks", [0, 1, 29, PLACES // 2])
def test_nothing_is_lost(clocks: int, name: EngineName, stalls: Stalls) -> None:
    """A sink that hardly ever takes anything fills it up."""
    count = 3000 if name == "compiled" else 250
    beats = np.random.default_rng(0).integers(0, 1 << BITS, count, np.uint64)
    check_block((Behind, clocks), {"i": beats}, {"o": beats}, name, stalls, latency=clocks + 3)


def test_more_under_way_than_it_is_for() -> None:
    with pytest.raises(ValueError, match=f"under_way is 65; allowed: whole numbers up to {PLACES // 2}"):
        ElasticQueue(BITS, 65)
