# amaranth: UnusedElaboratable=no
"""Elastic queue: what is under way always finds a place, and leaves in order."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.asserts import AnySeq
from amaranth.hdl import Assert, Assume, Elaboratable, Module, Mux, Signal

import hdl.parts.elastic_queue
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of, stored, variant
from tests.formal.properties import Scoreboard, free, invariant, moves, stable

BITS = 4


class ElasticChecker(Elaboratable):
    """Half of its places are for what is under way, as many as it allows."""

    def __init__(self, design: Any) -> None:
        self._design = design

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        places = self._design.PLACES
        under_way = places // 2
        m.submodules.dut = dut = self._design.ElasticQueue(BITS, under_way)
        inside = probes_of(dut)
        free(m, dut, but={"i.valid"})
        # beats begin only with room, and arrive at any time: more than a pipeline can do
        begins, number = Signal(), Signal(range(under_way + 1))
        m.d.comb += [begins.eq(AnySeq(1) & dut.room), dut.i.valid.eq(AnySeq(1) & (number != 0))]
        m.d.comb += Assume(~begins | dut.i.valid | (number < under_way))
        m.d.sync += number.eq(number + begins - dut.i.valid)
        stable(m, dut.o, "o")
        board = Scoreboard(
            m,
            "i to o",
            enters=dut.i.valid,
            given=dut.i.payload,
            leaves=moves(dut.o),
            found=dut.o.payload,
            capacity=places + 2,
            fills=False,
        )
        board.leaves_within(3, dut.o.ready)

        write, read, level = (inside[name] for name in ("write", "read", "level"))
        m.d.comb += Assert(level <= places, "more is in the memory than it has places")
        invariant(m, number <= under_way, "more is under way than can be")
        invariant(m, level + number + dut.room < places, "what is under way has no place")
        invariant(m, write.addr == (read.addr + level)[: len(read.addr)], "places and beats differ")
        registers = inside["read_out"] + dut.o.valid
        invariant(m, board.inside == level + registers, "level and beats differ")
        kept = stored(m, inside["memory"], (read.addr + board.ahead - registers)[: len(read.addr)])
        found = Mux(board.ahead < dut.o.valid, dut.o.payload, Mux(board.ahead < registers, read.data, kept))
        invariant(m, ~board.following | (found == board.value), "another beat is in the queue")
        return m


ELASTIC = Claim(
    says="ElasticQueue: nothing is lost where beats begin only with room",
    design=hdl.parts.elastic_queue,
    small=variant(hdl.parts.elastic_queue, {"PLACES = 128": "PLACES = 8"}),
    long_proof=True,
    check=ElasticChecker,
    depth=3,
    covered=12,
    faults=(
        Fault("PLACES - under_way - 2", "PLACES - under_way", "more is in the memory", within=16),
        Fault("self.i.valid ^ taken", "self.i.valid | taken", "does not leave", within=10),
        Fault("read.en.eq(moves)", "read.en.eq(1)", "another beat", within=12),
        Fault("moves.eq(~self.o.valid | self.o.ready)", "moves.eq(1)", "payload changes", within=8),
    ),
)


@pytest.mark.parametrize("case", cases(ELASTIC))
def test_elastic_queue(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
