"""LUT divider (Sec. 4.4): quotients up to one half out of a table of reciprocals and a small product."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Const, Module, Mux, ShapeLike, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.divider import (
    HALF,
    INDEX_BITS,
    NUMERATOR_BITS,
    PRODUCT_SHIFT,
    RECIPROCAL_BITS,
    RECIPROCALS,
)
from golden.parameters import OFFSET_BITS
from hdl.arithmetic import multiply, tree_latency
from hdl.stream import Pipeline


class Divider(wiring.Component):
    """numerator / denominator in units of 1/128, at most one half; error bound: ``golden.divider.worst_error()``.

    Numerator and denominator are shifted up together until the denominator's leading one is at the top; its next
    8 bits look up the reciprocal. As the shift goes on by halving distances, fewer and fewer low bits can still
    reach the top, and the others are dropped.

    Parameters
    ----------
    bits
        Width of numerator and denominator, unsigned, at least NUMERATOR_BITS + 1; the denominator must not be 0.
    aside
        Shape of a value that travels along unchanged.

    Members
    -------
    i
        Stream of ``{"numerator", "denominator", "aside"}``.
    o
        Stream of ``{"quotient": 0 to 64, "clamped", "aside"}``; clamped: the true quotient is above one half.
    """

    def __init__(self, bits: int, aside: ShapeLike = 1) -> None:
        if bits <= NUMERATOR_BITS:
            # what is cut from the top would lie too low
            raise ValueError(f"bits is {bits}; allowed: whole numbers from {NUMERATOR_BITS + 1}")
        self._bits = bits
        super().__init__(
            {
                "i": In(
                    stream.Signature(
                        data.StructLayout({"numerator": bits, "denominator": bits, "aside": aside})
                    )
                ),
                "o": Out(
                    stream.Signature(
                        data.StructLayout({"quotient": OFFSET_BITS, "clamped": 1, "aside": aside})
                    )
                ),
            }
        )

    @property
    def _distances(self) -> list[int]:
        return [1 << k for k in reversed(range((self._bits - 1).bit_length()))]

    @property
    def latency(self) -> int:
        # compare and shift, table, product, round
        return len(self._distances) + 1 + tree_latency(NUMERATOR_BITS) + 1

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        numerator, denominator = Value.cast(self.i.payload.numerator), Value.cast(self.i.payload.denominator)
        clamped = pipe.register((numerator << 1) > denominator, "clamped")

        keep_numerator, keep_denominator = NUMERATOR_BITS + 1, INDEX_BITS + 1
        reach = sum(self._distances)
        for distance in self._distances:
            reach -= distance
            empty = denominator[-distance:] == 0
            denominator, numerator = (
                pipe.register(
                    _top(Mux(empty, value << distance, value)[: len(value)], keep + reach),
                    f"{name}_{distance}",
                )
                for value, keep, name in (
                    (denominator, keep_denominator, "denominator"),
                    (numerator, keep_numerator, "numerator"),
                )
            )

        m.submodules.reciprocals = table = Memory(
            shape=RECIPROCAL_BITS - 1,
            depth=1 << INDEX_BITS,
            init=[int(entry) - (1 << (RECIPROCAL_BITS - 1)) for entry in RECIPROCALS],
        )
        port = table.read_port()
        m.d.comb += [port.addr.eq(denominator[-1 - INDEX_BITS : -1]), port.en.eq(pipe.advance)]
        # an unclamped numerator is at most half the denominator: its top bit is clear
        cut = pipe.register(numerator[:NUMERATOR_BITS], "cut")
        product = multiply(pipe, Cat(port.data, Const(1, 1)), cut, "product")

        clamped = pipe.delay(clamped, self.latency - 2, "clamped")
        rounded = (product + (1 << (PRODUCT_SHIFT - 1))) >> PRODUCT_SHIFT
        quotient = pipe.register(Mux(clamped, HALF, rounded)[:OFFSET_BITS], "quotient")
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True)),
            self.o.payload.quotient.eq(quotient),
            self.o.payload.clamped.eq(pipe.register(clamped, "clamped_out")),
            self.o.payload.aside.eq(pipe.delay(self.i.payload.aside, self.latency, "aside")),
        ]
        return m


def _top(value: Value, keep: int) -> Value:
    """The ``keep`` highest bits, or all of them if there are fewer."""
    return value[max(0, len(value) - keep) :]
