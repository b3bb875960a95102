"""Watchdog: notices that something waits for too long."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.edges.register_map import TIMEOUT_BITS


class Watchdog(wiring.Component):
    """Counts the clocks of each wait.

    Parameters
    ----------
    bits
        Of the limit.

    Members
    -------
    waiting
        Something waits.
    limit
        Clocks; 0: for ever.
    expired
        It has waited for so long, or for longer when the limit was lowered: once, for one clock, in
        each wait.
    """

    def __init__(self, bits: int = TIMEOUT_BITS) -> None:
        super().__init__({"waiting": In(1), "limit": In(bits), "expired": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        # one bit more than a limit has, in which the count stays: a limit that is set late must
        # find it
        waited, over = Signal(len(self.limit) + 1), Signal()
        reached = Signal()
        m.d.comb += reached.eq((waited >= self.limit) & (self.limit != 0) & ~over)
        with m.If(~self.waiting):
            m.d.sync += [waited.eq(0), over.eq(0)]
        with m.Else():
            m.d.sync += over.eq(over | reached)
            with m.If(~waited[-1]):
                m.d.sync += waited.eq(waited + 1)
        # of the wait up to this clock, which may have ended with it
        m.d.sync += self.expired.eq(reached)
        return m
