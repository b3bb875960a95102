# amaranth: UnusedElaboratable=no
"""Convolution (Eq. 1): squares from tables, smoothed by the separable 5x5 kernel of adders."""

from __future__ import annotations

from functools import partial
from typing import Any

from amaranth.hdl import C, Cat, Module, ShapeLike, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.convolution import SHIFT
from golden.formats import SMOOTHING_SIZE
from golden.parameters import Parameters
from hdl.build import Build
from hdl.gradient_squares import GradientSquares, gradient_difference
from hdl.parts.delay_line import DelayLine
from hdl.parts.lanes import Lanes, deliver, each_lane, lanes_of
from hdl.parts.stream import Beat, Columns, Pipeline
from hdl.preprocessing import difference_shape, gradient_shape, sizes_shape

LATE_ROWS = (1, 2, 3)
"""Rows looked up a clock after the outer two, so that their sums do not meet in one clock."""
MIDDLE_ROW = 2
"""The only one with several pixels per clock, where registers cost more."""
MIDDLE_LATE = 2
"""How many clocks later, so that no sum of two adders begins in block RAM, which is far away."""
CROSS_LATE = 2
"""Clocks that C comes later with several pixels per clock where A and B wait for it: a sum each."""


def products_layout(parameters: Parameters) -> data.StructLayout:
    """A, B and C after smoothing; C has a sign only where gradients have one."""
    bits = parameters.product_bits
    c = signed(bits + 1) if parameters.algorithm.gradient == "signed" else unsigned(bits)
    return data.StructLayout({"a": unsigned(bits), "b": unsigned(bits), "c": c})


def square_pairs(build: Build) -> int:
    """Pairs of squares that the convolution needs: see ``Build.multiplied_pairs``."""
    return GradientSquares.pairs(SMOOTHING_SIZE, build.pixels_per_clock)


def products_shape(build: Build) -> ShapeLike:
    """The products of a beat: ``products_layout(build)``, or an array of it, the leftmost first."""
    return lanes_of(products_layout(build), build.pixels_per_clock)


def _column_sum(rows: list[Lanes], name: str, *, half: bool = False) -> Lanes:
    """Sum of one channel down a column under [1 2 2 2 1].

    Parameters
    ----------
    rows
        Five rows of unsigned values of one width. With one pixel per clock the middle three come a
        clock after the others; otherwise only the third comes later, by a clock or two.
    name
        Name of the channel.
    half
        Add 32, half a unit of the result, in the sum of five columns. ``rows`` must be squares:
        these are 0 or 1 modulo 4.

    Returns
    -------
    The sum, three bits wider than a row: 2 clocks after the outer rows, of which the second with
    one pixel per clock is still to come; otherwise a clock after the third.
    """
    first, second, third, fourth, fifth = rows
    width = len(first.values[0])
    if half:
        # bit 1 of a square is always 0: a 2 there, in a row of weight 2, in columns of weight 8, is
        # 32
        second = second.map(lambda square: Cat(square[0], C(1, 1), square[2:]))
    outer = (first + fifth).register(f"{name}_outer")
    # what is doubled leaves bit 0 alone
    if len(outer) > 1:
        inner = (second + fourth).register(f"{name}_inner")
        upper = outer.map(_with_double, inner)
        upper = upper.register(f"{name}_upper", third.clock - upper.clock)
        return upper.map(_with_double, third)[: width + 3].register(f"{name}_column")
    upper = outer.map(_with_double, second).register(f"{name}_upper")
    inner = (third + fourth).register(f"{name}_inner")
    return upper.map(_with_double, inner)[: width + 3]


def _with_double(value: Value, doubled: Value) -> Value:
    return Cat(value[0], value[1:] + doubled)


def _pairs(column: Lanes, name: str) -> Lanes:
    """Sums of neighbours, which lanes share, a clock later."""
    return (column + column.back(1)).register(f"{name}_pairs")


def _sum_of_pairs(pairs: Lanes, name: str, *, clocks: int = 2) -> Lanes:
    """The sum of five columns out of sums of neighbours, one or two clocks later.

    Lanes share the sums of four columns, too.
    """
    fours = (pairs + pairs.back(1)).register(f"{name}_fours", clocks - 1)
    return (fours + fours.back(2)).register(f"{name}_total")


