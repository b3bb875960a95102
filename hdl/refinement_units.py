# amaranth: UnusedElaboratable=no
"""Several units of the subpixel refinement, where corners come faster than one can refine them."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Array, Cat, Module, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.candidate_selection import INSIDE
from hdl.fits import solved_layout
from hdl.parts.queue import Queue
from hdl.subpixel import Subpixel, offset_layout


class RefinementUnits(wiring.Component):
    """Offsets of candidates by several units, in the order of the candidates.

    A candidate goes to any unit that is free, and a queue remembers to which. If units took turns,
    those that move on in the same clocks would stay as slow as one of them.

    Members
    -------
    i, o
        As those of :class:`Subpixel`.
    """

    def __init__(self, build: Build) -> None:
        self._units = [Subpixel(build, bits_per_clock=build.refinement_bits) for _ in range(build.units)]
        super().__init__(
            {
                "i": In(stream.Signature(solved_layout(build))),
                "o": Out(stream.Signature(offset_layout(build.algorithm.fit))),
            }
        )

    inside = Subpixel.inside

    @property
    def interval(self) -> int:
        """Clocks from one candidate to the next where many wait, on average and rounded up."""
        return -(-self._units[0].interval // len(self._units))

    @property
    def latency(self) -> int:
        """Clocks from a candidate that finds all units idle to its offset."""
        return self._units[0].latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        count = len(self._units)
        m.submodules.order = order = Queue(range(count), count * INSIDE)
        taking, free = Signal(range(count)), Cat(unit.i.ready for unit in self._units)
        for k in reversed(range(count)):
            with m.If(free[k]):
                m.d.comb += taking.eq(k)
        taken = self.i.valid & self.i.ready
        giving = order.o.payload
        for k, unit in enumerate(self._units):
            m.submodules[f"unit_{k}"] = unit
            m.d.comb += [
                unit.i.payload.eq(self.i.payload),
                unit.i.valid.eq(self.i.valid & (taking == k)),
                unit.o.ready.eq(self.o.ready & order.o.valid & (giving == k)),
            ]
        m.d.comb += [
            self.i.ready.eq(free.any()),
            order.i.valid.eq(taken),
            order.i.payload.eq(taking),
            order.o.ready.eq(self.o.valid & self.o.ready),
            self.o.valid.eq(order.o.valid & Array(unit.o.valid for unit in self._units)[giving]),
            Value.cast(self.o.payload).eq(Array(Value.cast(unit.o.payload) for unit in self._units)[giving]),
        ]
        return m
