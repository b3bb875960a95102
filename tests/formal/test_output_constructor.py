# amaranth: UnusedElaboratable=no
"""Output constructor: one record that counts the others closes each frame, and none is lost."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Assert, Assume, Cat, Const, Cover, Elaboratable, Module, Mux, Signal

import hdl.output_constructor
from golden.formats import COORDINATE_BITS, OFFSET_BITS
from golden.output_constructor import COUNT_BITS, FLAG_SHIFT, FRAME_BITS, RESPONSE_SHIFT
from hdl.build import Build
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of
from tests.formal.properties import Scoreboard, assume_stable, free, invariant, moves, stable, within

PARAMETERS = Build.profile("paper")
CLAMPED_AND_NOT_MAXIMUM = 3
"""The two flags that together mark an end of frame; no offset has both."""


class OutputConstructorChecker(Elaboratable):
    def __init__(self, design: Any) -> None:
        self._design = design

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.OutputConstructor(PARAMETERS)
        inside = probes_of(dut)
        free(m, dut)
        for name in ("pending", "offset"):
            assume_stable(m, getattr(dut, name), name)
        stable(m, dut.o, "o")
        pending, offset, o = dut.pending.payload, dut.offset.payload, dut.o.payload
        m.d.comb += Assume(~(offset.clamped & offset.not_maximum))

        # one input beat of each kind that a pending record needs
        m.d.comb += [
            Assert(
                moves(dut.offset) == (moves(dut.pending) & ~pending.end),
                "offsets and pending records get out of step",
            ),
        ]
        response = o.record[RESPONSE_SHIFT:FLAG_SHIFT]
        places = [
            ((pending[axis] << OFFSET_BITS) + offset[f"d{axis}"])[:COORDINATE_BITS].as_unsigned()
            for axis in ("x", "y")
        ]
        flags = Cat(offset.clamped, offset.not_maximum, pending.textured)
        unused = Const(0, len(response) - PARAMETERS.response_bits)
        corner = Cat(*places, pending.response, unused, flags)
        board = Scoreboard(
            m,
            "records",
            enters=moves(dut.pending),
            given=Cat(pending.end, Mux(pending.end, pending.response, corner)),
            leaves=moves(dut.o),
            found=Cat(o.last, Mux(o.last, response, o.record)),
            capacity=1,
        )
        board.leaves_within(1, dut.o.ready)
        within(
            m,
            1,
            during=dut.pending.valid & (pending.end | dut.offset.valid) & dut.o.ready,
            happens=dut.pending.ready,
            name="pending: a beat is not accepted",
        )

        # what has come out
        records, frames = Signal(COUNT_BITS), Signal(FRAME_BITS)
        with m.If(moves(dut.o)):
            m.d.sync += [records.eq(Mux(o.last, 0, records + 1)), frames.eq(frames + o.last)]
        marked = o.record[FLAG_SHIFT : FLAG_SHIFT + 2] == CLAMPED_AND_NOT_MAXIMUM
        with m.If(dut.o.valid):
            m.d.comb += Assert(o.last == marked, "last and the mark of a frame's end differ")
            with m.If(o.last):
                m.d.comb += [
                    Assert(o.record[:COUNT_BITS] == records, "an end counts other records than came out"),
                    Assert(o.record[COUNT_BITS:][:FRAME_BITS] == frames, "frames are numbered otherwise"),
                ]
        m.d.comb += [
            Cover(moves(dut.o) & o.last & (records == 2), "a frame with two records"),
            Cover(moves(dut.o) & o.last & (records == 0) & (frames == 1), "a frame without any"),
        ]

        invariant(m, board.inside == dut.o.valid, "beats and valid differ")
        with m.If(board.following):
            invariant(m, board.value == board.found, "another record waits at the output")
        ends = dut.o.valid & o.last
        invariant(m, inside["count"] == Mux(ends, 0, records + dut.o.valid)[:COUNT_BITS], "counts differ")
        invariant(m, inside["frame"] == (frames + ends)[:FRAME_BITS], "frame numbers differ")
        return m


RECORDS = Claim(
    says="OutputConstructor: records, ends of frames, their counts and numbers, stream rules",
    design=hdl.output_constructor,
    check=OutputConstructorChecker,
    depth=1,
    covered=8,
    faults=(
        Fault(
            "m.d.sync += count.eq(count + 1)",
            "m.d.sync += count.eq(count + self.o.ready)",
            "an end counts",
            10,
        ),
        Fault("frame.eq(frame + 1)", "frame.eq(frame + (count != 0))", "frames are numbered", 10),
        Fault(
            "m.d.sync += self.o.valid.eq(complete)",
            "m.d.sync += self.o.valid.eq(self.pending.valid)",
            "records: ",
            8,
        ),
        Fault("pending.response, unused, C(END", "0, unused, C(END", "records: ", 8),
    ),
)


@pytest.mark.parametrize("case", cases(RECORDS))
def test_output_constructor(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