def _row_sum(column: Lanes, name: str) -> Lanes:
    """Sum of five columns under [1 2 2 2 1], three bits wider, with the window's last column.

    With one pixel per clock it takes one clock, otherwise three.
    """
    if len(column) > 1:
        return _sum_of_pairs(_pairs(column, name), name)
    # the column meets the four before it in a chain of adders, in which each register holds the
    # part of one window that has been seen
    taps = column.back(1)
    for k in range(2, SMOOTHING_SIZE):
        # 1 + 2 + 2 + 2: never more than three bits above the column's sum
        sums = taps.map(_tap, column, name=f"{name}_taps_{k}")
        taps = sums.back(1)
    return (taps + column)[: len(column.values[0]) + 3].register(f"{name}_total")


def _tap(taps: Value, column: Value) -> Value:
    return Cat(taps[0], (taps[1:] + column)[: len(column) + 2])


def _cross(a: Value, b: Value, d: Value) -> Value:
    """(a + b - d) / 2: that is even, so bit 0 of a + b is that of d, and neither is needed."""
    return (a + b)[1:] - d[1:]


def _cross_less_one(a: Value, b: Value, d: Value) -> Value:
    """The same less 1, subtracted without its carry."""
    return (a + b)[1:] + ~d[1:]


def _round_halves(total: Value) -> Value:
    """C of a signed sum that has 28 in it: half a unit, less 4 for pairs of one less."""
    # halves away from zero: 4 more from 0 up, 3 below; between them either gives 0
    negative = total[-1]
    return (total + Cat(negative.replicate(2), ~negative))[SHIFT : len(total)].as_signed()


