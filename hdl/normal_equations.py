# amaranth: UnusedElaboratable=no
"""Normal equations of the gradient step (``golden.normal_equations``): five sums over 7x7."""

from __future__ import annotations

from typing import Any, NamedTuple

from amaranth.hdl import Cat, Module, Signal, Value, signed
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.derivatives import Derivatives
from golden.normal_equations import LARGEST, STEP_SIZE
from golden.parameters import Parameters
from hdl.derivatives import Format, layout
from hdl.gradient_squares import GradientSquares
from hdl.parts.outgoing_column import outgoing_column
from hdl.parts.stream import Columns, Pipeline, WindowCounter
from hdl.preprocessing import sizes_layout

REACH = STEP_SIZE // 2
_SUM, _MOMENT = Format(0, STEP_SIZE**2), Format(0, LARGEST)
FORMATS = Derivatives(_SUM, _SUM, _SUM, _MOMENT, _MOMENT)
"""Formats of the five sums, in full products."""
COLUMN_LATENCY = GradientSquares.latency + 4
"""Look-up, pairs of rows, pairs of pairs, sum over them, C out of A, B and D."""


def signed_sizes(parameters: Parameters) -> data.StructLayout:
    """Sizes of signed gradients and of their difference, as preprocessing delivers them."""
    return sizes_layout(parameters.changed(gradient="signed"))


class _Column(NamedTuple):
    """Sums of A, B, C, v·B and v·C down one column, with v the row relative to the middle one."""

    a: Value
    b: Value
    c: Value
    vb: Value
    vc: Value


