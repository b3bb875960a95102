# amaranth: UnusedElaboratable=no
"""Twice the smaller eigenvalue of the tensor (Eq. 2): D = (A + B) - sqrt((A - B)² + (2C)²)."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Signal, Value

from hdl.build import Build
from hdl.convolution import square_pairs
from hdl.parts.arithmetic import magnitude
from hdl.parts.delay_line import PART, DelayLine
from hdl.parts.lanes import each_lane, lane_name
from hdl.parts.squarer import Squarer, make_squarer
from hdl.parts.stream import Pipeline
from hdl.responses import ResponseBlock
from hdl.square_root import SquareRoot

RADICAND_LATENCY = 7
"""A - B, sizes, difference of their halves, look-up (2), sum over both numbers, radicand.

With several pixels per clock there are no sizes, because tables find the squares of numbers of
either sign; and two clocks for the radicand, so that no two sums meet in one.
"""

ROOT_TABLE_BITS = 5
"""Result bits of a root that are looked up, with several pixels per clock."""


PARTS = ("high", "low", "differences")
"""Parts of the two numbers that are squared."""


class Response(ResponseBlock):
    """Squares from tables, a sum, its square root.

    Both squares are looked up by halves: with x = {h, l}, each of n = pixel_bits,

        x² = h²·4ⁿ + l² + 2hl·2ⁿ,   2hl = h² + l² - (h - l)²

    so that with Q, the sum over both numbers of h²·2ⁿ + l², and E, that of (h - l)², the radicand
    is Q + (Q - E)·2ⁿ. A tensor smoothed from real pixels keeps it within 2·root_bits. A + B and the
    tags wait in a delay line beside all this, those of all lanes in the same. With several pixels
    per clock, h has the sign of x.
    """

    def __init__(self, parameters: Build) -> None:
        self._half = parameters.pixel_bits
        self._bits = parameters.root_bits
        self._response_bits = parameters.response_bits
        self._lanes = lanes = parameters.pixels_per_clock
        per_stage, looked_up = parameters.sqrt_bits_per_stage, ROOT_TABLE_BITS if lanes > 1 else 0
        self._roots = [SquareRoot(self._bits, per_stage, looked_up) for _ in range(lanes)]
        # its last register stands by itself, because the line is block RAM and so far away; in
        # several lanes that would take too much, and the sums before it have their own
        part = PART if lanes == 1 else min(self._bits, PART)
        self._line = DelayLine(self._bits * lanes + 2 + (lanes > 1), self.latency - 2, part)
        # the convolution's squares come first
        multiplied = parameters.multiplied_pairs - square_pairs(parameters)
        self._tables = [_tables(self._half, lanes, multiplied - len(PARTS) * lane) for lane in range(lanes)]
        super().__init__(parameters)

    @property
    def latency(self) -> int:
        """The last clock takes the difference."""
        return RADICAND_LATENCY + self._roots[0].latency + 1

    @property
    def memory_bits(self) -> int:
        tables = sum(table.memory_bits for lane in self._tables for table in lane.values())
        return tables + self._line.memory_bits + sum(root.memory_bits for root in self._roots)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        m.submodules.line = line = self._line
        tensors = each_lane(self.i.payload.data, self._lanes)
        sums = [(tensor.a + tensor.b)[: self._bits] for tensor in tensors]
        valid = Cat(pipe.valid)[: int(self._lanes > 1)]
        given = Cat(*sums, valid, self.i.payload.eol, self.i.payload.eof)
        m.d.comb += [
            line.enable.eq(pipe.advance),
            line.i.eq(pipe.delay(given, int(self._lanes > 1), "given")),
        ]
        waited = pipe.delay(line.o, int(self._lanes == 1), "waited")
        for lane, response in enumerate(each_lane(self.o.payload.data, self._lanes)):
            m.submodules[lane_name("square_root", lane, self._lanes)] = root = self._roots[lane]
            m.d.comb += [
                root.enable.eq(pipe.advance),
                root.radicand.eq(self._radicand(m, pipe, tensors[lane], lane)),
            ]
            difference = waited.word_select(lane, self._bits) - root.root
            # one clear of the whole register where D would be negative
            clamped = Mux(difference[-1], 0, difference[: self._response_bits])
            register = pipe.register(clamped, lane_name("clamped", lane, self._lanes))
            m.d.comb += response.response.eq(register)
        m.d.comb += [
            self.o.valid.eq(self._valid(m, pipe, waited[-3])),
            Cat(self.o.payload.eol, self.o.payload.eof).eq(pipe.register(waited[-2:], "tags")),
        ]
        return m

    def _valid(self, m: Module, pipe: Pipeline, waited: Value) -> Value:
        """Is there a beat at the output? With several pixels per clock the line knows."""
        if self._lanes == 1:
            return pipe.delay(pipe.valid, self.latency, "valid", reset=True)
        # what was in the line before a reset has to leave it first
        clocks = self.latency - 1
        size = clocks.bit_length()
        filled = Signal(size + 1, init=(1 << size) - clocks)
        with m.If(pipe.advance & ~filled[-1]):
            m.d.sync += filled.eq(filled + 1)
        return pipe.register(waited & filled[-1], "valid", reset=True)

    def _radicand(self, m: Module, pipe: Pipeline, tensor: Any, lane: int) -> Value:
        """(A - B)² + (2C)²."""
        n, tables = self._half, self._tables[lane]

        def stored(value: Value, name: str) -> Value:
            return pipe.register(value, lane_name(name, lane, self._lanes))

        def squares(name: str, x: list[Value]) -> Value:
            """Sum of the squares of a part of A - B and of a part of 2C."""
            m.submodules[lane_name(name, lane, self._lanes)] = table = tables[name]
            m.d.comb += [table.enable.eq(pipe.advance), *(table.x[k].eq(x[k]) for k in range(2))]
            return stored(table.square[0] + (table.square[1] << 2), f"{name}_squares")

        numbers = [stored(tensor.a - tensor.b, "difference"), stored(tensor.c, "c")]
        if self._lanes == 1:
            numbers = [
                stored(magnitude(x), name) for x, name in zip(numbers, ("distance", "cross"), strict=True)
            ]
        # high halves, low halves, and a clock later their differences
        lows = [x[:n] for x in numbers]
        highs = [x.shift_right(n) for x in numbers]
        steps = [
            stored(high - low, f"step_{k}") for k, (high, low) in enumerate(zip(highs, lows, strict=True))
        ]
        high, low, cross = squares("high", highs), squares("low", lows), squares("differences", steps)
        both = stored((high << n) + low, "squares")
        middle = both - cross
        if self._lanes > 1:
            middle, both = stored(middle, "middle"), stored(both, "squares_late")
        return stored((both + (middle << n))[: 2 * self._bits], "radicand")


def _tables(half: int, lanes: int, multiplied: int) -> dict[str, Squarer]:
    """Tables of one tensor: of the high halves, the low halves, and their differences.

    Multipliers take the place of the first ``multiplied`` ones.
    """
    several = lanes > 1
    shapes = zip(PARTS, (half + several, half, half + 1 + several), (several, False, True), strict=True)
    return {
        part: make_squarer(bits, signed_numbers=signs, stores_odd=several, multiplies=k < multiplied)
        for k, (part, bits, signs) in enumerate(shapes)
    }
