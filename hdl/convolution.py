# amaranth: UnusedElaboratable=no
"""Convolution (Eq. 1): squares from tables, smoothed by the separable 5x5 kernel of adders."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.convolution import SHIFT
from golden.formats import SMOOTHING_SIZE
from golden.parameters import Parameters
from hdl.gradient_squares import GradientSquares
from hdl.parts.stream import Beat, Columns, Pipeline, WindowCounter
from hdl.preprocessing import sizes_layout

LATE_ROWS = (1, 2, 3)
"""Rows looked up a clock after the outer two, so that their sums do not meet in one clock."""


def products_layout(parameters: Parameters) -> data.StructLayout:
    """A, B and C after smoothing; C has a sign only where gradients have one."""
    bits = parameters.product_bits
    c = signed(bits + 1) if parameters.algorithm.gradient == "signed" else unsigned(bits)
    return data.StructLayout({"a": unsigned(bits), "b": unsigned(bits), "c": c})


class ConvolutionUnit:
    """Sum of one channel under the kernel [1 2 2 2 1]ᵀ[1 2 2 2 1], not yet divided by 64.

    The latency is 3. The first sum is that of the column. It then meets the four columns before it
    in a chain of adders, in which each register holds the part of one window that has been seen.
    These registers move from beat to beat, not from clock to clock.

    Parameters
    ----------
    pipe
        The pipeline of the block that this is a part of.
    rows
        Five unsigned values of one width; the middle three come a clock after the others.
    beat
        Is there a beat, two clocks after the outer rows?
    name
        Name of the channel.
    half
        Add 32, half a unit of the result. ``rows`` must be squares: these are 0 or 1 modulo 4.

    Members
    -------
    total
        The sum, six bits wider than a row, with the window's last column.
    """

    latency = 3

    def __init__(
        self, pipe: Pipeline, rows: list[Value], beat: Value, name: str, *, half: bool = False
    ) -> None:
        def chained(value: Value, stage: str) -> Value:
            return pipe.register(value, f"{name}_{stage}", when=beat)

        second = rows[1]
        if half:
            # bit 1 of a square is always 0: a 2 there, in a row of weight 2, in columns of weight
            # 8, is 32
            second = Cat(second[0], C(1, 1), second[2:])
        # r0 + r4, then + 2·r1, and r2 + r3; what is doubled leaves bit 0 alone
        outer = pipe.register(rows[0] + rows[4], f"{name}_outer")
        upper = pipe.register(Cat(outer[0], outer[1:] + second), f"{name}_upper")
        inner = pipe.register(rows[2] + rows[3], f"{name}_inner")
        column = Cat(upper[0], upper[1:] + inner)[: len(rows[0]) + 3]

        taps = chained(column, "taps_1")
        for k in range(2, SMOOTHING_SIZE):
            # 1 + 2 + 2 + 2: never more than three bits above the column's sum
            sum_above = (taps[1:] + column)[: len(column) + 2]
            taps = chained(Cat(taps[0], sum_above), f"taps_{k}")
        self.total = pipe.register((taps + column)[: len(rows[0]) + SHIFT], f"{name}_total")


class Convolution(wiring.Component):
    """Smooths A, B and C: kernel [1 2 2 2 1]ᵀ[1 2 2 2 1] / 64, rounded once, half away from zero.

    Takes columns of five rows of numbers, delivers rows four positions shorter. With a, b and d the
    squares of gx, gy and their difference, gx·gy = (a + b - d) / 2: so A and B are sums of a and b,
    and C = (A + B - D) / 2 with D that of d, made of the full sums before any of them is rounded.
    The half of rounding is already in the sums of a and b, so in C too.

    c comes from an adder, not from a register: the next block should register it before it
    computes.

    Members
    -------
    i
        Stream of ``Columns(sizes_layout(parameters), 5)``.
    o
        Stream of ``Beat(products_layout(parameters))``.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._signed = parameters.algorithm.gradient == "signed"
        self._bits = parameters.product_bits
        sizes = sizes_layout(parameters)
        self._squares = GradientSquares(sizes, SMOOTHING_SIZE)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(sizes, SMOOTHING_SIZE))),
                "o": Out(stream.Signature(Beat(products_layout(parameters)))),
            }
        )

    @property
    def latency(self) -> int:
        """Signed products round on either side of zero, which takes a clock of its own."""
        return GradientSquares.latency + ConvolutionUnit.latency + self._signed

    @property
    def memory_bits(self) -> int:
        return self._squares.memory_bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, SMOOTHING_SIZE, step=step, eol=self.i.payload.eol)
        beat = pipe.delay(pipe.valid, GradientSquares.latency + 2, "beat", reset=True)
        squares = self._squares.look_up(m, pipe, self.i.payload.data, LATE_ROWS)

        def total(name: str, half: bool) -> Value:
            return ConvolutionUnit(pipe, squares[name], beat, name, half=half).total

        a, b, d = total("a", True), total("b", True), total("d", False)
        c = self._signed_cross(pipe, a, b, d) if self._signed else self._cross(a, b, d)
        waits = int(self._signed)
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            self.o.payload.data.a.eq(pipe.delay(a[SHIFT:], waits, "a_rounded")),
            self.o.payload.data.b.eq(pipe.delay(b[SHIFT:], waits, "b_rounded")),
            self.o.payload.data.c.eq(c),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m

    @staticmethod
    def _cross(a: Value, b: Value, d: Value) -> Value:
        """C rounded: a + b - d is even, so bit 0 of a + b is that of d, and neither is needed."""
        return ((a + b)[1:] - d[1:])[SHIFT:]

    def _signed_cross(self, pipe: Pipeline, a: Value, b: Value, d: Value) -> Value:
        """C rounded, one clock later: halves away from zero."""
        # subtracted without its carry: C + 31, to which only those from 0 up still add 1
        lower = pipe.register(((a + b)[1:] + ~d[1:])[: self._bits + SHIFT + 1].as_signed(), "lower")
        return (lower + ~lower[-1]) >> SHIFT
