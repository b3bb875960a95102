"""Non-textured corner filter (Eqs. 6-9, Fig. 12) of windows that are read one after the other."""

from __future__ import annotations

from typing import Any, NamedTuple

from amaranth.hdl import C, Cat, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import WINDOW_SIZE
from hdl.build import Build
from hdl.parts.lanes import each_lane, lanes_of
from hdl.parts.stream import Beat, Columns, Pipeline
from hdl.sample import response_layout
from hdl.texture_filter import TextureFilter
from hdl.thresholds import thresholds_layout

HALF = WINDOW_SIZE // 2
"""Columns, or rows, on either side of a window's centre."""


class _Sum(NamedTuple):
    """A number, and bits that are still to be added to it: the carries of additions to come."""

    value: Value
    ones: list[Value]


class CandidateTexture(wiring.Component):
    """F: is tau = tau12 + tau23 of the 9x9 window below T2?

    It takes the place of :class:`hdl.texture_filter.TextureFilter` where only candidates have
    windows, and is about half as large: each window is summed up by itself, so that nothing waits
    for later columns.

    tau is the sum over eight 3x3 boxes of absolute differences of diagonal neighbours, two boxes in
    each quarter of the window. A difference is that of an *inner* response, and of the *outer* one
    that lies one pixel further from the centre in x and in y. So all quarters are alike:

        d(m, s)   outer: m = 1 to 4 rows from the centre row, 4-s columns from the centre column
                  inner: m-1 rows and 3-s columns, s = 0 to 3

    The outer box has m = 4, 3, 2 and s = 0, 1, 2, the inner one m = 3, 2, 1 and s = 1, 2, 3; with
    ``patches="pixels"`` each is its centre alone. Both halves of the window are read from the outer
    column to the centre, one after the other; the centre column comes twice.

    With two columns per clock (``Build.window_reads``) both halves are read at the same time: the
    left one from the outer column, the right one from the centre. There s counts down.

    With one column per clock these are 634 logic elements of Cyclone IV by the project's estimate
    (8-bit pixels), with two 1,174; the texture filter, which keeps sums of later windows, 1,051.
    Two readers in turn would need two of these, and a second selection of a lane (720).

    An absolute value is the difference with all its bits inverted where it is negative, and 1 more,
    which is the carry of a later addition.

    Clocks: 1 differences, 2 sums of the upper and the lower one, 1 or 2 over the rows (and halves),
    1 what counts twice (with regions), 1 over the columns, from -T2.

    Members
    -------
    i
        Stream of ``Columns(lanes_of(response_layout(build), build.window_reads), 9)``: windows in
        :func:`window_order`.
    thresholds
        Stream of ``thresholds_layout(build)``, one per frame, taken with the frame's last result.
    o
        Stream of ``Beat(TextureFilter.verdict(build))``, one for each window.
    """

    def __init__(self, build: Build) -> None:
        self._build, self._halves = build, build.window_reads
        self._regions = build.algorithm.patches == "regions"
        self.latency = 5 + (self._halves - 1) - (not self._regions)
        sample = lanes_of(response_layout(build), self._halves)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(sample, WINDOW_SIZE))),
                "thresholds": In(stream.Signature(thresholds_layout(build))),
                "o": Out(stream.Signature(Beat(TextureFilter.verdict(build)))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.thresholds.valid)
        limits, tags = self.thresholds.payload, self.i.payload
        m.d.comb += self.thresholds.ready.eq(self.o.valid & self.o.ready & self.o.payload.eof)
        first, places = self._follow(m, pipe)
        once, twice = self._leaves(pipe, places)
        rows = self._tree(pipe, once, "once")
        if twice:
            both = self._tree(pipe, twice, "twice")
            middle = pipe.delay(places[1] | places[2], self.latency - 2, "middle")
            rows = self._weigh(pipe, rows, both, middle)
        first = pipe.delay(first, self.latency - 1, "first")
        textured = ~self._over_columns(m, pipe, rows, first)[-1]
        result = self.o.payload
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & tags.eol, self.latency, "valid", reset=True)),
            result.data.textured.eq(textured),
            result.data.keep.eq(~textured | limits.report_rejected),
            result.eol.eq(C(1, 1)),
            result.eof.eq(pipe.delay(tags.eof, self.latency, "eof")),
        ]
        return m

    def _follow(self, m: Module, pipe: Pipeline) -> tuple[Value, list[Value]]:
        """Is a window's first column offered, and is s of the first half 0, 1, 2, 3?"""
        first, columns = Signal(init=1), Signal(range(HALF + 1))
        with m.If(pipe.valid & pipe.advance):
            m.d.sync += [
                first.eq(self.i.payload.eol),
                columns.eq(Mux(columns == HALF, 0, columns + 1)),
            ]
        return pipe.valid & first, [pipe.valid & (columns == k + 1) for k in range(HALF)]

    def _leaves(self, pipe: Pipeline, places: list[Value]) -> tuple[list[_Sum], list[_Sum]]:
        """Clocks 1 and 2, by half and m: what counts once, and what counts twice for s = 1, 2."""
        once: list[_Sum] = []
        twice: list[_Sum] = []
        places = [pipe.register(place, f"place_{k}") for k, place in enumerate(places)]
        for half in range(self._halves):
            column = [Value.cast(each_lane(row, self._halves)[half]) for row in self.i.payload.data]
            before = [
                pipe.register(value, f"before_{half}_{k}", when=pipe.valid) for k, value in enumerate(column)
            ]
            outer, inner = (column, before) if half else (before, column)
            s = places[::-1] if half else places
            for m, counts in self._counts(s).items():
                above = _size(pipe, inner[HALF - m + 1] - outer[HALF - m], f"above_{half}_{m}")
                below = _size(pipe, inner[HALF + m - 1] - outer[HALF + m], f"below_{half}_{m}")
                # a synchronous clear, which costs no logic
                leaf = _add(above, below)
                leaf = _Sum(
                    pipe.register(Mux(counts, leaf.value, 0), f"leaf_{half}_{m}"),
                    [pipe.register(one & counts, f"leaf_one_{half}_{m}") for one in leaf.ones],
                )
                (twice if self._regions and m in (2, 3) else once).append(leaf)
        return once, twice

    def _counts(self, s: list[Value]) -> dict[int, Value]:
        """By m: for which s does it count?"""
        if not self._regions:
            return {3: s[1], 2: s[2]}
        inside = s[1] | s[2]
        return {4: s[0] | inside, 3: s[0] | inside | s[3], 2: s[0] | inside | s[3], 1: inside | s[3]}

    @staticmethod
    def _tree(pipe: Pipeline, leaves: list[_Sum], name: str) -> _Sum:
        """A clock for each level."""
        while len(leaves) > 1:
            pairs = zip(leaves[::2], leaves[1::2], strict=True)
            leaves = [
                _register(pipe, _add(a, b), f"{name}_{len(leaves)}_{k}") for k, (a, b) in enumerate(pairs)
            ]
        return leaves[0]

    @staticmethod
    def _weigh(pipe: Pipeline, once: _Sum, twice: _Sum, middle: Value) -> _Sum:
        """The second one counts twice in the middle columns."""
        (one,) = twice.ones
        twice = _Sum(Mux(middle, Cat(one, twice.value), twice.value), [one])
        return _register(pipe, _add(once, twice), "weighed")

    def _over_columns(self, m: Module, pipe: Pipeline, rows: _Sum, first: Value) -> Signal:
        """The last clock: tau - T2 so far. With a window's first column there is nothing to add."""
        t2, (one,) = self.thresholds.payload.t2, rows.ones
        bits = max(self._build.texture_max.bit_length(), len(t2)) + 1
        margin = Signal(bits, name="margin", reset_less=True)
        # -T2 is ~T2 and 1 more
        start = ~Cat(t2, C(0, bits - len(t2)))
        so_far = _add(_Sum(Mux(first, start, margin), []), _Sum(rows.value, [one | first]))
        with m.If(pipe.advance):
            m.d.sync += margin.eq(so_far.value[:bits])
        return margin


def _add(a: _Sum, b: _Sum) -> _Sum:
    """Their sum; one of the ones is the carry."""
    *ones, carry = [C(0, 1), *a.ones, *b.ones]
    return _Sum((Cat(C(1, 1), a.value) + Cat(carry, b.value))[1:], ones[1:])


def _register(pipe: Pipeline, number: _Sum, name: str) -> _Sum:
    ones = [pipe.register(one, f"{name}_one_{k}") for k, one in enumerate(number.ones)]
    return _Sum(pipe.register(number.value, name), ones)


def _size(pipe: Pipeline, difference: Value, name: str) -> _Sum:
    """Clock 1: the absolute value of a difference."""
    value = pipe.register(difference, name)
    return _Sum(value[:-1] ^ value[-1].replicate(len(value) - 1), [value[-1]])
