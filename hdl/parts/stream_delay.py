"""Delay of one stream, so that its beats meet those of a longer path."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, ShapeLike, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.parts.delay_line import DelayLine
from hdl.parts.stream import Pipeline


class StreamDelay(wiring.Component):
    """Passes a stream on some clocks later, in step with the blocks beside it.

    Parameters
    ----------
    shape
        Shape of the payload.
    clocks
        Delay in clocks, from 1.

    Members
    -------
    i, o
        Streams of ``shape``.
    """

    def __init__(self, shape: ShapeLike, clocks: int) -> None:
        self._shape = shape
        self.latency = clocks
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        # its last register stands by itself, because the line is block RAM and so far away
        m.submodules.line = line = DelayLine(len(Value.cast(self.i.payload)), self.latency - 1)
        m.d.comb += [
            line.enable.eq(pipe.advance),
            line.i.eq(self.i.payload),
            Value.cast(self.o.payload).eq(pipe.register(line.o, "last")),
            self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True)),
        ]
        return m
