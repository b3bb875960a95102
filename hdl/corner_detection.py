"""Corner detection (Eqs. 3-5, Fig. 11): non-maximum suppression in 3x3 and threshold."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Value, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import WINDOW_SIZE, Parameters
from hdl.stream import Beat, Columns, Pipeline, WindowCounter


def patch_layout(parameters: Parameters) -> data.ArrayLayout:
    """The 3x3 responses around a candidate: ``[row][column]``."""
    return data.ArrayLayout(data.ArrayLayout(unsigned(parameters.response_bits), 3), 3)


class CornerDetection(wiring.Component):
    """E: is the centre of the 9x9 window the largest of its 3x3 neighbourhood, and above T1?

    Takes the window's three middle rows, delivers one beat per complete 9x9 window, rows eight positions shorter.
    The centre lies four columns behind the newest, so the comparisons are spread over those four columns on
    their way and cost no latency.

    Members
    -------
    i
        Stream of ``Columns(unsigned(response_bits), 3)``.
    t1
        Stream of T1, one per frame, taken with the frame's last column.
    o
        Stream of ``Beat({"corner": 1, "patch": patch_layout})``.
    """

    latency = 1

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        response = unsigned(parameters.response_bits)
        result = data.StructLayout({"corner": 1, "patch": patch_layout(parameters)})
        super().__init__(
            {
                "i": In(stream.Signature(Columns(response, 3))),
                "t1": In(stream.Signature(response)),
                "o": Out(stream.Signature(Beat(result))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o, permit=self.t1.valid)
        bits = self._parameters.response_bits
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, WINDOW_SIZE, step=step, eol=self.i.payload.eol)
        m.d.comb += self.t1.ready.eq(step & self.i.payload.eof)

        # columns[0] is the newest; every register here moves from column to column
        columns = [Cat(*(self.i.payload.data[row] for row in range(3)))]
        for age in range(WINDOW_SIZE // 2 + 2):
            columns.append(pipe.register(columns[-1], f"column_{age}", when=pipe.valid))

        def sample(column: int, row: int) -> Value:
            return columns[column][row * bits : (row + 1) * bits]

        def largest(a: Value, b: Value) -> Value:
            return Mux(a > b, a, b)

        def register(value: Value, name: str) -> Value:
            return pipe.register(value, name, when=pipe.valid)

        # the window is columns 3, 2, 1 from left to right when the first comparisons are made, and then moves on;
        # earlier and later are meant in raster order
        left, here, right = 3, 2, 1
        earlier_a = register(largest(sample(left, 0), sample(here, 0)), "earlier_a")
        earlier_b = register(largest(sample(right, 0), sample(left, 1)), "earlier_b")
        later_a = register(largest(sample(right, 1), sample(left, 2)), "later_a")
        later_b = register(largest(sample(here, 2), sample(right, 2)), "later_b")
        above = register(sample(here, 1) > self.t1.payload, "above")

        earlier = register(largest(earlier_a, earlier_b), "earlier")
        later = register(largest(later_a, later_b), "later")
        above = register(above, "above_2")

        centre = sample(here + 2, 1)
        beats_later = centre > later if self._parameters.ties == "strict" else centre >= later
        corner = register(above & (centre > earlier) & beats_later, "corner")

        # by then the centre has moved on to column 5
        patch = [[sample(column, row) for column in (6, 5, 4)] for row in range(3)]
        m.d.comb += [
            self.o.valid.eq(pipe.register(pipe.valid & window.complete, "valid", reset=True)),
            self.o.payload.data.corner.eq(corner),
            self.o.payload.data.patch.eq(Cat(*(Cat(*row) for row in patch))),
            self.o.payload.eol.eq(pipe.register(self.i.payload.eol, "eol")),
            self.o.payload.eof.eq(pipe.register(self.i.payload.eof, "eof")),
        ]
        return m
