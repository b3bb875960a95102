# amaranth: UnusedElaboratable=no
"""Twice the smaller eigenvalue of the tensor (Eq. 2): D = (A + B) - sqrt((A - B)² + (2C)²)."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Value

from hdl.build import Build
from hdl.parts.arithmetic import magnitude
from hdl.parts.delay_line import DelayLine
from hdl.parts.square_table import SquareTable
from hdl.parts.stream import Pipeline
from hdl.responses import ResponseBlock
from hdl.square_root import SquareRoot

RADICAND_LATENCY = 7
"""A - B, sizes, difference of their halves, look-up (2), sum over both numbers, radicand."""


class Response(ResponseBlock):
    """Squares from tables, a sum, its square root.

    Both squares are looked up by halves: with x = {h, l}, each of n = pixel_bits,

        x² = h²·4ⁿ + l² + 2hl·2ⁿ,   2hl = h² + l² - (h - l)²

    so that with Q, the sum over both numbers of h²·2ⁿ + l², and E, that of (h - l)², the radicand
    is Q + (Q - E)·2ⁿ. A tensor smoothed from real pixels keeps it within 2·root_bits. A + B and the
    tags wait in a delay line beside all this.
    """

    def __init__(self, parameters: Build) -> None:
        self._half = parameters.pixel_bits
        self._bits = parameters.root_bits
        self._response_bits = parameters.response_bits
        self._root = SquareRoot(self._bits, parameters.sqrt_bits_per_stage)
        # one clock less: its last register stands by itself, because the line is block RAM and so
        # far away
        self._line = DelayLine(self._bits + 2, RADICAND_LATENCY + self._root.latency - 1)
        self._halves = [SquareTable(self._half) for _ in range(2)]
        self._differences = SquareTable(self._half + 1, signed_numbers=True)
        super().__init__(parameters)

    @property
    def latency(self) -> int:
        """The last clock takes the difference."""
        return RADICAND_LATENCY + self._root.latency + 1

    @property
    def memory_bits(self) -> int:
        tables = sum(table.memory_bits for table in (*self._halves, self._differences))
        return tables + self._line.memory_bits + self._root.memory_bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        m.submodules.square_root = root = self._root
        m.submodules.line = line = self._line
        a, b = self.i.payload.data.a, self.i.payload.data.b
        m.d.comb += [
            root.enable.eq(pipe.advance),
            root.radicand.eq(self._radicand(m, pipe)),
            line.enable.eq(pipe.advance),
            line.i.eq(Cat((a + b)[: self._bits], self.i.payload.eol, self.i.payload.eof)),
        ]
        waited = pipe.register(line.o, "waited")
        total, tags = waited[: self._bits], waited[self._bits :]
        difference = total - root.root
        # one clear of the whole register where D would be negative
        clamped = Mux(difference[-1], 0, difference[: self._response_bits])
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True)),
            self.o.payload.data.eq(pipe.register(clamped, "clamped")),
            Cat(self.o.payload.eol, self.o.payload.eof).eq(pipe.register(tags, "tags")),
        ]
        return m

    def _radicand(self, m: Module, pipe: Pipeline) -> Value:
        """(A - B)² + (2C)², RADICAND_LATENCY clocks later."""
        n = self._half
        data = self.i.payload.data
        difference, c = pipe.register(data.a - data.b, "difference"), pipe.register(data.c, "c")
        numbers = [
            pipe.register(magnitude(difference), "distance"),
            pipe.register(magnitude(c), "cross"),
        ]
        # high halves, low halves, and a clock later their differences
        m.submodules.high, m.submodules.low = self._halves
        m.submodules.differences = self._differences
        highs, lows = [x[n:] for x in numbers], [x[:n] for x in numbers]
        steps = [
            pipe.register(high - low, f"step_{k}")
            for k, (high, low) in enumerate(zip(highs, lows, strict=True))
        ]
        high = self._sum(m, pipe, self._halves[0], highs, "high")
        low = self._sum(m, pipe, self._halves[1], lows, "low")
        cross = self._sum(m, pipe, self._differences, steps, "cross")
        squares = pipe.register((high << n) + low, "squares")
        return pipe.register((squares + ((squares - cross) << n))[: 2 * self._bits], "radicand")

    def _sum(self, m: Module, pipe: Pipeline, table: SquareTable, x: list[Value], name: str) -> Value:
        """Sum of the squares of a part of A - B and of a part of 2C."""
        m.d.comb += [table.enable.eq(pipe.advance), Cat(table.x).eq(Cat(*x))]
        return pipe.register(table.square[0] + (table.square[1] << 2), f"{name}_squares")
