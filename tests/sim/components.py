"""Small components for the engines: correct ones, and some that are broken on purpose."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal, unsigned
from amaranth.lib import data, memory, stream, wiring
from amaranth.lib.wiring import In, Out


class Slice(wiring.Component):
    """A register slice; adds ``offset`` to what passes."""

    def __init__(self, width: int = 8) -> None:
        payload = stream.Signature(unsigned(width))
        super().__init__({"i": In(payload), "o": Out(payload), "offset": In(8, init=3)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.d.comb += self.i.ready.eq(~self.o.valid | self.o.ready)
        with m.If(self.i.ready):
            m.d.sync += self.o.valid.eq(self.i.valid)
            with m.If(self.i.valid):
                m.d.sync += self.o.payload.eq(self.i.payload + self.offset)
        return m


class Adder(wiring.Component):
    """Joins two streams, combinationally, into their sum and the running number of the pair."""

    def __init__(self) -> None:
        super().__init__(
            {
                "a": In(stream.Signature(unsigned(8))),
                "b": In(stream.Signature(data.StructLayout({"low": 4, "high": unsigned(4)}))),
                "o": Out(stream.Signature(data.StructLayout({"sum": 9, "number": 16}))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        both = Signal()
        number = Signal(16)
        m.d.comb += [
            both.eq(self.a.valid & self.b.valid),
            self.o.valid.eq(both),
            self.a.ready.eq(both & self.o.ready),
            self.b.ready.eq(both & self.o.ready),
            self.o.payload.sum.eq(self.a.payload + self.b.payload.as_value()),
            self.o.payload.number.eq(number),
        ]
        with m.If(both & self.o.ready):
            m.d.sync += number.eq(number + 1)
        return m


class LineDelay(wiring.Component):
    """Delays by ``depth`` beats through a memory, so that engines have memories to get right."""

    def __init__(self, depth: int = 5) -> None:
        self._depth = depth
        super().__init__(
            {
                "i": In(stream.Signature(unsigned(12))),
                "o": Out(stream.Signature(unsigned(12))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.line = line = memory.Memory(shape=12, depth=self._depth, init=range(self._depth))
        read, write = line.read_port(), line.write_port()
        address = Signal(range(self._depth))
        step = Signal()
        m.d.comb += [
            self.i.ready.eq(~self.o.valid | self.o.ready),
            step.eq(self.i.valid & self.i.ready),
            read.addr.eq(address),
            read.en.eq(step),
            write.addr.eq(address),
            write.data.eq(self.i.payload),
            write.en.eq(step),
            self.o.payload.eq(read.data),
        ]
        with m.If(self.i.ready):
            m.d.sync += self.o.valid.eq(self.i.valid)
        with m.If(step):
            m.d.sync += address.eq(address + 1)
            with m.If(address == self._depth - 1):
                m.d.sync += address.eq(0)
        return m


class Numberer(wiring.Component):
    """Numbers the beats since reset: shows where a reset took place."""

    def __init__(self) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(unsigned(4))),
                "o": Out(stream.Signature(data.StructLayout({"payload": 4, "number": 12}))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        number = Signal(12)
        m.d.comb += [
            self.o.valid.eq(self.i.valid),
            self.i.ready.eq(self.o.ready),
            self.o.payload.payload.eq(self.i.payload),
            self.o.payload.number.eq(number),
        ]
        with m.If(self.i.valid & self.o.ready):
            m.d.sync += number.eq(number + 1)
        return m


class Inverter(wiring.Component):
    """Combinational only, with streams that are always ready: no clock, no reset."""

    def __init__(self) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(unsigned(8), always_ready=True)),
                "o": Out(stream.Signature(unsigned(8), always_ready=True)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.d.comb += [self.o.valid.eq(self.i.valid), self.o.payload.eq(~self.i.payload)]
        return m


class Generator(wiring.Component):
    """Without inputs: counts down from 9 and falls silent."""

    def __init__(self) -> None:
        super().__init__(
            {
                "o": Out(stream.Signature(unsigned(4))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        left = Signal(4, init=9)
        m.d.comb += [self.o.valid.eq(left != 0), self.o.payload.eq(left)]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += left.eq(left - 1)
        return m


class Impatient(wiring.Component):
    """Breaks the rules: it changes a waiting payload (``change``), or withdraws valid."""

    def __init__(self) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(unsigned(8))),
                "o": Out(stream.Signature(unsigned(70))),
                "change": In(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.d.comb += self.i.ready.eq(~self.o.valid | self.o.ready)
        with m.If(self.i.ready):
            m.d.sync += [self.o.valid.eq(self.i.valid), self.o.payload.eq(self.i.payload << 60)]
        with m.Elif(self.change):
            m.d.sync += self.o.payload.eq(self.o.payload + 1)
        with m.Else():
            m.d.sync += self.o.valid.eq(0)
        return m


class Stuck(wiring.Component):
    """Accepts three beats, passes two of them on, and never moves again."""

    def __init__(self) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(unsigned(8))),
                "o": Out(stream.Signature(unsigned(8))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        taken = Signal(2)
        m.d.comb += [
            self.o.valid.eq(self.i.valid & (taken < 2)),
            self.o.payload.eq(self.i.payload),
            self.i.ready.eq((self.o.ready & (taken < 2)) | (taken == 2)),
        ]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += taken.eq(taken + 1)
        return m
