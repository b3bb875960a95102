# amaranth: UnusedElaboratable=no
"""Normal equations of a gradient step (``golden.normal_equations``): five sums over a window."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, NamedTuple

from amaranth.hdl import Cat, Module, Mux, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.derivatives import Derivatives
from golden.normal_equations import LARGEST, PLACE_BITS, STEP_SIZE
from golden.parameters import Parameters
from hdl.derivatives import Format, layout
from hdl.parts.arithmetic import magnitude
from hdl.parts.square_table import SquareTable
from hdl.parts.stream import Pipeline
from hdl.parts.weight_table import WEIGHT_BITS, Weighting
from hdl.pixel_store import BANKS

LANES = 2
"""Rows of gradients per clock; they need two more rows of pixels."""
PASSES = -(-STEP_SIZE // LANES)
"""Passes over the window, from the top; the second lane of the last one is below it."""
COLUMNS = STEP_SIZE + 2
"""Columns of pixels of each pass."""
PAUSE = 2
"""Clocks, at least, between the last column of a window and the first one of the next."""
_APART = PAUSE + 3
"""From the last gradients of a window to the first ones of the next, which need three columns."""
_SUM, _MOMENT = Format(0, ((STEP_SIZE - 1) << PLACE_BITS) ** 2), Format(0, LARGEST)
FORMATS = Derivatives(_SUM, _SUM, _SUM, _MOMENT, _MOMENT)
"""Formats of the five sums, in full products."""


def window_layout(parameters: Parameters) -> data.StructLayout:
    """A column of a pass, and what it completes.

    ``complete``: a column of gradients. Only where that is set: ``left`` and ``right``, the first
    and the last of the pass; ``top`` and ``bottom``, that of the first and the last pass; ``x`` and
    ``y``, with the first one of the window: the weights of the column at the right and the row at
    the bottom, in units of 1/16.
    """
    return data.StructLayout(
        {
            "pixels": data.ArrayLayout(unsigned(parameters.pixel_bits), BANKS),
            **dict.fromkeys(("complete", "left", "right", "top", "bottom"), 1),
            "x": WEIGHT_BITS,
            "y": WEIGHT_BITS,
        }
    )


class _Tags(NamedTuple):
    """Which of the columns are where, at some clock of the pipeline."""

    complete: Value
    left: Value
    right: Value
    top: Value
    bottom: Value


class NormalEquations(wiring.Component):
    """Sums of A, B, C, A·u + C·v and C·u + B·v over one window after the other, with its weights.

    The window comes in passes of two rows of gradients. Squares come from tables, and with a, b and
    d those of gx, gy and gx - gy, C = (a + b - d) / 2. So do products with weights: first by row,
    of which only the first one of the first pass and of the last pass weighs less than 16; then by
    column, of which only the first and the last one do.

    No moment is multiplied: sums are added up again. With Q the sum of A over the columns of the
    pass before each, and T the sum of B over the passes up to each,

        Σ A·u = 4·Σ A - Σ Q          Σ B·v = 4·Σ B - 2·Σ T + Σ B of the second rows

    where the last pass has no T; and likewise for C. When a window is complete, all stands still
    until its sums are taken; then they start from 0.

    Members
    -------
    i
        Stream of ``window_layout(parameters)``: PASSES times COLUMNS columns for each window, the
        first two of a pass complete nothing. Behind the last there must be PAUSE clocks or more.
        Its ready does not depend on its valid.
    o
        Stream of derivatives in :data:`FORMATS`.
    """

    def __init__(self, parameters: Parameters) -> None:
        bits = parameters.pixel_bits
        self._bits = bits
        self._layout = layout(FORMATS, parameters.product_max)
        self._squares = [SquareTable(bits), SquareTable(bits), SquareTable(bits + 1)]
        square, difference = unsigned(2 * bits), unsigned(2 * bits + 2)
        self._rows = Weighting([square, square, difference], "row")
        # two rows at most, of which the first one has been weighted
        sums = [unsigned(shape.width + WEIGHT_BITS + 1) for shape in (square, square, difference)]
        self._columns = Weighting(sums, "column")
        self._second_c = Weighting([signed(2 * bits + 1)], "second_c")
        self._second_b = Weighting([square], "second_b")
        super().__init__(
            {
                "i": In(stream.Signature(window_layout(parameters))),
                "o": Out(stream.Signature(self._layout)),
            }
        )

    @property
    def _pass_bits(self) -> int:
        """Width of a sum over the columns of a pass, signed."""
        weights = LANES * (STEP_SIZE - 1) << 2 * PLACE_BITS
        return (weights * ((1 << self._bits) - 1) ** 2).bit_length() + 1

    @property
    def memory_bits(self) -> int:
        weightings = (self._rows, self._columns, self._second_c, self._second_b)
        squares = sum(table.memory_bits for table in self._squares)
        return squares + sum(weighting.memory_bits for weighting in weightings)

    @property
    def _weighted_rows(self) -> int:
        """Clocks from a column of pixels to its first row of squares, weighted."""
        return 2 + SquareTable.latency + self._rows.latency

    @property
    def _weighted_columns(self) -> int:
        """Clocks from a column of pixels to its sums, weighted; those of C are a clock later."""
        return self._weighted_rows + 1 + max(self._columns.latency, self._second_c.latency)

    @property
    def latency(self) -> int:
        """Clocks from a window's last column to its sums."""
        return self._weighted_columns + 4

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, SimpleNamespace(ready=~self.o.valid))
        line = _TagLine(pipe, self.i.payload)
        first, second = self._square(m, pipe, line)
        self._sum(m, pipe, line, *self._weigh(m, pipe, line, first, second))
        return m

    def _square(self, m: Module, pipe: Pipeline, line: _TagLine) -> tuple[list[Value], list[Value]]:
        """a, b and d of the first row of gradients; of the second, when these are weighted."""
        newest = self.i.payload.pixels
        # the columns before, and before that
        centre = [pipe.register(newest[k], f"centre_{k}", when=pipe.valid) for k in range(BANKS)]
        tables, squares = self._squares, []
        for k, table in enumerate(tables):
            m.submodules[f"table_{k}"] = table
            m.d.comb += table.enable.eq(pipe.advance)
        late = self._rows.latency
        nothing = line.at(1).bottom & (line.weight_at("y", 1) == 0)
        for lane, masked in enumerate((nothing, line.at(1 + late).bottom)):
            left = pipe.register(centre[lane + 1], f"left_{lane}", when=pipe.valid)
            gx = pipe.register(left - newest[lane + 1], f"gx_{lane}")
            gy = pipe.register(centre[lane] - centre[lane + 2], f"gy_{lane}")
            # the second row waits for the first one's products
            gx, gy = (
                pipe.delay(g, lane * late, f"{n}_{lane}").as_signed() for g, n in ((gx, "gx"), (gy, "gy"))
            )
            difference = (gx - gy)[: self._bits + 2].as_signed()
            numbers = [
                _register_or_0(m, pipe, value, masked, f"{name}_{lane}")
                for name, value in (("gx_size", magnitude(gx)), ("gy_size", magnitude(gy)), ("d", difference))
            ]
            own = tables[lane]
            m.d.comb += [
                own.x[0].eq(numbers[0]),
                own.x[1].eq(numbers[1]),
                tables[-1].x[lane].eq(magnitude(numbers[2])),
            ]
            squares.append([Value.cast(v) for v in (own.square[0], own.square[1], tables[-1].square[lane])])
        return squares[0], squares[1]

    def _weigh(
        self, m: Module, pipe: Pipeline, line: _TagLine, first: list[Value], second: list[Value]
    ) -> tuple[list[Value], Value, Value]:
        """Sums of a, b and d down a pass's column; C of the second row, and B, a clock later."""
        weight = line.code("y", "top", "bottom", 2 + SquareTable.latency)
        rows = self._rows.look_up(m, pipe, first, weight)
        at, end = self._weighted_rows, self._weighted_columns

        def unless_0(value: Value, clock: int, name: str) -> Signal:
            """The value at the clock after this one, or 0 where the last column weighs nothing."""
            masked = line.at(clock).right & (line.weight_at("x", clock) == 0)
            return _register_or_0(m, pipe, value, masked, name)

        sums = [
            unless_0(row + (other << PLACE_BITS), at, f"sum_{name}")
            for name, row, other in zip("abd", rows, second, strict=True)
        ]
        a, b, d = second
        b = unless_0(b, at, "second_b")
        c = unless_0((a + second[1] - d)[1 : 2 * self._bits + 2].as_signed(), at, "second_c")

        def weighted(part: Weighting, numbers: list[Value], now: int, then: int, name: str) -> list[Value]:
            """Products at clock ``then`` of numbers at clock ``now``."""
            begin = then - part.latency
            late = [pipe.delay(each, begin - now, f"{name}_{k}") for k, each in enumerate(numbers)]
            return part.look_up(m, pipe, late, line.code("x", "left", "right", begin))

        sums = weighted(self._columns, sums, at + 1, end, "waiting_sum")
        (c,) = weighted(self._second_c, [c], at + 1, end, "waiting_c")
        (b,) = weighted(self._second_b, [b], at + 1, end + 1, "waiting_b")
        return sums, c << PLACE_BITS, b << PLACE_BITS

    def _sum(
        self, m: Module, pipe: Pipeline, line: _TagLine, column: list[Value], second_c: Value, second_b: Value
    ) -> None:
        now = self._weighted_columns
        taken = self.o.valid & self.o.ready

        def complete(clocks: int) -> Value:
            return line.at(now + clocks).complete

        width = {name: field.width for name, field in self._layout}

        def total(name: str, bits: int, *changes: tuple[Value, Value], clear: Value = taken) -> Signal:
            """The sum of each change in those clocks in which it applies."""
            value = Signal(signed(bits), name=name)
            for applies, change in changes:
                with m.If(pipe.advance & applies):
                    m.d.sync += value.eq(value + change)
            with m.If(clear):
                m.d.sync += value.eq(0)
            return value

        def before(name: str, value: Value, clocks: int) -> Signal:
            """Sum over the pass's columns before."""
            over = pipe.advance & line.at(now + clocks).right
            return total(f"before_{name}", self._pass_bits, (complete(clocks), value), clear=over)

        a, b, d = column
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

        x = total("x", width["x"], (complete(1), change_x), (passed(2), xy << 1))
        y = total("y", width["y"], (complete(2), change_y), (passed(3), -(yy << 1)))
        ends = line.at(now + 3)
        with m.If(taken):
            m.d.sync += self.o.valid.eq(0)
        with m.Elif(pipe.advance):
            m.d.sync += self.o.valid.eq(ends.right & ends.bottom)
        m.d.comb += [
            self.o.payload.xx.eq(xx),
            self.o.payload.yy.eq(yy),
            self.o.payload.xy.eq(xy),
            self.o.payload.x.eq(x + (pipe.register(xx - xy, "xx_and_c") << 2)),
            self.o.payload.y.eq(y + (pipe.register(yy - xy, "yy_and_c") << 2)),
        ]


