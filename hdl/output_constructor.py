"""Output construction (Sec. 3.5): puts records (see ``golden.output_constructor``) together and
closes each frame.
"""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import COORDINATE_BITS, OFFSET_BITS
from golden.output_constructor import COUNT_BITS, END_OF_FRAME, FRAME_BITS, RECORD_BITS, RESPONSE_FIELD_BITS
from golden.parameters import Parameters
from hdl.candidate_selection import note_layout
from hdl.subpixel import offset_layout


def record_layout() -> data.StructLayout:
    """A record, and whether it is the frame's last (the end-of-frame record)."""
    return data.StructLayout({"record": RECORD_BITS, "last": 1})


class OutputConstructor(wiring.Component):
    """Adds each candidate's offset to its place, and counts. All of ``o`` but its ready comes from
    registers.

    Members
    -------
    note
        Stream of ``note_layout(parameters)``.
    offset
        Stream of ``offset_layout(parameters.algorithm.fit)``, one for each note but an end.
    o
        Stream of ``record_layout()``.
    found
        With ``budget`` only: corners of the frame whose end-of-frame record is on offer, not only
        those reported.
    """

    latency = 1

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        super().__init__(
            {
                "note": In(stream.Signature(note_layout(parameters))),
                "offset": In(stream.Signature(offset_layout(parameters.algorithm.fit))),
                "o": Out(stream.Signature(record_layout())),
                **({"found": Out(COUNT_BITS)} if parameters.budget else {}),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        note, offset = self.note.payload, self.offset.payload
        step, free = Signal(), Signal()
        complete = self.note.valid & (note.end | self.offset.valid)
        m.d.comb += [
            free.eq(~self.o.valid | self.o.ready),
            step.eq(complete & free),
            self.note.ready.eq(step),
            self.offset.ready.eq(step & ~note.end),
        ]

        count, frame = Signal(COUNT_BITS), Signal(FRAME_BITS)
        with m.If(step):
            m.d.sync += count.eq(count + 1)
            with m.If(note.end):
                m.d.sync += [count.eq(0), frame.eq(frame + 1)]

        x = (Cat(C(0, OFFSET_BITS), note.x) + offset.dx)[:COORDINATE_BITS]
        y = (Cat(C(0, OFFSET_BITS), note.y) + offset.dy)[:COORDINATE_BITS]
        unused = C(0, RESPONSE_FIELD_BITS - self._parameters.response_bits)
        corner = Cat(x, y, note.response, unused, offset.clamped, offset.not_maximum, note.textured)
        end = Cat(count, frame, note.response, unused, C(END_OF_FRAME, 3))
        with m.If(free):
            m.d.sync += self.o.valid.eq(complete)
        with m.If(step):
            m.d.sync += [
                self.o.payload.record.eq(Mux(note.end, end, corner)),
                self.o.payload.last.eq(note.end),
            ]
        if self._parameters.budget:
            with m.If(step & note.end):
                m.d.sync += self.found.eq(Cat(note.x, note.y))
        return m
