# amaranth: UnusedElaboratable=no
"""Delay line, in delayed beats: each comes out with its own value, for any length and stalls."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from amaranth.back import rtlil
from amaranth.hdl import Module, ShapeLike, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.parts.delay_line import PART, DelayLine
from hdl.parts.stream import Pipeline
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, check_block

BITS = 21
"""More than one memory is wide."""


class StreamDelay(wiring.Component):
    """A stream passed on through a delay line, some clocks later: 1 at least."""

    def __init__(self, shape: ShapeLike, clocks: int, part: int = PART) -> None:
        self._part = part
        self.latency = clocks
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        # its last register stands by itself, because the line is block RAM and so far away
        m.submodules.line = line = DelayLine(len(Value.cast(self.i.payload)), self.latency - 1, self._part)
        m.d.comb += [
            line.enable.eq(pipe.advance),
            line.i.eq(self.i.payload),
            Value.cast(self.o.payload).eq(pipe.register(line.o, "last")),
            self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True)),
        ]
        return m


def check(clocks: int, name: EngineName, stalls: Stalls = NO_STALLS) -> None:
    count = 3000 if name == "compiled" else 150
    beats = np.random.default_rng(clocks).integers(0, 1 << BITS, count, np.uint64)
    # the last register is that of the beats
    late = clocks + 1
    check_block((StreamDelay, BITS, late), {"i": beats}, {"o": beats}, name, stalls, latency=late)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("clocks", [4, 13])
def test_stalls(clocks: int, name: EngineName, stalls: Stalls) -> None:
    check(clocks, name, stalls)


@pytest.mark.parametrize("clocks", [0, 1, 2, 3, 5, 6, 7, 10, 34])
def test_lengths(clocks: int) -> None:
    """Rings of a power of two places and others, and lines without a ring."""
    check(clocks, "amaranth", Stalls(inputs=0.3, outputs=0.4, seed=clocks))
    check(clocks, "amaranth")


@pytest.mark.parametrize(("part", "memories"), [(PART, 2), (7, 3), (8, 3), (1, BITS)])
def test_parts(part: int, memories: int) -> None:
    """Values of so many bits have a memory each, and what is left over has one of its own."""
    text = rtlil.convert(DelayLine(BITS, 5, part), emit_src=False)
    widths = [int(width) for width in re.findall(r"memory width (\d+) size 3", text)]
    assert widths == [min(part, BITS - k * part) for k in range(memories)]
    beats = np.random.default_rng(part).integers(0, 1 << BITS, 150, np.uint64)
    check_block((StreamDelay, BITS, 6, part), {"i": beats}, {"o": beats}, "amaranth", NO_STALLS, latency=6)


def test_memory_bits() -> None:
    """Two of the clocks are the memory's registers."""
    assert [DelayLine(19, clocks).memory_bits for clocks in (0, 3, 4, 14)] == [0, 0, 2 * 19, 12 * 19]


def test_negative_delay() -> None:
    with pytest.raises(ValueError, match="clocks is -1; allowed: whole numbers from 0"):
        DelayLine(1, -1)


@pytest.mark.parametrize("part", [0, PART + 1])
def test_parts_of_no_memory(part: int) -> None:
    with pytest.raises(ValueError, match=f"part is {part}; allowed: whole numbers from 1 to {PART}"):
        DelayLine(1, 4, part)
