"""Small stream parts that every block uses: beats with raster tags, pipelines that stall, buffers.

All streams follow Amaranth's ``lib.stream``: valid never depends on ready, and a payload is held
until taken.
"""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, ShapeLike, Signal, Value, ValueLike
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.parts.probes import probe


def Beat(shape: ShapeLike) -> data.StructLayout:
    """One beat of a raster: ``data``, ``eol`` (last of its row) and ``eof`` (last of its frame).

    ``eof`` implies ``eol``.
    """
    return data.StructLayout({"data": shape, "eol": 1, "eof": 1})


def Columns(shape: ShapeLike, rows: int) -> data.StructLayout:
    """Layout of one column of a window.

    ``data[0]`` is the top (oldest) row, ``data[rows-1]`` the newest.
    """
    return Beat(data.ArrayLayout(shape, rows))


class Pipeline:
    """The registers of one block, which move together.

    They advance whenever the block's output is ready, and with them whatever is inside, beats and
    the bubbles that an idle input leaves. So beats leave also when no further input comes, and
    readiness passes through any number of blocks without any logic. In return ``o.ready`` must not
    wait for ``o.valid``. Data registers have no reset; only the valid bits do.

    A block computes with ``valid``, which says that a beat is offered at ``i`` and may be taken,
    and takes it when ``valid & advance``.

    Parameters
    ----------
    m
        The block's module.
    i, o
        Its input and output stream. Drives ``i.ready``.
    permit
        Extra condition to take an input beat; beats already inside move on regardless.

    Attributes
    ----------
    registers
        Its registers by name, for a block that declares them as probes.
    """

    def __init__(self, m: Module, i: Any, o: Any, *, permit: ValueLike = 1) -> None:
        self._m = m
        self.registers: dict[str, Signal] = {}
        self.advance = Signal()
        self.valid = Signal(name="offered")
        self._beats: list[Value] = [self.valid]
        m.d.comb += [
            self.advance.eq(o.ready),
            self.valid.eq(i.valid & permit),
            i.ready.eq(self.advance & permit),
        ]

    def register(
        self, value: ValueLike, name: str, *, when: ValueLike | None = None, reset: bool = False
    ) -> Signal:
        """``value`` one clock later; with ``when``, only where that is true."""
        value = Value.cast(value)
        register = Signal(value.shape(), name=name, reset_less=not reset)
        with self._m.If(self.advance if when is None else self.advance & when):
            self._m.d.sync += register.eq(value)
        self.registers[name] = register
        return register

    def beat(self, clock: int) -> Value:
        """Is there a beat, and no bubble, so many clocks after it was offered?"""
        while len(self._beats) <= clock:
            self._beats.append(self.register(self._beats[-1], f"beat_{len(self._beats)}", reset=True))
        return self._beats[clock]

    def delay(self, value: ValueLike, clocks: int, name: str, *, reset: bool = False) -> Value:
        """``value`` some clocks later."""
        value = Value.cast(value)
        for k in range(clocks):
            value = self.register(value, f"{name}_{k + 1}", reset=reset)
        return value


class WindowCounter:
    """Finds the columns that complete a window ``size`` wide: all but a row's first size-1."""

    def __init__(self, m: Module, size: int, *, step: ValueLike, eol: ValueLike) -> None:
        seen = Signal(range(size))
        self.complete = Signal()
        m.d.comb += self.complete.eq(seen == size - 1)
        with m.If(step):
            with m.If(eol):
                m.d.sync += seen.eq(0)
            with m.Elif(~self.complete):
                m.d.sync += seen.eq(seen + 1)


class SkidBuffer(wiring.Component):
    """Two-place buffer that cuts both paths: every output, also ``i.ready``, is a register.

    It has the full rate, and latency 1.

    Parameters
    ----------
    shape
        Payload.
    closed_in_reset
        Its input is not ready until the clock after a reset: a source that is not reset with it
        loses no beat.

    Members
    -------
    i, o
        Streams of ``shape``.
    """

    latency = 1

    def __init__(self, shape: ShapeLike, *, closed_in_reset: bool = False) -> None:
        self._shape = shape
        self._closed = closed_in_reset
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        first, spare = Signal(self._shape, reset_less=True), Signal(self._shape, reset_less=True)
        # ready is stored as it is, not inverted: it goes far
        first_full, ready = Signal(), Signal(init=not self._closed)
        # the spare is only ever full behind a full first place, and the input waits while it is; or
        # after a reset
        refilled = Mux(ready, self.i.valid, first_full) if self._closed else ~ready | self.i.valid
        m.d.comb += [self.i.ready.eq(ready), self.o.valid.eq(first_full), self.o.payload.eq(first)]
        with m.If(self.o.ready | ~first_full):
            m.d.sync += [first_full.eq(refilled), ready.eq(1)]
            with m.If(ready):
                m.d.sync += first.eq(self.i.payload)
            with m.Else():
                m.d.sync += first.eq(spare)
        with m.Elif(self.i.valid):
            m.d.sync += ready.eq(0)
        # whatever is offered, until it is needed
        with m.If(ready):
            m.d.sync += spare.eq(self.i.payload)
        probe(self, first=first, spare=spare, first_full=first_full, ready=ready)
        return m
