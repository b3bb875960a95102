"""Response filter of several columns per clock: rows of S out of two rows more of D."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.centre_rows import CENTRE_SIZE
from hdl.parts.lanes import Lanes, each_lane
from hdl.parts.stream import Columns, Pipeline
from hdl.pixel_filter import outer_sum, with_middle
from hdl.sample import responses_shape

SMOOTHED_ROWS = CENTRE_SIZE + 2
"""Rows of D that three rows of S need."""
ROWS_LOST = SMOOTHED_ROWS - CENTRE_SIZE
VALUES_LATENCY = 4


class SmoothedBeats(wiring.Component):
    """S (``golden.response_filter``) of each lane, for a search of peaks in lanes.

    A lane holds S of the place one column before and one row above its newest response. Every beat
    that comes in goes out: the first two columns of a row are meaningless.

        clock 1   a + c down the column
        clock 2   and 2b
        clock 3   the same along the row: pairs of neighbours
        clock 4   pairs of these

    No two sums meet in one clock.

    Parameters
    ----------
    build
        Parameters of the detector.
    rows
        Rows of S.
    tags_first
        A beat's tags come out a clock before its values, as ``CircularBuffer`` may take them.

    Members
    -------
    i
        Stream of ``Columns`` of beats of responses, two rows more.
    permit
        A beat may be taken.
    o
        Stream of ``Columns`` of beats of responses.
    """

    def __init__(self, build: Build, rows: int = CENTRE_SIZE, *, tags_first: bool = False) -> None:
        self._lanes, self._rows = build.pixels_per_clock, rows
        self.latency = VALUES_LATENCY - tags_first
        column = responses_shape(build)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(column, rows + ROWS_LOST))),
                "permit": In(1),
                "o": Out(stream.Signature(Columns(column, rows))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.permit)
        rows = [
            Lanes(pipe, [sample.response for sample in each_lane(row, self._lanes)], f"row_{k}")
            for k, row in enumerate(self.i.payload.data)
        ]
        middle = [row.register(f"middle_{k}") for k, row in enumerate(rows[1:-1])]
        for k in range(self._rows):
            outer = rows[k].map(outer_sum, rows[k + 2]).register(f"outer_{k}")
            down = outer.map(with_middle, middle[k]).register(f"down_{k}")
            pair = (down + down.back(1)).register(f"pair_{k}")
            smoothed = (pair + pair.back(1))[4:].register(f"smoothed_{k}")
            for sample, value in zip(
                each_lane(self.o.payload.data[k], self._lanes), smoothed.values, strict=True
            ):
                m.d.comb += sample.response.eq(value)
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True)),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m
