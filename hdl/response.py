# amaranth: UnusedElaboratable=no
# the parts are made at once, because the latency is theirs, and elaborated perhaps never
"""Corner response (Eq. 2): D = (A + B) - sqrt((A - B)² + (2C)²)."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Mux, Shape, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.parameters import Parameters
from hdl.arithmetic import square, tree_latency
from hdl.preprocessing import products_layout
from hdl.square_root import SquareRoot
from hdl.stream import Beat, Pipeline


class _Radicand(wiring.Component):
    """A + B, and (A - B)² + (2C)². A tensor smoothed from real pixels keeps the latter within 2·response_bits."""

    def __init__(self, parameters: Parameters, out: data.StructLayout) -> None:
        self._bits = parameters.product_bits
        super().__init__(
            {
                "i": In(stream.Signature(Beat(products_layout(parameters)))),
                "o": Out(stream.Signature(out)),
            }
        )

    @property
    def latency(self) -> int:
        return 3 + tree_latency(self._bits)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        a, b, c = self.i.payload.data.a, self.i.payload.data.b, self.i.payload.data.c
        total = pipe.register(a + b, "total")
        difference = pipe.register(a - b, "difference")
        cross = pipe.register(c, "cross")
        distance = pipe.register(abs(difference)[: self._bits], "distance")
        cross_size = pipe.register(
            (abs(cross) if Shape.cast(c.shape()).signed else cross)[: self._bits], "cross_size"
        )
        squares = square(pipe, distance, "distance_square"), square(pipe, cross_size, "cross_square")
        tags = Cat(self.i.payload.eol, self.i.payload.eof)
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True)),
            self.o.payload.radicand.eq(pipe.register(squares[0] + (squares[1] << 2), "radicand")),
            self.o.payload.aside.eq(
                Cat(pipe.delay(total, self.latency - 1, "total"), pipe.delay(tags, self.latency, "tags"))
            ),
        ]
        return m


class _Difference(wiring.Component):
    """D = (A + B) - root, clamped at 0."""

    latency = 2

    def __init__(self, parameters: Parameters, into: data.StructLayout) -> None:
        super().__init__(
            {
                "i": In(stream.Signature(into)),
                "o": Out(stream.Signature(Beat(unsigned(parameters.response_bits)))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        aside = self.i.payload.aside
        difference = pipe.register(aside.total - self.i.payload.root, "difference")
        clamped = pipe.register(Mux(difference[-1], 0, difference[:-1]), "clamped")
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, 2, "valid", reset=True)),
            self.o.payload.data.eq(clamped),
            self.o.payload.eol.eq(pipe.delay(aside.eol, 2, "eol")),
            self.o.payload.eof.eq(pipe.delay(aside.eof, 2, "eof")),
        ]
        return m


class Response(wiring.Component):
    """Corner response of every smoothed tensor.

    Members
    -------
    i
        Stream of ``Beat(products_layout(parameters))``, smoothed.
    o
        Stream of ``Beat(unsigned(response_bits))``.
    """

    def __init__(self, parameters: Parameters) -> None:
        bits = parameters.response_bits
        aside = data.StructLayout({"total": bits, "eol": 1, "eof": 1})
        self._root = SquareRoot(bits, parameters.sqrt_bits_per_stage, aside)
        self._radicand = _Radicand(parameters, self._root.i.payload.shape())
        self._difference = _Difference(parameters, self._root.o.payload.shape())
        super().__init__(
            {
                "i": In(stream.Signature(Beat(products_layout(parameters)))),
                "o": Out(stream.Signature(Beat(unsigned(bits)))),
            }
        )

    @property
    def latency(self) -> int:
        return self._radicand.latency + self._root.latency + self._difference.latency

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.radicand = radicand = self._radicand
        m.submodules.square_root = root = self._root
        m.submodules.difference = difference = self._difference
        wiring.connect(m, wiring.flipped(self.i), radicand.i)
        wiring.connect(m, radicand.o, root.i)
        wiring.connect(m, root.o, difference.i)
        wiring.connect(m, difference.o, wiring.flipped(self.o))
        return m
