# amaranth: UnusedElaboratable=no
"""Squares of a column's gradients and of their differences; products need them."""

from __future__ import annotations

from amaranth.hdl import C, Module, Shape, Value

from hdl.parts.arithmetic import add_with_carry
from hdl.parts.squarer import LATENCY, Squarer, make_squarer
from hdl.parts.stream import Pipeline


def gradient_difference(gx: Value, gy: Value, *, signed: bool) -> Value:
    """gx - gy (signed), or a number of the size of | |gx| - |gy| |."""
    # that is |gx - gy| where the signs are equal, |gx + gy| where not
    subtract = C(1, 1) if signed else ~(gx[-1] ^ gy[-1])
    second = (gy.as_unsigned() ^ subtract.replicate(len(gy))).as_signed()
    return add_with_carry(gx, second, subtract)[: len(gx) + signed].as_signed()


class GradientSquares:
    """Squares of a number of rows of sizes, from tables or by multipliers.

    The two gradients of a row share one table; so do the differences of two rows. Where the number
    of rows is odd, one port stays free.

    With a, b and d the squares of gx, gy and their difference, gx·gy = (a + b - d) / 2.

    Parameters
    ----------
    gradient, difference
        Shapes of the numbers.
    rows
        Number of rows, in each lane.
    lanes
        Columns of a beat.
    multiplied
        The first so many pairs of squares are found by multipliers; of :meth:`pairs`.
    """

    latency = LATENCY

    def __init__(
        self, gradient: Shape, difference: Shape, rows: int, lanes: int = 1, multiplied: int = 0
    ) -> None:
        alone = rows * lanes
        shapes = [gradient] * alone + [difference] * (self.pairs(rows, lanes) - alone)

        def squarer(number: int, shape: Shape) -> Squarer:
            return make_squarer(
                shape.width,
                signed_numbers=shape.signed,
                stores_odd=lanes > 1,
                multiplies=number < multiplied,
            )

        found = [squarer(number, shape) for number, shape in enumerate(shapes)]
        self._gradients, self._differences = found[:alone], found[alone:]

    @staticmethod
    def pairs(rows: int, lanes: int) -> int:
        """Pairs of squares: a table, or two multipliers, for each."""
        return rows * lanes + -(-rows * lanes // 2)

    @property
    def memory_bits(self) -> int:
        return sum(table.memory_bits for table in (*self._gradients, *self._differences))

    def look_up(
        self, m: Module, pipe: Pipeline, gx: list[Value], gy: list[Value], differences: list[Value]
    ) -> dict[str, list[Value]]:
        """a, b and d by channel and row, from the top, ``latency`` clocks later.

        Parameters
        ----------
        m, pipe
            Module and pipeline of the block that this is a part of. The tables are added to it.
        gx, gy, differences
            The numbers of each row. Two differences that share a table come in the same clock, and
            so do both gradients.
        """
        for k, table in enumerate((*self._gradients, *self._differences)):
            m.submodules[f"table_{k}"] = table
            m.d.comb += table.enable.eq(pipe.advance)
        squares: dict[str, list[Value]] = {"a": [], "b": [], "d": []}
        for row, gradients in enumerate(self._gradients):
            for channel, numbers, table, port in (
                ("a", gx, gradients, 0),
                ("b", gy, gradients, 1),
                ("d", differences, self._differences[row // 2], row % 2),
            ):
                m.d.comb += table.x[port].eq(numbers[row])
                squares[channel].append(Value.cast(table.square[port]))
        return squares
