"""Response filter: middle rows of D smoothed by [1 2 1]ᵀ[1 2 1] / 16, in place of centre rows."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.centre_rows import CENTRE_SIZE
from hdl.parts.stream import Columns, Pipeline, WindowCounter
from hdl.pixel_filter import binomial
from hdl.sample import response_layout, responses


class ResponseFilter(wiring.Component):
    """S (``golden.response_filter``) of the middle rows, in place of D.

    It is delayed, so that windows of both widths are complete in the same clock. It does what
    :class:`hdl.centre_rows.CentreRows` does, in the same clocks, with S instead of D.

        clock 1   a + 2b + c down the column
        clock 2   the same along the row: pairs of neighbours, and pairs of these

    Members
    -------
    i
        Stream of ``Columns(response_layout(parameters), size)``, as high as the algorithm's window.
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
        step, reach = pipe.valid & pipe.advance, CENTRE_SIZE // 2
        window = WindowCounter(m, self._size - 2 * reach, step=step, eol=self.i.payload.eol)
        beat, rows = pipe.register(pipe.valid, "beat", reset=True), responses(self.i.payload)
        middle = self._size // 2
        # S of a column needs the next column's D, so it comes one late by itself
        columns_late = middle - reach - 1
        for k, row in enumerate(range(middle - reach, middle + reach + 1)):
            down = pipe.register(binomial(*rows[row - 1 : row + 2]), f"down_{k}")
            pair = down + pipe.register(down, f"down_before_{k}", when=beat)
            smoothed = (pair + pipe.register(pair, f"pair_before_{k}", when=beat))[4:]
            for late in range(columns_late + 1):
                smoothed = pipe.register(smoothed, f"smoothed_{k}_{late}", when=beat)
            m.d.comb += self.o.payload.data[k].response.eq(smoothed)
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m
