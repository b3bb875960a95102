# amaranth: UnusedElaboratable=no
# the tables are made at once, because their memory is counted, and elaborated perhaps never
"""Preprocessing (Sec. 3.1): gradients out of columns of pixels, and the squares of which their products are made."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import SMOOTHING_SIZE, Parameters
from hdl.arithmetic import magnitude
from hdl.square_table import SquareTable
from hdl.stream import Columns, Pipeline, WindowCounter

PIXEL_ROWS = SMOOTHING_SIZE + 2
"""Rows of pixels that give SMOOTHING_SIZE rows of gradients."""


def products_layout(parameters: Parameters) -> data.StructLayout:
    """A, B and C after smoothing; C has a sign only where gradients have one."""
    bits = parameters.product_bits
    c = signed(bits + 1) if parameters.gradient == "signed" else unsigned(bits)
    return data.StructLayout({"a": unsigned(bits), "b": unsigned(bits), "c": c})


def squares_layout(parameters: Parameters) -> data.StructLayout:
    """a = gx², b = gy² and d = (gx - gy)², of absolute or signed gradients; so gx·gy = (a + b - d) / 2.

    The difference of signed gradients has one bit more than a gradient, its square two.
    """
    bits = parameters.product_bits
    d = bits + 2 if parameters.gradient == "signed" else bits
    return data.StructLayout({"a": unsigned(bits), "b": unsigned(bits), "d": unsigned(d)})


class Preprocessing(wiring.Component):
    """Squares of the gradients, and of their difference, of five pixels above each other.

    Takes columns of seven rows of pixels, delivers rows two positions shorter. The squares of a pixel are made
    anew for each of the five rows of the smoothing window that it passes: pixels wait in less memory than squares.

        clock 1   gx, gy
        clock 2   |gx|, |gy|, and |gx| - |gy| (absolute) or gx - gy (signed)
        clock 3   the sizes of all three go into the tables
        clock 4   the squares come out of them

    Members
    -------
    i
        Stream of ``Columns(unsigned(pixel_bits), 7)``.
    o
        Stream of ``Columns(squares_layout(parameters), 5)``.
    """

    latency = 2 + SquareTable.latency

    def __init__(self, parameters: Parameters) -> None:
        self._signed = parameters.gradient == "signed"
        bits = parameters.pixel_bits
        self._square_tables = [SquareTable(bits) for _ in range(SMOOTHING_SIZE)]
        # two differences share a table, so one of its ports stays free
        self._difference_tables = [
            SquareTable(bits + 1 if self._signed else bits) for _ in range(0, SMOOTHING_SIZE, 2)
        ]
        super().__init__(
            {
                "i": In(stream.Signature(Columns(unsigned(bits), PIXEL_ROWS))),
                "o": Out(stream.Signature(Columns(squares_layout(parameters), SMOOTHING_SIZE))),
            }
        )

    @property
    def memory_bits(self) -> int:
        return sum(table.memory_bits for table in self._tables)

    @property
    def _tables(self) -> list[SquareTable]:
        return [*self._square_tables, *self._difference_tables]

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, 3, step=step, eol=self.i.payload.eol)
        for row, (gx, gy) in enumerate(self._gradients(pipe)):
            gx_size = pipe.register(magnitude(gx), f"gx_size_{row}")
            gy_size = pipe.register(magnitude(gy), f"gy_size_{row}")
            difference = gx - gy if self._signed else magnitude(gx) - magnitude(gy)
            difference = pipe.register(difference, f"difference_{row}")
            self._look_up(m, row, gx_size, gy_size, magnitude(difference))
        for k, table in enumerate(self._tables):
            m.submodules[f"table_{k}"] = table
            m.d.comb += table.enable.eq(pipe.advance)
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m

    def _gradients(self, pipe: Pipeline) -> list[tuple[Signal, Signal]]:
        """gx and gy by row, with their signs. The window's centre is one column behind the newest."""
        newest = self.i.payload.data
        centre = [pipe.register(newest[row], f"centre_{row}", when=pipe.valid) for row in range(PIXEL_ROWS)]
        gradients = []
        for row in range(1, PIXEL_ROWS - 1):
            left = pipe.register(centre[row], f"left_{row}", when=pipe.valid)
            gx = pipe.register(left - newest[row], f"gx_{row - 1}")
            gy = pipe.register(centre[row - 1] - centre[row + 1], f"gy_{row - 1}")
            gradients.append((gx, gy))
        return gradients

    def _look_up(self, m: Module, row: int, gx_size: Value, gy_size: Value, difference: Value) -> None:
        """A table for both gradients of a row, and one for the differences of two rows."""
        squares = self.o.payload.data[row]
        both, shared, port = self._square_tables[row], self._difference_tables[row // 2], row % 2
        m.d.comb += [
            both.x[0].eq(gx_size),
            both.x[1].eq(gy_size),
            shared.x[port].eq(difference),
            squares.a.eq(both.square[0]),
            squares.b.eq(both.square[1]),
            squares.d.eq(shared.square[port]),
        ]
