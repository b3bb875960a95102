# amaranth: UnusedElaboratable=no
"""Normal equations of a gradient step (``golden.normal_equations``): five sums over a window."""

from __future__ import annotations

from itertools import accumulate
from types import SimpleNamespace
from typing import Any, NamedTuple

from amaranth.hdl import Module, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.derivatives import Derivatives
from golden.normal_equations import LARGEST, PLACE_BITS, STEP_SIZE
from hdl.build import Build
from hdl.derivatives import Format, layout
from hdl.parts.arithmetic import magnitude
from hdl.parts.lanes import Lanes, each_lane, lane_name
from hdl.parts.square_table import SquareTable
from hdl.parts.stream import Pipeline
from hdl.parts.weight_table import WEIGHT_BITS, Weighting
from hdl.pixel_store import column_layout
from hdl.step_layouts import columns_read
from hdl.window_tags import TagLine

ROWS = 2
"""Rows of gradients per clock; they need two more rows of pixels."""
PASSES = -(-STEP_SIZE // ROWS)
"""Passes over the window, from the top; the second row of the last one is below it."""
PAUSE = 2
"""Clocks, at least, between the last beat of a window and the first one of the next."""
_SUM, _MOMENT = Format(0, ((STEP_SIZE - 1) << PLACE_BITS) ** 2), Format(0, LARGEST)
FORMATS = Derivatives(_SUM, _SUM, _SUM, _MOMENT, _MOMENT)
"""Formats of the five sums, in full products."""


def first_complete(build: Build) -> int:
    """The first beat of a pass, from 0, that completes gradients: in its last lane, the first ones.

    There is one before at least.
    """
    return max(2 // columns_read(build), 1)


def pass_beats(build: Build) -> int:
    """Beats of a pass. The last one completes the last gradients in its last lane."""
    return first_complete(build) + 1 + (STEP_SIZE - 1) // columns_read(build)


def window_layout(build: Build) -> data.StructLayout:
    """A beat of columns of a pass, and what it completes.

    ``complete``: columns of gradients. Only where that is set: ``left`` and ``right``, the first
    and the last beat of the pass; ``top`` and ``bottom``, one of the first and the last pass; ``x``
    and ``y``, with the first one of the window: the weights of the column at the right and the row
    at the bottom, in units of 1/16.
    """
    return data.StructLayout(
        {
            "pixels": column_layout(build),
            **dict.fromkeys(("complete", "left", "right", "top", "bottom"), 1),
            "x": WEIGHT_BITS,
            "y": WEIGHT_BITS,
        }
    )


class _Column(NamedTuple):
    """Sums of a, b and d over two rows of gradients; C and b of the second one."""

    a: Value
    b: Value
    d: Value
    c2: Value
    b2: Value


class NormalEquations(wiring.Component):
    """Sums of A, B, C, A·u + C·v and C·u + B·v over one window after the other, with its weights.

    The window comes in passes of two rows of gradients. Squares come from tables, and with a, b and
    d those of gx, gy and gx - gy, C = (a + b - d) / 2. So do products with weights: first by row,
    of which only the first one of the first pass and of the last pass weighs less than 16; then by
    column, of which only the first and the last one do. Both are in the last lane of their beats.
    The other lanes begin later by the clocks that this takes; in a pass's first beat they are
    outside the window.

    No moment is multiplied: sums are added up again. With Q the sum of A over the columns of the
    pass before each, and T the sum of B over the passes up to each,

        Σ A·u = 4·Σ A - Σ Q          Σ B·v = 4·Σ B - 2·Σ T + Σ B of the second rows

    where the last pass has no T; and likewise for C. In a beat of L columns Σ Q is L times the sum
    over the beats before, and each column as many times as there are columns behind it in the beat.

    When a window is complete, all stands still until its sums are taken; then they start from 0.
    With several columns per clock they are taken into a register at once, if that is free.

    Members
    -------
    i
        Stream of ``window_layout(build)``: PASSES times ``pass_beats(build)`` beats for each
        window. Behind the last there must be PAUSE clocks or more. Its ready does not depend on its
        valid.
    o
        Stream of derivatives in :data:`FORMATS`.
    """

    def __init__(self, build: Build) -> None:
        bits = build.pixel_bits
        self._build, self._bits, self._lanes = build, bits, columns_read(build)
        self._layout = layout(FORMATS, build.product_max)
        square, difference = unsigned(2 * bits), unsigned(2 * bits + 2)
        lanes = range(self._lanes)
        self._squares = [[SquareTable(bits), SquareTable(bits), SquareTable(bits + 1)] for _ in lanes]
        self._rows = [
            Weighting([square, square, difference], lane_name("row", lane, self._lanes)) for lane in lanes
        ]
        # two rows at most, of which the first one has been weighted
        sums = [unsigned(shape.width + WEIGHT_BITS + 1) for shape in (square, square, difference)]
        self._columns = Weighting(sums, "column")
        self._second_c = Weighting([signed(2 * bits + 1)], "second_c")
        self._second_b = Weighting([square], "second_b")
        super().__init__(
            {
                "i": In(stream.Signature(window_layout(build))),
                "o": Out(stream.Signature(self._layout)),
            }
        )

    @property
    def _pass_bits(self) -> int:
        """Width of a sum over the columns of a pass, signed."""
        weights = ROWS * (STEP_SIZE - 1) << 2 * PLACE_BITS
        return (weights * ((1 << self._bits) - 1) ** 2).bit_length() + 1

    @property
    def memory_bits(self) -> int:
        weightings = (*self._rows, self._columns, self._second_c, self._second_b)
        squares = sum(table.memory_bits for tables in self._squares for table in tables)
        return squares + sum(weighting.memory_bits for weighting in weightings)

    def _begin(self, lane: int) -> int:
        """Clocks that a lane waits so that its sums come when those of the last lane are weighted.

        Where there are several such lanes, a clock sooner, for their sum.
        """
        if lane == self._lanes - 1:
            return 0
        return self._columns.latency - (self._lanes > 2)

    @property
    def _weighted_rows(self) -> int:
        """Clocks from the last lane's pixels to its first row of squares, weighted."""
        return 2 + SquareTable.latency + self._rows[0].latency

    @property
    def _weighted_columns(self) -> int:
        """Clocks from a column of pixels to its sums, weighted; those of C are a clock later."""
        return self._weighted_rows + 1 + max(self._columns.latency, self._second_c.latency)

    @property
    def _added_up(self) -> int:
        """Clocks from a beat of pixels to the sum of all its columns."""
        return self._weighted_columns + (self._lanes > 1)

    @property
    def latency(self) -> int:
        """Clocks from a window's last column to its sums."""
        return self._added_up + 4 + (self._lanes > 1)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        done, taken = Signal(), Signal()
        pipe = Pipeline(m, self.i, SimpleNamespace(ready=~done))
        line = TagLine(pipe, self.i.payload, PAUSE + 1 + first_complete(self._build))
        rows = [
            Lanes(pipe, each_lane(row, self._lanes), f"row_{k}")
            for k, row in enumerate(self.i.payload.pixels)
        ]
        lanes = [self._weigh_rows(m, pipe, line, rows, lane) for lane in range(self._lanes)]
        last = self._weigh_columns(m, pipe, line, lanes.pop())
        sums = self._sum(m, pipe, line, taken, self._add_up(pipe, last, lanes) if lanes else last)
        ends = line.at(self._added_up + 3)
        with m.If(taken):
            m.d.sync += done.eq(0)
        with m.Elif(pipe.advance):
            m.d.sync += done.eq(ends.right & ends.bottom)
        self._deliver(m, done, taken, sums)
        return m

    def _square(
        self, m: Module, pipe: Pipeline, line: TagLine, rows: list[Lanes], lane: int
    ) -> tuple[list[Value], list[Value]]:
        """a, b and d of the first row of gradients; of the second, when these are weighted."""
        tables, squares = self._squares[lane], []
        for k, table in enumerate(tables):
            m.submodules[lane_name(f"table_{k}", lane, self._lanes)] = table
            m.d.comb += table.enable.eq(pipe.advance)
        for row in range(ROWS):
            # the second row waits for the first one's products
            clock = 1 + self._begin(lane) + row * self._rows[lane].latency
            tags = line.at(clock)
            masked = tags.bottom if row else tags.bottom & (line.weight_at("y", clock) == 0)
            if lane < self._lanes - 1:
                masked |= tags.left
            middle, name = rows[row + 1], lane_name(f"{row}", lane, self._lanes)
            across = middle.back(2).values[lane] - middle.values[lane]
            down = rows[row].back(1).values[lane] - rows[row + 2].back(1).values[lane]
            gx, gy = (
                pipe.delay(g, clock, f"{n}_{name}").as_signed() for g, n in ((across, "gx"), (down, "gy"))
            )
            difference = (gx - gy)[: self._bits + 2].as_signed()
            numbers = [
                _register_or_0(m, pipe, value, masked, f"{n}_{name}")
                for n, value in (("gx_size", magnitude(gx)), ("gy_size", magnitude(gy)), ("d", difference))
            ]
            own = tables[row]
            m.d.comb += [
                own.x[0].eq(numbers[0]),
                own.x[1].eq(numbers[1]),
                tables[-1].x[row].eq(magnitude(numbers[2])),
            ]
            squares.append([Value.cast(v) for v in (own.square[0], own.square[1], tables[-1].square[row])])
        return squares[0], squares[1]

    def _weigh_rows(self, m: Module, pipe: Pipeline, line: TagLine, rows: list[Lanes], lane: int) -> _Column:
        first, second = self._square(m, pipe, line, rows, lane)
        weight = line.code("y", "top", "bottom", 2 + SquareTable.latency + self._begin(lane))
        products = self._rows[lane].look_up(m, pipe, first, weight)
        at = self._weighted_rows + self._begin(lane)
        # the last column may weigh nothing
        masked = line.at(at).right & (line.weight_at("x", at) == 0) if lane == self._lanes - 1 else None

        def sum_of(value: Value, name: str) -> Signal:
            name = lane_name(name, lane, self._lanes)
            return (
                pipe.register(value, name) if masked is None else _register_or_0(m, pipe, value, masked, name)
            )

        sums = [
            sum_of(product + (other << PLACE_BITS), f"sum_{name}")
            for name, product, other in zip("abd", products, second, strict=True)
        ]
        a, b, d = second
        c2 = sum_of((a + b - d)[1 : 2 * self._bits + 2].as_signed(), "second_c")
        return _Column(sums[0], sums[1], sums[2], c2, sum_of(b, "second_b"))

    def _weigh_columns(self, m: Module, pipe: Pipeline, line: TagLine, column: _Column) -> _Column:
        """The last lane's, in units of 1/256; b2 a clock later than the others."""
        now, end = self._weighted_rows + 1, self._weighted_columns

        def weighted(part: Weighting, numbers: list[Value], then: int, name: str) -> list[Value]:
            """Products at clock ``then``."""
            begin = then - part.latency
            late = [pipe.delay(each, begin - now, f"{name}_{k}") for k, each in enumerate(numbers)]
            return part.look_up(m, pipe, late, line.code("x", "left", "right", begin))

        a, b, d = weighted(self._columns, list(column[:3]), end, "waiting_sum")
        (c2,) = weighted(self._second_c, [column.c2], end, "waiting_c")
        (b2,) = weighted(self._second_b, [column.b2], end + 1, "waiting_b")
        return _Column(a, b, d, c2 << PLACE_BITS, b2 << PLACE_BITS)

    def _add_up(self, pipe: Pipeline, last: _Column, others: list[_Column]) -> _Column:
        """All columns of a beat, a clock later; c2 and b2 less the Q of A and of C in the beat."""

        def total(field: str) -> Value:
            """The others' values."""
            first, *rest = (getattr(other, field) for other in others)
            return pipe.register(sum(rest, start=first), f"others_{field}") if rest else first

        def total_behind(field: str) -> Value:
            """Each of them as many times as there are columns behind it."""
            first, *rest = accumulate(getattr(other, field) for other in others)
            return pipe.register(sum(rest, start=first), f"behind_{field}") if rest else first

        def everything(field: str) -> Signal:
            return pipe.register(getattr(last, field) + (total(field) << PLACE_BITS), f"all_{field}")

        a, b, d = (total_behind(field) for field in "abd")
        c = pipe.register((a + b - d)[1:].as_signed(), "behind_c")
        c2, b2 = total("c2"), pipe.register(total("b2"), "others_b2_late")
        # the last column's have their weights, in units of 1/256
        c2 = pipe.register(last.c2 + (((c2 << PLACE_BITS) - a) << PLACE_BITS), "all_c2")
        b2 = pipe.register(last.b2 + (((b2 << PLACE_BITS) - c) << PLACE_BITS), "all_b2")
        return _Column(everything("a"), everything("b"), everything("d"), c2, b2)

    def _sum(
        self, m: Module, pipe: Pipeline, line: TagLine, taken: Value, column: _Column
    ) -> dict[str, Value]:
        """Those of the window, three clocks after its last beat, until they are taken."""
        now = self._added_up
        width = {name: field.width for name, field in self._layout}

        def complete(clocks: int) -> Value:
            return line.at(now + clocks).complete

        def total(name: str, bits: int, *changes: tuple[Value, Value], clear: Value = taken) -> Signal:
            """The sum of each change in those clocks in which it applies."""
            value = Signal(signed(bits), name=name)
            for applies, change in changes:
                with m.If(pipe.advance & applies):
                    m.d.sync += value.eq(value + change)
            with m.If(clear):
                m.d.sync += value.eq(0)
            return value

        def before(name: str, value: Value, clocks: int) -> Value:
            """Sum over the pass's beats before, for each column of this one."""
            over = pipe.advance & line.at(now + clocks).right
            beats = total(f"before_{name}", self._pass_bits, (complete(clocks), value), clear=over)
            return beats << (self._lanes.bit_length() - 1)

        a, b, d, second_c, second_b = column
        c = pipe.register((a + b - d)[1:].as_signed(), "c")
        xx = total("xx", width["xx"], (complete(0), a))
        yy = total("yy", width["yy"], (complete(0), b))
        # the minus of xy is in the order of its difference
        xy = total("xy", width["xy"], (complete(1), -c))
        change_x = pipe.register(second_c - before("a", a, 0), "change_x")
        change_y = pipe.register(second_b - before("c", c, 1), "change_y")

        def passed(clocks: int) -> Value:
            tags = line.at(now + clocks)
            return tags.right & ~tags.bottom

        # between two passes there is a beat that is not complete; a shorter pause than that of one
        # column per clock does not leave yy as it is until then
        of_pass = pipe.delay(yy, int(self._lanes > 1), "yy_of_pass").as_signed()
        x = total("x", width["x"], (complete(1), change_x), (passed(2), xy << 1))
        y = total("y", width["y"], (complete(2), change_y), (passed(3), -(of_pass << 1)))
        return {
            "xx": xx,
            "yy": yy,
            "xy": xy,
            "x": x + (pipe.register(xx - xy, "xx_and_c") << 2),
            "y": y + (pipe.register(yy - xy, "yy_and_c") << 2),
        }

    def _deliver(self, m: Module, done: Signal, taken: Signal, sums: dict[str, Value]) -> None:
        """The sums themselves, or with several columns per clock what has been taken from them."""
        given = self.o.payload
        if self._lanes == 1:
            m.d.comb += [self.o.valid.eq(done), taken.eq(done & self.o.ready)]
            m.d.comb += [given[name].eq(value) for name, value in sums.items()]
            return
        m.d.comb += taken.eq(done & (~self.o.valid | self.o.ready))
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(taken):
            m.d.sync += [self.o.valid.eq(1), *(given[name].eq(value) for name, value in sums.items())]


def _register_or_0(m: Module, pipe: Pipeline, value: Value, masked: Value, name: str) -> Signal:
    register = Signal(value.shape(), name=name, reset_less=True)
    with m.If(pipe.advance):
        m.d.sync += register.eq(value)
        with m.If(masked):
            m.d.sync += register.eq(0)
    return register
