"""Watchdog: notices that something waits for too long."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.edges.register_map import TIMEOUT_BITS


class Watchdog(wiring.Component):
    """Counts the clocks of each wait.

    Members
    -------
    waiting
        Something waits.
    limit
        Clocks; 0: for ever.
    expired
        It has waited so long: once, for one clock, in each wait.
    """

    def __init__(self) -> None:
        super().__init__({"waiting": In(1), "limit": In(TIMEOUT_BITS), "expired": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        waited, over = Signal(TIMEOUT_BITS), Signal()
        reached = Signal()
        m.d.comb += reached.eq((waited == self.limit) & (self.limit != 0) & ~over)
        with m.If(~self.waiting):
            m.d.sync += [waited.eq(0), over.eq(0)]
        with m.Elif(~over):
            m.d.sync += [waited.eq(waited + 1), over.eq(reached)]
        m.d.sync += self.expired.eq(reached & self.waiting)
        return m
