# amaranth: UnusedElaboratable=no
"""Skid buffer, queue and pipelines keep the rules of streams, for all inputs and for all times."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Assert, Assume, Elaboratable, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

import hdl.parts.queue
import hdl.parts.stream
from hdl.parts.probes import probe
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of
from tests.formal.properties import (
    Scoreboard,
    accepts_within,
    assume_stable,
    free,
    invariant,
    moves,
    stable,
    stream_rules,
)
from tests.formal.queues import queue_holds

BITS = 4


class SkidChecker(Elaboratable):
    def __init__(self, design: Any, *, closed_in_reset: bool = False) -> None:
        self._design = design
        self._closed = closed_in_reset

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.SkidBuffer(BITS, closed_in_reset=self._closed)
        inside = probes_of(dut)
        free(m, dut)
        board = stream_rules(m, dut.i, dut.o, capacity=2, leaves=1, accepts=2)
        full, ready = inside["first_full"], inside["ready"]
        awake = Signal(init=not self._closed)
        m.d.sync += awake.eq(1)
        m.d.comb += Assert(awake | ~dut.i.ready, "i: ready in reset")
        invariant(m, full | ready | ~awake, "the spare is full behind an empty first place")
        invariant(m, board.inside == full + (full & ~ready), "places and beats differ in number")
        for ahead, place in enumerate(("first", "spare")):
            with m.If(board.following & (board.ahead == ahead)):
                invariant(m, inside[place] == board.value, f"another beat is in the {place} place")
        return m


SKID = Claim(
    says="SkidBuffer: stream rules",
    design=hdl.parts.stream,
    check=SkidChecker,
    depth=2,
    covered=8,
    faults=(
        Fault("~ready | self.i.valid", "self.i.valid", "does not leave", within=8),
        Fault(
            "with m.If(ready):\n            m.d.sync += spare",
            "if True:\n            m.d.sync += spare",
            "another beat",
            within=8,
        ),
        Fault(
            "with m.If(self.o.ready | ~first_full):",
            "with m.If(self.o.ready | ready):",
            "payload changes",
            within=8,
        ),
    ),
)
CLOSED = Claim(
    says="SkidBuffer, closed in reset: stream rules, and nothing is taken in reset",
    design=hdl.parts.stream,
    check=lambda design: SkidChecker(design, closed_in_reset=True),
    depth=2,
    covered=8,
    faults=(
        Fault("Mux(ready, self.i.valid, first_full) if self._closed else ", "", "that never went in", 8),
        Fault("Signal(init=not self._closed)", "Signal(init=1)", "in reset", within=2),
    ),
)


class QueueChecker(Elaboratable):
    """The source reads ``room`` a clock late, and may have one more beat, as documented."""

    def __init__(self, design: Any, depth: int) -> None:
        self._design = design
        self._depth = depth

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.Queue(BITS, self._depth)
        inside = probes_of(dut)
        free(m, dut)
        late, one_more = Signal(init=1), Signal()
        m.d.sync += [late.eq(dut.room), one_more.eq(late & dut.i.valid)]
        m.d.comb += Assume(~dut.i.valid | late | one_more)
        stable(m, dut.o, "o")
        board = Scoreboard(
            m,
            "i to o",
            enters=dut.i.valid,
            given=dut.i.payload,
            leaves=moves(dut.o),
            found=dut.o.payload,
            capacity=self._depth + 1,
        )
        board.leaves_within(2, dut.o.ready)
        queue_holds(m, dut, inside, board, self._depth)
        return m


def _queue(depth: int) -> Callable[[Any], Elaboratable]:
    return lambda design: QueueChecker(design, depth)


QUEUES = [
    Claim(
        says=f"Queue of {depth}: nothing is lost where room is heeded",
        design=hdl.parts.queue,
        check=_queue(depth),
        depth=4,
        covered=depth + 6,
        faults=faults,
    )
    for depth, faults in {
        3: (
            Fault(
                "level <= self._depth - ROOM", "level <= self._depth - ROOM + 1", "more is inside", within=10
            ),
        ),
        5: (
            Fault("read.en.eq(free)", "read.en.eq(1)", "payload changes", within=8),
            Fault(
                "Mux(port.addr == self._depth - 1, 0,",
                "Mux(port.addr == self._depth, 0,",
                "another beat",
                within=12,
            ),
        ),
        16: (Fault("free & (level != 0)", "free & (level > 1)", "does not leave", within=8),),
    }.items()
]


class TwoRegisters(wiring.Component):
    """A pipeline that a permission stops."""

    def __init__(self, design: Any) -> None:
        self._design = design
        port = stream.Signature(BITS)
        super().__init__({"i": In(port), "permit": In(1), "o": Out(port)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = self._design.Pipeline(m, self.i, self.o, permit=self.permit)
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, 2, "valid", reset=True)),
            self.o.payload.eq(pipe.delay(self.i.payload, 2, "data")),
        ]
        probe(self, **pipe.registers)
        return m


class PipelineChecker(Elaboratable):
    def __init__(self, design: Any) -> None:
        self._design = design

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = TwoRegisters(self._design)
        inside = probes_of(dut)
        free(m, dut)
        # with the permission, it is as any block
        assume_stable(m, dut.i, "i")
        stable(m, dut.o, "o")
        accepts_within(m, 1, dut.i, during=dut.o.ready & dut.permit, name="i")
        board = Scoreboard(
            m,
            "i to o",
            enters=moves(dut.i),
            given=dut.i.payload,
            leaves=moves(dut.o),
            found=dut.o.payload,
            capacity=2,
        )
        board.leaves_within(2, dut.o.ready)
        first, second = inside["valid_1"], inside["valid_2"]
        invariant(m, board.inside == first + second, "registers and beats differ in number")
        ahead = Mux(second, board.ahead, board.ahead + 1)
        for k, name in enumerate(("data_2", "data_1")):
            with m.If(board.following & (ahead == k)):
                invariant(m, inside[name] == board.value, f"another beat is in {name}")
        return m


PIPELINE = Claim(
    says="Pipeline of two registers with a permission: stream rules",
    design=hdl.parts.stream,
    check=PipelineChecker,
    depth=1,
    covered=6,
    faults=(
        Fault("i.ready.eq(self.advance & permit)", "i.ready.eq(self.advance)", "does not leave", within=6),
        Fault("with self._m.If(self.advance if", "with self._m.If(1 if", "i to o: ", within=6),
    ),
)


@pytest.mark.parametrize("case", cases(SKID, CLOSED, *QUEUES, PIPELINE))
def test_buffers(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
