# amaranth: UnusedElaboratable=no
"""Connecting by name: streams with two ends, plain signals from one source to many inputs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.parts.nets import chain, connect_by_name
from hdl.parts.optional import optional
from hdl.parts.stream import SkidBuffer
from sim.stimulus import Stalls
from tests.support.blocks import ENGINES, EngineName, engine, run

BYTES = stream.Signature(8)


class Adder(wiring.Component):
    """Passes a stream on, each value with ``offset`` added."""

    def __init__(self, source: str, sink: str) -> None:
        self._source, self._sink = source, sink
        super().__init__({source: In(BYTES), sink: Out(BYTES), "offset": In(8), f"{source}_only": In(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        source, sink = getattr(self, self._source), getattr(self, self._sink)
        m.d.comb += [
            sink.valid.eq(source.valid),
            sink.payload.eq(source.payload + self.offset),
            source.ready.eq(sink.ready),
        ]
        return m


class Twice(wiring.Component):
    """Two of them: one offset for both, a stream between them, and a member that only one has."""

    def __init__(self, names: tuple[str, ...] = ()) -> None:
        self._names = names
        super().__init__({"i": In(BYTES), "o": Out(BYTES), "offset": In(8)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.first, m.submodules.second = first, second = Adder("i", "between"), Adder("between", "o")
        connect_by_name(m, wiring.flipped(self), first, second, names=self._names)
        if self._names:
            wiring.connect(m, wiring.flipped(self.i), first.i)
            wiring.connect(m, first.between, second.between)
            wiring.connect(m, second.o, wiring.flipped(self.o))
        return m


class Chained(wiring.Component):
    def __init__(self) -> None:
        super().__init__({"i": In(BYTES), "o": Out(BYTES)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules += (buffers := [SkidBuffer(8) for _ in range(3)])
        chain(m, *buffers)
        wiring.connect(m, wiring.flipped(self.i), buffers[0].i)
        wiring.connect(m, buffers[-1].o, wiring.flipped(self.o))
        return m


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("names", [(), ("offset", "absent")], ids=["all", "one"])
def test_members_of_the_same_name(name: EngineName, names: tuple[str, ...]) -> None:
    values = np.arange(100, dtype=np.uint64)
    levels = [(0, {"offset": 3})]
    run(engine(name, Twice, names), {"i": values}, {"o": values + 6}, Stalls(0.3, 0.3, 1), levels=levels)


def test_two_sources_of_one_name_are_refused() -> None:
    class Source(wiring.Component):
        def __init__(self) -> None:
            super().__init__({"level": Out(1)})

        def elaborate(self, platform: Any) -> Module:
            return Module()

    with pytest.raises(ValueError, match="too many values"):
        connect_by_name(Module(), Source(), Source())


def test_chain() -> None:
    values = np.arange(50, dtype=np.uint64)
    capture = run(engine("compiled", Chained), {"i": values}, {"o": values})
    assert (capture.output_clocks["o"] - capture.input_clocks["i"] == 3).all()


def test_optional() -> None:
    assert optional(True, a=1, b=2) == {"a": 1, "b": 2} and optional(False, a=1) == {}
