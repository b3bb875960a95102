"""The columns about a candidate's centre, out of a window that is read by halves."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import WINDOW_SIZE
from hdl.build import Build
from hdl.candidate_ring import window_order
from hdl.centre_rows import CENTRE_SIZE
from hdl.parts.lanes import each_lane, lanes_of
from hdl.parts.stream import Columns, Pipeline
from hdl.sample import response_layout

CENTRE = WINDOW_SIZE // 2
"""The centre's column in its window, and its row."""


class CandidateCentres(wiring.Component):
    """Three columns of three rows out of each window, from the left.

    It takes the place of :class:`hdl.centre_rows.CentreRows` where windows are read in
    :func:`hdl.candidate_ring.window_order`. With one column per clock two of the three come from
    the left half, the third one from the right, in the same clock as in the window. With two, the
    third one comes first, and waits: it is delivered a clock after the window's last columns.

    Members
    -------
    i
        Stream of ``Columns(lanes_of(response_layout(build), build.window_reads), 9)``.
    o
        Stream of ``Columns(response_layout(build), 3)``, three to a row.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        self._order = window_order(build, WINDOW_SIZE)
        sample = response_layout(build)
        columns = Columns(lanes_of(sample, build.window_reads), WINDOW_SIZE)
        super().__init__(
            {"i": In(stream.Signature(columns)), "o": Out(stream.Signature(Columns(sample, CENTRE_SIZE)))}
        )

    @property
    def last(self) -> int:
        """Clocks from a window's last column to the last one here."""
        return 1 if self._build.window_reads == 2 else self._order.index(CENTRE + 1) - len(self._order) + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        count, eol = Signal(range(len(self._order))), self.i.payload.eol
        with m.If(pipe.valid & pipe.advance):
            m.d.sync += count.eq(Mux(eol, 0, count + 1))

        def offered(column: int) -> Value:
            return pipe.valid & (count == self._order.index(column))

        rows = self.i.payload.data[CENTRE - 1 : CENTRE + 2]
        if self._build.window_reads == 1:
            columns, ends = Cat(rows), offered(CENTRE + 1)
        else:
            left, right = (Cat(each_lane(row, 2)[k] for row in rows) for k in range(2))
            # half a window further left
            waiting = pipe.register(right, "waiting", when=offered(1))
            ends = pipe.register(pipe.valid & eol, "ends", reset=True)
            columns = Mux(ends, waiting, left)
        m.d.comb += [
            self.o.valid.eq(offered(CENTRE - 1) | offered(CENTRE) | ends),
            Value.cast(self.o.payload.data).eq(columns),
            self.o.payload.eol.eq(ends),
        ]
        return m
