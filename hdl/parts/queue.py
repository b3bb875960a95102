"""A queue in block RAM, for sources that cannot wait."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, ShapeLike, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.parts.optional import optional
from hdl.parts.probes import probe

ROOM = 3
"""Free places that ``room`` promises.

A source may look at it a clock late, and may still have one more beat to deliver.
"""


class Queue(wiring.Component):
    """First in, first out; the input is always ready, so a source must obey ``room``.

    If it does not, beats are lost.

    Parameters
    ----------
    shape
        Payload.
    depth
        Beats in the memory; one more waits at the output.
    registered
        The output is a register behind the memory, a clock later, and another beat waits before it.
        It keeps a beat that was taken until the next one comes. Memory is far away; and block RAM
        has such a register of its own.

    Members
    -------
    i
        Stream of ``shape``, always ready.
    o
        Stream of ``shape``, :attr:`latency` clocks later.
    room
        At least three places are free, counted without the beat that is put in now.
    waiting
        Where ``registered`` only: a beat is here that is at least two clocks old.

    Raises
    ------
    ValueError
        ``depth`` is below :data:`ROOM`.
    """

    latency = 2

    def __init__(self, shape: ShapeLike, depth: int, *, registered: bool = False) -> None:
        if depth < ROOM:
            raise ValueError(f"depth is {depth}; allowed: whole numbers from {ROOM}")
        self._depth = depth
        self._registered = registered
        self.latency = Queue.latency + registered
        super().__init__(
            {
                "i": In(stream.Signature(shape, always_ready=True)),
                "o": Out(stream.Signature(shape)),
                "room": Out(1),
                **optional(registered, waiting=Out(1)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        given = Value.cast(self.i.payload)
        m.submodules.memory = memory = Memory(shape=len(given), depth=self._depth, init=[])
        write, read = memory.write_port(), memory.read_port()
        level = Signal(range(self._depth + 1))
        free, taken, read_out = Signal(), Signal(), Signal()
        m.d.comb += [
            free.eq(~self.o.valid | self.o.ready),
            taken.eq(free & (level != 0)),
            self.room.eq(level <= self._depth - ROOM),
            write.en.eq(self.i.valid),
            write.data.eq(given),
            # what is read out of an empty queue is not valid
            read.en.eq(free),
        ]
        for port, moves in ((write, self.i.valid), (read, taken)):
            with m.If(moves):
                m.d.sync += port.addr.eq(Mux(port.addr == self._depth - 1, 0, port.addr + 1))
        with m.If(self.i.valid & ~taken):
            m.d.sync += level.eq(level + 1)
        with m.Elif(taken & ~self.i.valid):
            m.d.sync += level.eq(level - 1)
        with m.If(free):
            m.d.sync += read_out.eq(taken)
        if self._registered:
            found = Signal(len(given), reset_less=True)
            with m.If(free):
                m.d.sync += [self.o.valid.eq(read_out), found.eq(read.data)]
            m.d.comb += [
                Value.cast(self.o.payload).eq(found),
                self.waiting.eq(read_out | self.o.valid),
            ]
        else:
            m.d.comb += [self.o.valid.eq(read_out), Value.cast(self.o.payload).eq(read.data)]
        probe(self, memory=memory, write=write, read=read, level=level, read_out=read_out)
        return m