class _TagLine:
    """Tags and weights of a window beside the pipeline, at any clock of it."""

    def __init__(self, pipe: Pipeline, given: Any) -> None:
        self._pipe = pipe
        tags = [pipe.valid & getattr(given, name) for name in _Tags._fields]
        self._line: list[Value] = [Cat(*tags)]
        self._given = given

    def at(self, clock: int) -> _Tags:
        """The tags so many clocks later."""
        while len(self._line) <= clock:
            name = f"tags_{len(self._line)}"
            self._line.append(self._pipe.register(self._line[-1], name, reset=True))
        return _Tags(*self._line[clock])

    def weight_at(self, axis: str, clock: int) -> Signal:
        """The weight that the columns at this clock of the pipeline have, from 1 on.

        It is handed on with the first column of a window. The next one's is five clocks behind the
        last column, so that one register serves for five clocks.
        """
        begin = 1 + (clock - 1) // _APART * _APART
        start = self.at(begin - 1)
        weight = self._given[axis] if begin == 1 else self.weight_at(axis, 1)
        name = f"{axis}_at_{begin}"
        if name not in self._pipe.registers:
            self._pipe.register(weight, name, when=start.left & start.top)
        return self._pipe.registers[name]

    def code(self, axis: str, first: str, last: str, clock: int) -> Signal:
        """The weight for tables, of columns that have one of two tags, or 16 of those without.

        Both add up to 16, of which 0 is the code.
        """
        tags = self.at(clock - 1)
        weight = self.weight_at(axis, clock - 1)
        code = Mux(getattr(tags, first), -weight, Mux(getattr(tags, last), weight, 0))
        return self._pipe.register(code[:WEIGHT_BITS], f"{axis}_code_{clock}")


def _register_or_0(m: Module, pipe: Pipeline, value: Value, masked: Value, name: str) -> Signal:
    register = Signal(value.shape(), name=name, reset_less=True)
    with m.If(pipe.advance):
        m.d.sync += register.eq(value)
        with m.If(masked):
            m.d.sync += register.eq(0)
    return register
