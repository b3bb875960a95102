"""A long delay in memory: a chain of registers would cost a logic element per bit and clock."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Shape, ShapeLike, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.parts.probes import probe

REGISTERS = 2
"""Clocks of a delay that the memory's own read register and the one behind it make."""
PART = 18
"""Widest memory: as wide as a block RAM whose one port reads the old value while it writes."""


class DelayLine(wiring.Component):
    """A value some enabled clocks later: data of a pipeline that waits beside a longer path.

    One counter goes round a memory; at each place the old value is read just as the new one takes
    its place. Which memory that is, block RAM or something smaller, is left to the tools: most of
    these lines are short. There is no reset: what comes out is meaningless until a value has gone
    through.

    Parameters
    ----------
    shape
        Shape of the value.
    clocks
        Delay in enabled clocks. Up to 3 are registers, and no memory.
    part
        Bits that are in one memory, up to :data:`PART`: values that go to different places should
        not share one.

    Members
    -------
    enable
        The line moves: ``advance`` of the pipeline around.
    i, o
        The value, and the same ``clocks`` enabled clocks later.

    Raises
    ------
    ValueError
        ``clocks`` is below 0, or ``part`` is not one of those allowed.
    """

    def __init__(self, shape: ShapeLike, clocks: int, part: int = PART) -> None:
        if clocks < 0:
            raise ValueError(f"clocks is {clocks}; allowed: whole numbers from 0")
        if not 1 <= part <= PART:
            raise ValueError(f"part is {part}; allowed: whole numbers from 1 to {PART}")
        self._part = part
        self._width = Shape.cast(shape).width
        self.latency = clocks
        super().__init__({"enable": In(1), "i": In(shape), "o": Out(shape)})

    @property
    def _depth(self) -> int:
        return self.latency - REGISTERS if self.latency > REGISTERS + 1 else 0

    @property
    def memory_bits(self) -> int:
        return self._width * self._depth

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        value = Value.cast(self.i)
        if self._depth:
            value = self._read(m, value)
        for k in range(REGISTERS - 1 if self._depth else self.latency):
            value = self._register(m, value, f"delayed_{k + 1}")
        m.d.comb += Value.cast(self.o).eq(value)
        return m

    def _read(self, m: Module, value: Value) -> Value:
        """The value that went into the ring ``depth`` clocks ago, from the read register."""
        place = Signal(range(self._depth))
        with m.If(self.enable):
            m.d.sync += place.eq(Mux(place == self._depth - 1, 0, place + 1))
        read_out, rings = [], []
        for k, low in enumerate(range(0, self._width, self._part)):
            part = value[low : low + self._part]
            m.submodules[f"ring_{k}"] = ring = Memory(shape=len(part), depth=self._depth, init=[])
            read, write = ring.read_port(), ring.write_port()
            m.d.comb += [
                read.addr.eq(place),
                read.en.eq(self.enable),
                write.addr.eq(place),
                write.en.eq(self.enable),
                write.data.eq(part),
            ]
            read_out.append(read.data)
            rings.append(ring)
        probe(self, place=place, rings=rings, read_out=read_out)
        return Cat(read_out)

    def _register(self, m: Module, value: Value, name: str) -> Signal:
        register = Signal(self._width, name=name, reset_less=True)
        with m.If(self.enable):
            m.d.sync += register.eq(value)
        probe(self, **{name: register})
        return register
