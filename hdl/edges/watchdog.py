"""Watchdog: notices that something waits too long."""

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
        Width of the limit.

    Members
    -------
    waiting
        Something waits.
    limit
        In clocks; 0 stands for no limit.
    expired
        The wait has reached the limit, or is longer than a limit that was lowered. High for one
        clock, once in each wait.
    """

    def __init__(self, bits: int = TIMEOUT_BITS) -> None:
        super().__init__({"waiting": In(1), "limit": In(bits), "expired": Out(1)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        # the count has one bit more than a limit and stops there, so that it is above any limit
        # that is set later
        waited, over = Signal(len(self.limit) + 1), Signal()
        reached = Signal()
        m.d.comb += reached.eq((waited >= self.limit) & (self.limit != 0) & ~over)
        with m.If(~self.waiting):
            m.d.sync += [waited.eq(0), over.eq(0)]
        with m.Else():
            m.d.sync += over.eq(over | reached)
            with m.If(~waited[-1]):
                m.d.sync += waited.eq(waited + 1)
        # this tells of the wait up to this clock, which may be its last one
        m.d.sync += self.expired.eq(reached)
        return m
