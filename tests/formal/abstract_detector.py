# amaranth: UnusedElaboratable=no
"""Anything that keeps the detector's contract: what its edges may rely on, and nothing else."""

from __future__ import annotations

from typing import Any

from amaranth.asserts import AnySeq
from amaranth.hdl import Assume, Module, Mux, Signal, Value
from amaranth.lib import wiring

from hdl.build import Build
from hdl.detector import Detector
from tests.formal.frames import Place, in_beats
from tests.formal.properties import assume_stable, moves
from tests.formal.test_packet_constructor import ends

LATE = 2
"""Clocks with its output ready in which it takes a pixel, and in which it ends a frame that is
complete.

The real one takes some hundreds. The number decides only how far a proof must look ahead.
"""


class AbstractDetector(wiring.Component):
    """Has the members of ``Detector(build)``. Its outputs are arbitrary, but keep these rules:

    - a record stays until it is taken; ``last`` is with the end-of-frame record, and only there;
    - a record comes only when a frame has begun, and an end only when a frame is complete, with
      width · height pixels as sampled with the first, and has not had its end;
    - not more than ``most`` complete frames wait inside for their end;
    - while the output is ready, it ends a complete frame every ``LATE`` clocks, and takes a pixel
      as often, except when ``most`` frames wait.

    Attributes
    ----------
    pending
        Complete frames inside.
    place, size
        Where in its frame the next pixel is, and the size of that frame once it has begun.
    """

    def __init__(self, parameters: Build, most: int) -> None:
        self._lanes = parameters.pixels_per_clock
        self._most = most
        self.pending = Signal(range(most + 2))
        self.size = {"x": Signal(16), "y": Signal(16)}
        super().__init__(dict(Detector(parameters).signature.members.items()))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        i, o = self.i, self.o
        record = Value.cast(o.payload)
        m.d.comb += [i.ready.eq(AnySeq(1)), o.valid.eq(AnySeq(1)), record.eq(AnySeq(len(record)))]
        assume_stable(m, o, "records")
        first = Signal()
        given = {"x": self.width, "y": self.height}
        now = {axis: Mux(first, given[axis], size) for axis, size in self.size.items()}
        self.place = place = Place(m, "fed", in_beats(now["x"], self._lanes), now["y"], moves(i))
        m.d.comb += first.eq(place.first)
        with m.If(moves(i) & first):
            m.d.sync += [size.eq(given[axis]) for axis, size in self.size.items()]
        complete = moves(i) & place.eol & place.last_row
        ended = moves(o) & o.payload.last
        m.d.sync += self.pending.eq(self.pending + complete - ended)
        m.d.comb += [
            Assume(o.payload.last == ends(o.payload.record)),
            Assume(~o.valid | (self.pending != 0) | (~o.payload.last & ~first)),
            Assume(~complete | (self.pending < self._most)),
        ]
        for name, owes, does in (
            ("pixel", i.valid & (self.pending < self._most), i.ready),
            ("end", self.pending != 0, ended),
        ):
            owed = Signal(range(LATE + 1), name=f"owes_{name}")
            with m.If(does | ~owes):
                m.d.sync += owed.eq(0)
            with m.Elif(o.ready):
                m.d.sync += owed.eq(owed + 1)
            m.d.comb += Assume(~(owes & o.ready & ~does & (owed >= LATE - 1)))
        return m
