# amaranth: UnusedElaboratable=no
"""Several units of the subpixel refinement, where corners come faster than one can refine them."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Array, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.fits import solved_layout
from hdl.subpixel import Subpixel, offset_layout


class RefinementUnits(wiring.Component):
    """Offsets of candidates by units that take them in turn, so that they keep their order.

    A unit that is not free is waited for, even if another one is: all take equally long.

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
        taking, giving = Signal(range(count)), Signal(range(count))
        for k, unit in enumerate(self._units):
            m.submodules[f"unit_{k}"] = unit
            m.d.comb += [
                unit.i.payload.eq(self.i.payload),
                unit.i.valid.eq(self.i.valid & (taking == k)),
                unit.o.ready.eq(self.o.ready & (giving == k)),
            ]
        m.d.comb += [
            self.i.ready.eq(Array(unit.i.ready for unit in self._units)[taking]),
            self.o.valid.eq(Array(unit.o.valid for unit in self._units)[giving]),
            Value.cast(self.o.payload).eq(Array(Value.cast(unit.o.payload) for unit in self._units)[giving]),
        ]
        for turn, port in ((taking, self.i), (giving, self.o)):
            with m.If(port.valid & port.ready):
                m.d.sync += turn.eq(Mux(turn == count - 1, 0, turn + 1))
        return m
