"""A queue behind a pipeline that never stops, so that no clock enable has to reach all of it."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, ShapeLike, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.parts.probes import probe

PLACES = 128
"""Beats in the memory: more than twice as many as are under way."""


class ElasticQueue(wiring.Component):
    """First in, first out; takes whatever comes, as long as nothing new begins without ``room``.

    Two beats more wait in the registers of the block RAM and behind it.

    Parameters
    ----------
    shape
        Payload.
    under_way
        Clocks from the place where ``room`` is looked at to ``i``: a beat in each is still to come.

    Members
    -------
    i
        Stream of ``shape``, always ready.
    o
        Stream of ``shape``, three clocks later.
    room
        A register: whatever is under way has a place, and a beat more.

    Raises
    ------
    ValueError
        ``under_way`` is above half of :data:`PLACES`.
    """

    latency = 3

    def __init__(self, shape: ShapeLike, under_way: int) -> None:
        if under_way > PLACES // 2:
            raise ValueError(f"under_way is {under_way}; allowed: whole numbers up to {PLACES // 2}")
        # the beats of this clock and of the next one, in which room is still what it was
        self._most = PLACES - under_way - 2
        super().__init__(
            {"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)), "room": Out(1, init=1)}
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        given = Value.cast(self.i.payload)
        m.submodules.memory = memory = Memory(
            shape=len(given), depth=PLACES, init=[], attrs={"ram_style": "block"}
        )
        write, read = memory.write_port(), memory.read_port()
        level, moves, taken, read_out = Signal(range(PLACES + 1)), Signal(), Signal(), Signal()
        m.d.comb += [
            self.i.ready.eq(1),
            moves.eq(~self.o.valid | self.o.ready),
            taken.eq(moves & (level != 0)),
            write.en.eq(self.i.valid),
            write.data.eq(given),
            # what is read out of an empty queue is not valid
            read.en.eq(moves),
        ]
        for port, steps in ((write, self.i.valid), (read, taken)):
            with m.If(steps):
                m.d.sync += port.addr.eq(port.addr + 1)
        with m.If(self.i.valid ^ taken):
            m.d.sync += level.eq(level + Mux(taken, -1, 1))
        m.d.sync += self.room.eq(level < self._most)
        # a register more, because block RAM is far away; both are its own
        found = Signal(len(given), reset_less=True)
        with m.If(moves):
            m.d.sync += [read_out.eq(taken), self.o.valid.eq(read_out), found.eq(read.data)]
        m.d.comb += Value.cast(self.o.payload).eq(found)
        probe(self, memory=memory, write=write, read=read, level=level, read_out=read_out)
        return m
