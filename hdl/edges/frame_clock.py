"""Frame clock: a counter of clocks, and the time at which each frame's first pixel came."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.parts.probes import probe

TIME_BITS = 64


class FrameClock(wiring.Component):
    """Counts clocks since reset, and stores the count for each frame until the frame ends.

    A start of frame can wait between the input and the frame guard, which then begins a frame with
    it or drops it; so its time is stored when the input takes it. Where one is dropped while the
    next one waits already, that one gets its time.

    Parameters
    ----------
    most
        Largest number of starts of frame that wait, and frames that have begun and not ended,
        together. The memory has the next power of two of words.

    Members
    -------
    arrives
        The input takes a start of frame. Others wait before it in their order.
    begins, drops
        The first of those that wait begins a frame, or is dropped.
    ends
        The first of the frames that have begun ends; at least one clock after it began.
    forget
        All frames that have begun are forgotten, without one that ends in this clock.
    now
        Number of clocks since reset.
    time
        ``now`` when the first pixel of the frame that has ended last was taken, from the clock
        after ``ends`` on; 0 if none has. It is a register.
    """

    def __init__(self, most: int) -> None:
        self._depth = 1 << (most - 1).bit_length()
        super().__init__(
            {
                **dict.fromkeys(("arrives", "begins", "drops", "ends", "forget"), In(1)),
                "now": Out(TIME_BITS),
                "time": Out(TIME_BITS),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        self._count(m)
        m.submodules.memory = memory = Memory(shape=TIME_BITS, depth=self._depth, init=[])
        write, read = memory.write_port(), memory.read_port()
        # the first of the frames that have begun, and the one after it: no sum lies between `ends`,
        # which comes late in a clock, and the memory
        begun, place, after = (Signal(range(self._depth), init=init) for init in (0, 0, 1))
        m.d.comb += [
            write.en.eq(self.arrives),
            write.data.eq(self.now),
            # read ahead, so that the way from the memory ends in a register
            read.addr.eq(Mux(self.forget, begun, Mux(self.ends, after, place))),
        ]
        m.d.sync += [
            write.addr.eq(write.addr + self.arrives - self.drops),
            begun.eq(begun + self.begins),
            place.eq(read.addr),
        ]
        with m.If(self.ends):
            m.d.sync += [self.time.eq(read.data), after.eq(after + 1)]
        with m.If(self.forget):
            m.d.sync += after.eq(begun + 1)
        probe(self, memory=memory, write=write, read=read, place=place, after=after, begun=begun)
        return m

    def _count(self, m: Module) -> None:
        """Counts in two halves, so that no carry is longer than one of them."""
        low, high = self.now[: TIME_BITS // 2], self.now[TIME_BITS // 2 :]
        carry = Signal()
        m.d.sync += [
            low.eq(low + 1),
            # a clock ahead
            carry.eq(low == (1 << len(low)) - 2),
            high.eq(high + carry),
        ]
        probe(self, carry=carry)
