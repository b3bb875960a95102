"""Non-textured corner filter (Eqs. 6-9, Fig. 12): compares three patches around each corner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from amaranth.hdl import C, Module, Mux, Shape, Value, ValueLike
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import WINDOW_SIZE
from golden.parameters import Parameters
from hdl.build import Build
from hdl.parts.stream import Beat, Columns, Pipeline, WindowCounter
from hdl.sample import response_layout, responses
from hdl.thresholds import thresholds_layout


@dataclass(frozen=True)
class _Number:
    """A value and its bounds, so that no sum is wider than it must be."""

    value: Value
    low: int
    high: int

    @classmethod
    def bounded(cls, value: Value, low: int, high: int) -> _Number:
        shape = Shape.cast(range(low, high + 1))
        bits = value[: shape.width]
        return cls(bits.as_signed() if shape.signed else bits, low, high)

    @classmethod
    def any_of(cls, value: Value) -> _Number:
        """An unsigned value; only its width is known."""
        return cls(value, 0, (1 << len(value)) - 1)

    def __add__(self, other: _Number) -> _Number:
        return self.bounded(self.value + other.value, self.low + other.low, self.high + other.high)

    def __sub__(self, other: _Number) -> _Number:
        return self.bounded(self.value - other.value, self.low - other.high, self.high - other.low)

    def twice(self) -> _Number:
        return self.bounded(self.value << 1, 2 * self.low, 2 * self.high)

    def register(self, pipe: Pipeline, name: str, *, when: ValueLike | None = None) -> _Number:
        return _Number(pipe.register(self.value, name, when=when), self.low, self.high)


_ZERO = _Number(C(0, 1), 0, 0)


@dataclass(frozen=True)
class _Taps:
    """What one column adds to tau, by the number of beats after which it does so.

    ``left`` counts at 4 and at 5 beats, ``right`` at 0 and at 1, ``inner`` at 2 and at 4; left,
    right and those of 1 and of 4 beats are still to be doubled.
    """

    now: _Number
    after_1: _Number
    after_4: _Number
    after_5: _Number
    left: _Number
    right: _Number
    inner: _Number


class TextureFilter(wiring.Component):
    """F: is tau = tau12 + tau23 of the 9x9 window below T2?

    Takes columns of nine rows, delivers one beat per complete window, rows eight positions shorter.

    Each patch is its smaller neighbour moved one pixel outwards along the diagonals, so every term
    of tau is the absolute value of a difference of diagonal neighbours, the upper one subtracted:

        falling(x, y) = D(x, y) - D(x-1, y-1)        rising(x, y) = D(x, y) - D(x+1, y-1)

    and tau is the sum over eight 3x3 boxes of these: falling around (2, 2), (3, 3), (-1, -1), (-2,
    -2) and rising around (1, -1), (2, -2), (-2, 2), (-3, 3), relative to the centre. With
    ``patches="pixels"`` each box is its centre alone.

    No absolute value is ever taken, because |d| = 2 max(d, 0) - d: the maximum is a register that
    its own sign clears, and of the sum of all d next to nothing is left. Patches 1 and 2 of one
    difference and 2 and 3 of the next cancel but for the outermost and the innermost. With T(k) the
    sum of the box's rows around row k,

        outer = T(-3) - T(3), at columns -3 and 3        inner = T(1) - T(-1), at columns -1 and 1

    are added instead. Everything is summed down the columns first; a chain of additions then takes
    what each column has to add, and keeps it for the later columns. Three neighbours of its sum
    make tau.

    Clocks: 1 differences, 2 sums down the column, 3 chain along the row, 4 three neighbours against
    T2, 5 what follows from that.

    Members
    -------
    i
        Stream of ``Columns(response_layout(parameters), 9)``.
    thresholds
        Stream of ``thresholds_layout(parameters)``, one per frame, taken with the frame's last
        result.
    o
        Stream of ``Beat(TextureFilter.verdict(parameters))``; keep = not textured, or rejected
        corners are reported too.
    """

    latency = 5
    reads = "columns"

    @staticmethod
    def verdict(parameters: Parameters) -> data.StructLayout:
        """Is a window's centre textured, and is it reported?"""
        return data.StructLayout({"textured": 1, "keep": 1})

    def __init__(self, parameters: Build) -> None:
        self._parameters = parameters
        self._regions = parameters.algorithm.patches == "regions"
        super().__init__(
            {
                "i": In(stream.Signature(Columns(response_layout(parameters), WINDOW_SIZE))),
                "thresholds": In(stream.Signature(thresholds_layout(parameters))),
                "o": Out(stream.Signature(Beat(self.verdict(parameters)))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.thresholds.valid)
        m.d.comb += self.thresholds.ready.eq(self.o.valid & self.o.ready & self.o.payload.eof)

        beat = [Value.cast(pipe.valid)]
        for k in range(3):
            beat.append(pipe.register(beat[-1], f"beat_{k + 1}", reset=True))
        eol = pipe.delay(self.i.payload.eol, 3, "eol")
        window = WindowCounter(m, WINDOW_SIZE, step=beat[3] & pipe.advance, eol=eol)

        column = self._along_row(pipe, self._down_columns(pipe, beat[1]), beat[2])
        textured = pipe.register(self._is_textured(pipe, column, beat[3]), "is_textured")
        keep = ~textured | self.thresholds.payload.report_rejected
        m.d.comb += [
            self.o.valid.eq(pipe.delay(beat[3] & window.complete, 2, "valid", reset=True)),
            self.o.payload.data.textured.eq(pipe.register(textured, "textured")),
            self.o.payload.data.keep.eq(pipe.register(keep, "keep")),
            self.o.payload.eol.eq(pipe.delay(eol, 2, "last_eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m

    def _down_columns(self, pipe: Pipeline, beat: Value) -> _Taps:
        """Clocks 1 and 2. Rows of the window count from 0; a difference goes by its lower row."""
        falling, rising = self._differences(pipe)
        far, shared, near = self._ends(pipe)
        outer, inner = far + shared, near - shared
        # outer counts at 0 beats and at 6, which is one beat before 5
        previous_outer = outer.register(pipe, "outer", when=beat)
        if self._regions:
            now, after_1 = falling[8] + rising[1], falling[5] + rising[4]
            after_4, after_5 = falling[4] + rising[5], falling[1] + rising[8]
            right = (falling[6] + falling[7]) + (rising[2] + rising[3])
            left = (falling[2] + falling[3]) + (rising[6] + rising[7])
            left, right = left.register(pipe, "left"), right.register(pipe, "right")
        else:
            now, after_1 = falling[7] + rising[2], falling[6] + rising[3]
            after_4, after_5 = falling[3] + rising[6], falling[2] + rising[7]
            left = right = _ZERO
        return _Taps(
            now=(now.twice() + outer).register(pipe, "now"),
            after_1=after_1.register(pipe, "after_1"),
            after_4=after_4.register(pipe, "after_4"),
            after_5=(after_5.twice() + previous_outer).register(pipe, "after_5"),
            left=left,
            right=right,
            inner=inner.register(pipe, "inner"),
        )

    def _differences(self, pipe: Pipeline) -> tuple[dict[int, _Number], dict[int, _Number]]:
        """By row: max(falling, 0) in the newest column, max(rising, 0) in the one before."""
        newest = responses(self.i.payload)
        earlier = [
            pipe.register(newest[row], f"earlier_{row}", when=pipe.valid) for row in range(WINDOW_SIZE)
        ]

        def positive(lower: Value, upper: Value, name: str) -> _Number:
            difference = lower - upper
            # a synchronous clear: it costs the carry's way to the flip-flops, and no logic
            return _Number.any_of(pipe.register(Mux(difference[-1], 0, difference[:-1]), name))

        rows = range(1, WINDOW_SIZE) if self._regions else (2, 3, 6, 7)
        falling = {row: positive(newest[row], earlier[row - 1], f"falling_{row}") for row in rows}
        rising = {row: positive(earlier[row], newest[row - 1], f"rising_{row}") for row in rows}
        return falling, rising

    def _ends(self, pipe: Pipeline) -> tuple[_Number, _Number, _Number]:
        """Clock 1: parts of outer = far + shared and inner = near - shared."""
        row = [_Number.any_of(response) for response in responses(self.i.payload)]
        near = (row[5] - row[3]).register(pipe, "near")
        if not self._regions:
            return (row[1] - row[7]).register(pipe, "far"), _ZERO, near
        far = ((row[0] - row[8]) + (row[1] - row[7])).register(pipe, "far")
        return far, (row[2] - row[6]).register(pipe, "shared"), near

    @staticmethod
    def _along_row(pipe: Pipeline, taps: _Taps, beat: Value) -> _Number:
        """Clock 3: what the columns add meets, each sum waiting for the next column."""

        def register(number: _Number, name: str) -> _Number:
            return number.register(pipe, name, when=beat)

        left, inner = taps.left.twice(), taps.inner
        # joins the chain a beat late, where that would only wait
        fourth = register(taps.after_4.twice() + inner, "fourth")
        chain = register(left + taps.after_5, "chain_5")
        chain = register(chain + left, "chain_4")
        chain = register(chain + fourth, "chain_3")
        chain = register(chain + inner, "chain_2")
        chain = register(chain + (taps.right + taps.after_1).twice(), "chain_1")
        return register(chain + (taps.right.twice() + taps.now), "column")

    def _is_textured(self, pipe: Pipeline, column: _Number, beat: Value) -> Value:
        """Clock 4: tau >= T2.

        T2 is subtracted before a result's last column, first with the seventh of a row. It is the
        right frame's even then: seven beats behind the last of the frame before, when that one's
        result has left.
        """
        margin = column - _Number.any_of(self.thresholds.payload.t2)
        margin = margin.register(pipe, "margin_1", when=beat)
        # the middle of three columns is a window's last but one: so it is without its neighbours
        if self._regions:
            margin = (margin + column).register(pipe, "margin_2", when=beat)
            margin += column
        return ~margin.value[-1]
