"""The middle three rows of a larger window, delayed until the rest of it is there."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.parts.delay_line import DelayLine
from hdl.parts.stream import Columns, Pipeline, WindowCounter
from hdl.sample import response_layout, responses

CENTRE_SIZE = 3
"""Number of centre rows, of D or of a smoothed D."""


class CentreRows(wiring.Component):
    """Columns of three rows out of columns as high as the window: nine, seven or five.

    They are delayed, so that windows of both widths are complete in the same clock. Columns that
    are never next to the centre of a complete window are left out: of nine rows, the first three
    and the last three of every row.

    Members
    -------
    i
        Stream of ``Columns(response_layout(parameters), size)``.
    o
        Stream of ``Columns(response_layout(parameters), 3)``, rows size - 3 positions shorter.
    """

    latency = 2

    def __init__(self, parameters: Parameters) -> None:
        self._size = parameters.algorithm.window_size
        super().__init__(
            {
                "i": In(stream.Signature(Columns(response_layout(parameters), self._size))),
                "o": Out(stream.Signature(Columns(response_layout(parameters), CENTRE_SIZE))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        step = pipe.valid & pipe.advance
        middle = self._size // 2
        window = WindowCounter(m, self._size - 2, step=step, eol=self.i.payload.eol)
        rows = Cat(responses(self.i.payload)[middle - 1 : middle + 2])
        # moves from column to column; its last register counts as one of the two here
        m.submodules.late = late = DelayLine(len(rows), middle)
        m.d.comb += [
            late.enable.eq(step),
            late.i.eq(rows),
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            # the line is block RAM, which is far from the adders that follow
            self.o.payload.data.eq(pipe.register(late.o, "data")),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m
