# amaranth: UnusedElaboratable=no
"""Squares of a column's gradients and of their differences; products need them."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from amaranth.hdl import Module, Shape, Value
from amaranth.lib import data

from hdl.parts.squarer import LATENCY, Squarer, make_squarer
from hdl.parts.stream import Pipeline


class GradientSquares:
    """Squares of a number of rows of sizes, from tables or by multipliers.

    The two gradients of a row share one table; so do the differences of two rows. Where the number
    of rows is odd, one port stays free.

    With a, b and d the squares of gx, gy and their difference, gx·gy = (a + b - d) / 2.

    Parameters
    ----------
    sizes
        Layout of a row: see :func:`hdl.preprocessing.sizes_layout`.
    rows
        Number of rows, in each lane.
    lanes
        Columns of a beat.
    multiplied
        The first so many pairs of squares are found by multipliers; of :meth:`pairs`.
    """

    latency = LATENCY

    def __init__(self, sizes: data.StructLayout, rows: int, lanes: int = 1, multiplied: int = 0) -> None:
        alone = rows * lanes
        fields = ["gx"] * alone + ["difference"] * (self.pairs(rows, lanes) - alone)

        def squarer(number: int, field: str) -> Squarer:
            shape = Shape.cast(sizes[field].shape)
            return make_squarer(
                shape.width,
                signed_numbers=shape.signed,
                stores_odd=lanes > 1,
                multiplies=number < multiplied,
            )

        found = [squarer(number, field) for number, field in enumerate(fields)]
        self._gradients, self._differences = found[:alone], found[alone:]

    @staticmethod
    def pairs(rows: int, lanes: int) -> int:
        """Pairs of squares: a table, or two multipliers, for each."""
        return rows * lanes + -(-rows * lanes // 2)

    @property
    def memory_bits(self) -> int:
        return sum(table.memory_bits for table in (*self._gradients, *self._differences))

    def look_up(
        self, m: Module, pipe: Pipeline, column: Any, late: Collection[int] = ()
    ) -> dict[str, list[Value]]:
        """a, b and d by channel and row, from the top.

        Parameters
        ----------
        m, pipe
            Module and pipeline of the block that this is a part of. The tables are added to it.
        column
            A row's sizes by its number.
        late
            Rows that are looked up a clock later than the others.
        """
        for k, table in enumerate((*self._gradients, *self._differences)):
            m.submodules[f"table_{k}"] = table
            m.d.comb += table.enable.eq(pipe.advance)
        squares: dict[str, list[Value]] = {"a": [], "b": [], "d": []}
        for row, gradients in enumerate(self._gradients):
            sizes, differences = column[row], self._differences[row // 2]
            for channel, number, table, port in (
                ("a", sizes.gx, gradients, 0),
                ("b", sizes.gy, gradients, 1),
                ("d", sizes.difference, differences, row % 2),
            ):
                size = pipe.delay(number, int(row in late), f"{channel}_late_{row}")
                m.d.comb += table.x[port].eq(size)
                squares[channel].append(Value.cast(table.square[port]))
        return squares
