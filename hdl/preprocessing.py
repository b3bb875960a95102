"""Preprocessing (Sec. 3.1): gradients out of a 3x3 window of pixels, and their products."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Mux, Value, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.arithmetic import multiply, square, tree_latency
from hdl.stream import Beat, Columns, Pipeline, WindowCounter


def products_layout(parameters: Parameters) -> data.StructLayout:
    """A, B and C, before and after smoothing; C has a sign only where gradients have one."""
    bits = parameters.product_bits
    c = signed(bits + 1) if parameters.gradient == "signed" else unsigned(bits)
    return data.StructLayout({"a": unsigned(bits), "b": unsigned(bits), "c": c})


class Preprocessing(wiring.Component):
    """A = gx², B = gy², C = gx·gy of every pixel with four neighbours.

    Takes columns of three rows of pixels, delivers rows two positions shorter.

    Members
    -------
    i
        Stream of ``Columns(unsigned(pixel_bits), 3)``.
    o
        Stream of ``Beat(products_layout(parameters))``.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        super().__init__(
            {
                "i": In(stream.Signature(Columns(unsigned(parameters.pixel_bits), 3))),
                "o": Out(stream.Signature(Beat(products_layout(parameters)))),
            }
        )

    @property
    def latency(self) -> int:
        return 4 + tree_latency(self._parameters.pixel_bits)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        above, here, below = self.i.payload.data[0], self.i.payload.data[1], self.i.payload.data[2]
        step = pipe.valid & pipe.advance
        window = WindowCounter(m, 3, step=step, eol=self.i.payload.eol)

        # the window's centre is one column behind the newest
        right = pipe.register(here, "right", when=pipe.valid)
        centre = pipe.register(right, "centre", when=pipe.valid)
        left = pipe.register(centre, "left", when=pipe.valid)
        top = pipe.delay_beats(above, 2, "top", pipe.valid)
        bottom = pipe.delay_beats(below, 2, "bottom", pipe.valid)

        gx = pipe.register(left - right, "gx")
        gy = pipe.register(top - bottom, "gy")
        gx_size = pipe.register(_magnitude(gx), "gx_size")
        gy_size = pipe.register(_magnitude(gy), "gy_size")

        a = pipe.register(square(pipe, gx_size, "a"), "a_out")
        b = pipe.register(square(pipe, gy_size, "b"), "b_out")
        c = multiply(pipe, gx_size, gy_size, "c")
        if self._parameters.gradient == "signed":
            negative = pipe.delay(gx[-1] ^ gy[-1], 1 + tree_latency(len(gx_size)), "negative")
            c = Mux(negative, -c, c)
        c = pipe.register(c, "c_out")

        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid & window.complete, self.latency, "valid", reset=True)),
            self.o.payload.data.a.eq(a),
            self.o.payload.data.b.eq(b),
            self.o.payload.data.c.eq(c),
            self.o.payload.eol.eq(pipe.delay(self.i.payload.eol, self.latency, "eol")),
            self.o.payload.eof.eq(pipe.delay(self.i.payload.eof, self.latency, "eof")),
        ]
        return m


def _magnitude(value: Value) -> Value:
    return abs(value)[: len(value) - 1]