class NormalEquations(wiring.Component):
    """Sums of A, B, C, A·u + C·v and C·u + B·v over the 7x7 window of which a column is the last.

    Squares come from tables, as in the convolution: with a, b and d those of gx, gy and gx - gy, C
    = (a + b - d) / 2. Each is summed down the column, and so is v times it:

        clock 2   squares of rows -3 to 3
        clock 3   sums and differences of rows -k and k
        clock 4   sums of pairs of these
        clock 5   their sums S, and V = Σ v·square
        clock 6   of C: S and V of a + b - d, halved

    Along the row the sums follow the columns: what a new column adds is added, what the one seven
    columns before it added is subtracted. With S the sum of a column's A, the part of x that A
    makes shrinks by the whole window's S, as each column that stays is one place further to the
    left:

        Σ A          grows by S(new) - S(old)
        Σ (u·S + V)  grows by 3 S(new) + V(new) + 4 S(old) - V(old) - Σ A, the sum as it was

    and the y from C and B in the same way. That holds across ends of rows too, where windows are
    not complete and nothing is delivered; so the sums start from 0 at reset and never again.
    Columns before the first after reset count as 0.

    Members
    -------
    i
        Stream of ``Columns(signed_sizes(parameters), 7)``.
    o
        Stream of derivatives in :data:`FORMATS`, one for every column but the first six of a
        row.
    """

    latency = COLUMN_LATENCY + 4

    def __init__(self, parameters: Parameters) -> None:
        self._layout = layout(FORMATS, parameters.product_max)
        self._squares = GradientSquares(signed_sizes(parameters), STEP_SIZE)
        super().__init__(
            {
                "i": In(stream.Signature(Columns(signed_sizes(parameters), STEP_SIZE))),
                "o": Out(stream.Signature(self._layout)),
            }
        )

    @property
    def memory_bits(self) -> int:
        return self._squares.memory_bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, STEP_SIZE, step=step, eol=self.i.payload.eol)
        column = self._column(pipe, self._squares.look_up(m, pipe, self.i.payload.data))
        for name, value in self._along_row(m, pipe, column).items():
            m.d.comb += self.o.payload[name].eq(value)
        complete = pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)
        m.d.comb += self.o.valid.eq(complete)
        return m

    @staticmethod
    def _column(pipe: Pipeline, squares: dict[str, list[Value]]) -> _Column:
        a, va = _sum_and_moment(pipe, squares["a"], "a")
        b, vb = _sum_and_moment(pipe, squares["b"], "b")
        d, vd = _sum_and_moment(pipe, squares["d"], "d")
        return _Column(
            a=pipe.register(a, "a"),
            b=pipe.register(b, "b"),
            # both differences are even
            c=pipe.register((a + b - d)[1:].as_signed(), "c"),
            vb=pipe.register(vb, "vb"),
            vc=pipe.register((va + vb - vd)[1:].as_signed(), "vc"),
        )

    def _along_row(self, m: Module, pipe: Pipeline, column: _Column) -> dict[str, Value]:
        """The five sums over the window. The minus of xy is in the order of its differences."""
        width = {name: field.width for name, field in self._layout}
        beats = [pipe.delay(pipe.valid, COLUMN_LATENCY, "beat", reset=True)]
        for k in range(3):
            beats.append(pipe.register(beats[-1], f"beat_{k}_later", reset=True))

        new = {
            "a": pipe.register(column.a, "new_a"),
            "b": pipe.register(column.b, "new_b"),
            "c": pipe.register(column.c, "new_c"),
        }
        enter_x = pipe.register(column.a + (column.a << 1) + column.vc, "enter_x")
        enter_y = pipe.register(column.c + (column.c << 1) + column.vb, "enter_y")
        leave = {
            **new,
            "x": pipe.register((column.a << 2) - column.vc, "leave_x"),
            "y": pipe.register((column.c << 2) - column.vb, "leave_y"),
        }
        old = self._seven_columns_ago(m, pipe, beats[1], leave)
        change_x = pipe.register(enter_x + old["x"], "change_x")
        change_y = pipe.register(enter_y + old["y"], "change_y")
        changes = {
            "xx": pipe.register(new["a"] - old["a"], "change_xx"),
            "yy": pipe.register(new["b"] - old["b"], "change_yy"),
            "xy": pipe.register(old["c"] - new["c"], "change_xy"),
        }
        sums = {
            name: _running_sum(m, pipe, change, width[name], beats[2], name)
            for name, change in changes.items()
        }
        # the sums as they were before this column
        moments = {
            "x": pipe.register((change_x - sums["xx"])[: width["x"]].as_signed(), "moment_x"),
            "y": pipe.register((change_y + sums["xy"])[: width["y"]].as_signed(), "moment_y"),
        }
        return {
            **{name: pipe.register(value, f"{name}_now") for name, value in sums.items()},
            **{
                name: _running_sum(m, pipe, change, width[name], beats[3], name)
                for name, change in moments.items()
            },
        }

    @staticmethod
    def _seven_columns_ago(
        m: Module, pipe: Pipeline, beat: Value, values: dict[str, Signal]
    ) -> dict[str, Value]:
        """What ``values`` were seven beats before, or 0 before the first of them since reset."""
        together = Cat(*values.values())
        old = outgoing_column(m, pipe, together, STEP_SIZE, beat=beat, step=pipe.advance & beat, name="old")
        parts, at = {}, 0
        for name, value in values.items():
            part = old[at : at + len(value)]
            parts[name] = part.as_signed() if value.shape().signed else part
            at += len(value)
        return parts


def _sum_and_moment(pipe: Pipeline, squares: list[Value], name: str) -> tuple[Value, Value]:
    """Σ square and Σ v·square of rows v = -3 to 3, three clocks later."""
    middle = pipe.register(squares[REACH], f"{name}_middle")
    sums, differences = [], []
    for k in range(1, REACH + 1):
        above, below = squares[REACH - k], squares[REACH + k]
        sums.append(pipe.register(above + below, f"{name}_sum_{k}"))
        differences.append(pipe.register(below - above, f"{name}_difference_{k}"))
    near = pipe.register(middle + sums[0], f"{name}_near")
    far = pipe.register(sums[1] + sums[2], f"{name}_far")
    # d1 + 2·d2 + 3·d3 = (d1 + d3) + 2·(d2 + d3)
    odd = pipe.register(differences[0] + differences[2], f"{name}_odd")
    even = pipe.register(differences[1] + differences[2], f"{name}_even")
    return pipe.register(near + far, f"{name}_sum"), pipe.register(odd + (even << 1), f"{name}_moment")


def _running_sum(m: Module, pipe: Pipeline, change: Value, width: int, beat: Value, name: str) -> Signal:
    """The sum of all changes since reset, one clock after each."""
    total = Signal(signed(width), name=f"total_{name}")
    with m.If(pipe.advance & beat):
        m.d.sync += total.eq(total + change)
    return total
