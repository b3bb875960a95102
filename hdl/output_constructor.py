"""Output construction (Sec. 3.5): makes records (``golden.output_constructor``), closes frames."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import COORDINATE_BITS, OFFSET_BITS
from golden.output_constructor import COUNT_BITS, END_OF_FRAME, FRAME_BITS, RECORD_BITS, RESPONSE_FIELD_BITS
from golden.parameters import Parameters
from hdl.candidate_selection import pending_record_layout
from hdl.cell_grid import cell_layout
from hdl.parts.optional import optional
from hdl.parts.probes import probe
from hdl.subpixel import offset_layout


def record_layout() -> data.StructLayout:
    """A record, and whether it is the frame's last (the end-of-frame record)."""
    return data.StructLayout({"record": RECORD_BITS, "last": 1})


def found_record_layout(parameters: Parameters) -> data.StructLayout:
    """A record as it is found, and whether it is the frame's last.

    With ``max_per_cell`` also its ``cell_layout(parameters)``. The number in an end-of-frame record
    is then that of the corners found, and what ends a row of cells has no record.
    """
    return data.StructLayout(
        {
            "record": RECORD_BITS,
            "last": 1,
            **optional(parameters.max_per_cell > 0, cell=cell_layout(parameters)),
        }
    )


class OutputConstructor(wiring.Component):
    """Adds each candidate's offset to its place, and counts.

    All of ``o`` except its ready comes from registers.

    Members
    -------
    pending
        Stream of ``pending_record_layout(parameters)``.
    offset
        Stream of ``offset_layout(parameters.algorithm.fit)``, one for each pending record except
        ends.
    o
        Stream of ``found_record_layout(parameters)``.
    found
        With ``budget``, but not with ``max_per_cell``: corners of the frame whose end-of-frame
        record is on offer, not only those reported.
    """

    latency = 1

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        super().__init__(
            {
                "pending": In(stream.Signature(pending_record_layout(parameters))),
                "offset": In(stream.Signature(offset_layout(parameters.algorithm.fit))),
                "o": Out(stream.Signature(found_record_layout(parameters))),
                **optional(parameters.budget and not parameters.max_per_cell, found=Out(COUNT_BITS)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pending, offset = self.pending.payload, self.offset.payload
        step, free = Signal(), Signal()
        budget, cells = self._parameters.budget, self._parameters.max_per_cell > 0
        closes = pending.end | pending.cell.row_end if cells else pending.end
        complete = self.pending.valid & (closes | self.offset.valid)
        m.d.comb += [
            free.eq(~self.o.valid | self.o.ready),
            step.eq(complete & free),
            self.pending.ready.eq(step),
            self.offset.ready.eq(step & ~closes),
        ]

        count, frame = Signal(COUNT_BITS), Signal(FRAME_BITS)
        with m.If(step & ~closes):
            m.d.sync += count.eq(count + 1)
        with m.If(step & pending.end):
            m.d.sync += [count.eq(0), frame.eq(frame + 1)]

        x = (Cat(C(0, OFFSET_BITS), pending.x) + offset.dx)[:COORDINATE_BITS]
        y = (Cat(C(0, OFFSET_BITS), pending.y) + offset.dy)[:COORDINATE_BITS]
        unused = C(0, RESPONSE_FIELD_BITS - self._parameters.response_bits)
        corner = Cat(x, y, pending.response, unused, offset.clamped, offset.not_maximum, pending.textured)
        found = Cat(pending.x, pending.y)[:COUNT_BITS]
        number = found if cells and budget else count
        end = Cat(number, frame, pending.response, unused, C(END_OF_FRAME, 3))
        with m.If(free):
            m.d.sync += self.o.valid.eq(complete)
        with m.If(step):
            m.d.sync += [
                self.o.payload.record.eq(Mux(pending.end, end, corner)),
                self.o.payload.last.eq(pending.end),
            ]
        if cells:
            with m.If(step):
                m.d.sync += self.o.payload.cell.eq(pending.cell)
        elif budget:
            with m.If(step & pending.end):
                m.d.sync += self.found.eq(found)
        probe(self, count=count, frame=frame)
        return m