class Convolution(wiring.Component):
    """Smooths A, B and C: kernel [1 2 2 2 1]ᵀ[1 2 2 2 1] / 64, rounded once, half away from zero.

    Takes columns of five rows of numbers, delivers rows four columns shorter. With a, b and d the
    squares of gx, gy and their difference, gx·gy = (a + b - d) / 2: so A and B are sums of a and b,
    and C = (A + B - D) / 2 with D that of d, made of the full sums before any of them is rounded.
    The half of rounding is already in the sums of a and b, so in C too. With several pixels per
    clock, what C is the sum of is made of the sums down a column.

    With several pixels per clock and without signs, each clock makes one sum, and A and B wait for
    C. With signs they do not: their registers, 32 for each lane and clock, would take more than the
    clock frequency of that build is worth.

    c may come from an adder, not from a register: the next block should register it before it
    computes.

    Members
    -------
    i
        Stream of ``Columns(sizes_shape(parameters), 5)``.
    o
        Stream of ``Beat(products_shape(parameters))``.
    """

    def __init__(self, parameters: Build) -> None:
        self._signed = parameters.algorithm.gradient == "signed"
        self._bits = parameters.product_bits
        self._lanes = parameters.pixels_per_clock
        self._lost = 2 * parameters.algorithm.response_margin - (SMOOTHING_SIZE - 1)
        # rows of all lanes
        self._squares = GradientSquares(
            gradient_shape(parameters),
            difference_shape(parameters),
            SMOOTHING_SIZE,
            self._lanes,
            parameters.multiplied_pairs,
        )
        self._tags = DelayLine(2, self.latency) if self._lanes > 1 else None
        super().__init__(
            {
                "i": In(stream.Signature(Columns(sizes_shape(parameters), SMOOTHING_SIZE))),
                "o": Out(stream.Signature(Beat(products_shape(parameters)))),
            }
        )

    @property
    def latency(self) -> int:
        """Signed products round on either side of zero, which may take a clock of its own.

        With several pixels per clock there are other sums between registers.
        """
        if self._lanes == 1:
            return GradientSquares.latency + 3 + self._signed
        return GradientSquares.latency + 6 + self._cross_late

    @property
    def _cross_late(self) -> int:
        return 0 if self._lanes == 1 or self._signed else CROSS_LATE

    @property
    def memory_bits(self) -> int:
        return self._squares.memory_bits + (self._tags.memory_bits if self._tags else 0)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        squares = self._look_up(m, pipe)
        columns = [_column_sum(squares[name], name, half=name != "d") for name in "abd"]
        if self._lanes > 1:
            pairs_a, pairs_b = _pairs(columns[0], "a"), _pairs(columns[1], "b")
            a, b = _sum_of_pairs(pairs_a, "a"), _sum_of_pairs(pairs_b, "b")
            if self._signed:
                c = self._cross_of_pairs(pairs_a, pairs_b, _pairs(columns[2], "d"))
            else:
                c = self._cross_of_columns(*columns)
        else:
            a, b, d = (_row_sum(column, name) for column, name in zip(columns, "abd", strict=True))
            c = self._signed_cross(a, b, d) if self._signed else a.map(_cross, b, d)[SHIFT:]
        a, b = (
            total[SHIFT:].register(f"{name}_rounded", c.clock - total.clock)
            for name, total in (("a", a), ("b", b))
        )
        for lane, products in enumerate(each_lane(self.o.payload.data, self._lanes)):
            m.d.comb += [
                products.a.eq(a.values[lane]),
                products.b.eq(b.values[lane]),
                products.c.eq(c.values[lane]),
            ]
        deliver(m, pipe, self.i, self.o, c, lost=self._lost, more=SMOOTHING_SIZE - 1, line=self._tags)
        return m

    def _look_up(self, m: Module, pipe: Pipeline) -> dict[str, list[Lanes]]:
        """Squares by channel and row."""
        given: dict[str, list[Lanes]] = {"a": [], "b": [], "d": []}
        for row in range(SMOOTHING_SIZE):
            for name, numbers in self._numbers(pipe, row).items():
                given[name].append(numbers)
        # row by row, the lanes of each from the left
        found = self._squares.look_up(
            m, pipe, *([v for n in rows for v in n.values] for rows in given.values())
        )
        return {
            name: [
                Lanes(
                    pipe,
                    found[name][row * self._lanes : (row + 1) * self._lanes],
                    f"{name}_square_{row}",
                    numbers.clock + GradientSquares.latency,
                ).register(f"{name}_near", self._near(row) if name == "d" else 0)
                for row, numbers in enumerate(rows)
            ]
            for name, rows in given.items()
        }

    def _numbers(self, pipe: Pipeline, row: int) -> dict[str, Lanes]:
        """What is looked up for a row, in the clock in which that happens."""
        beat = each_lane(self.i.payload.data[row], self._lanes)
        gx, gy = (Lanes(pipe, [sizes[name] for sizes in beat], name) for name in ("gx", "gy"))
        if self._lanes == 1:
            difference = Lanes(pipe, [sizes.difference for sizes in beat], "difference")
            late = int(row in LATE_ROWS)
        else:
            # an adder before block RAM would be a long path
            difference = gx.map(partial(gradient_difference, signed=self._signed), gy)
            difference = difference.register(f"difference_{row}")
            late = MIDDLE_LATE if row == MIDDLE_ROW else 0
        # where C may wait, a difference is as late behind the outer ones as a gradient; where not,
        # its square waits near by instead
        with_it = difference.clock if self._cross_late else -self._near(row)
        return {
            name: numbers.register(f"{name}_late_{row}", max(clock - numbers.clock, 0))
            for name, numbers, clock in (("a", gx, late), ("b", gy, late), ("d", difference, late + with_it))
        }

    def _near(self, row: int) -> int:
        """Clocks in which the squares of a row's differences wait, out of far block RAM.

        The middle row's are next added to a sum of two adders, in one clock.
        """
        return int(self._lanes > 1 and not self._cross_late and row == MIDDLE_ROW)

    def _cross_of_columns(self, a: Lanes, b: Lanes, d: Lanes) -> Lanes:
        """C rounded, from sums down the columns."""
        width = len(a.values[0])
        both = (a + b)[1:].register("both_columns")
        column = both.map(lambda both, d: (both - d[1:])[:width], d).register("c_column")
        return _row_sum(column, "c")[SHIFT:]

    def _cross_of_pairs(self, a: Lanes, b: Lanes, d: Lanes) -> Lanes:
        """Signed C rounded, in the clock of the sums A and B.

        Two sums meet in a clock twice, so not where columns come from far away: neighbouring
        columns of d are added first, as those of a and b are.
        """
        width = len(a.values[0])
        pairs = a.map(lambda a, b, d: _cross_less_one(a, b, d)[: width + 1].as_signed(), b, d)
        return _sum_of_pairs(pairs.register("c_pairs"), "c", clocks=1).map(_round_halves)

    def _signed_cross(self, a: Lanes, b: Lanes, d: Lanes) -> Lanes:
        """C rounded, one clock later: halves away from zero."""
        # subtracted without its carry: C + 31, to which only those from 0 up still add 1
        size = self._bits + SHIFT + 1
        lower = a.map(lambda a, b, d: _cross_less_one(a, b, d)[:size].as_signed(), b, d).register("lower")
        return lower.map(lambda lower: (lower + ~lower[-1]) >> SHIFT)
