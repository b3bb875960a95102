"""Square root: Li and Chu's non-restoring algorithm as a pipeline, one addition or subtraction per result bit."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Mux, ShapeLike, Signal, Value
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.stream import Pipeline


class SquareRoot(wiring.Component):
    """Floor square root of an unsigned number of ``2·root_bits`` bits.

    Each step takes the radicand's next two bits d and forms, with the remainder r and the root q so far,

        r >= 0:  r' = (4r + d) - (4q + 1)        q' = 2q + (r' >= 0)
        r <  0:  r' = (4r + d) + (4q + 3)

    so a step is one adder-subtractor and no multiplexer, and the remainder of n result bits needs n+2 bits.

    Parameters
    ----------
    root_bits
        Width of the result.
    bits_per_stage
        Result bits between two registers: more saves registers and latency, and lengthens the path.
    aside
        Shape of a value that travels along unchanged.

    Members
    -------
    i
        Stream of ``{"radicand", "aside"}``.
    o
        Stream of ``{"root", "aside"}``.
    """

    def __init__(self, root_bits: int, bits_per_stage: int = 1, aside: ShapeLike = 1) -> None:
        self._root_bits = root_bits
        self._bits_per_stage = bits_per_stage
        super().__init__(
            {
                "i": In(stream.Signature(data.StructLayout({"radicand": 2 * root_bits, "aside": aside}))),
                "o": Out(stream.Signature(data.StructLayout({"root": root_bits, "aside": aside}))),
            }
        )

    @property
    def latency(self) -> int:
        return -(-self._root_bits // self._bits_per_stage)

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        radicand: Value = Value.cast(self.i.payload.radicand)
        root: Value = C(0, 0)
        remainder: Value = C(0, 1)
        for stage in range(self.latency):
            for _ in range(min(self._bits_per_stage, self._root_bits - len(root))):
                difference = _step(root, remainder, radicand[-2:])
                # a signal of its own, or each of the next step's uses would repeat this step's logic
                remainder = Signal(len(difference), name=f"step_{len(root)}")
                m.d.comb += remainder.eq(difference)
                root, radicand = Cat(~remainder[-1], root), radicand[:-2]
            root = pipe.register(root, f"root_{stage}")
            remainder = pipe.register(remainder, f"remainder_{stage}")
            radicand = pipe.register(radicand, f"radicand_{stage}")
        m.d.comb += [
            self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True)),
            self.o.payload.root.eq(root),
            self.o.payload.aside.eq(pipe.delay(self.i.payload.aside, self.latency, "aside")),
        ]
        return m


def _step(root: Value, remainder: Value, digit: Value) -> Value:
    """The next remainder, in two's complement like the one before; the next result bit is its sign, inverted."""
    negative = remainder[-1]
    shifted = Cat(digit, remainder)
    # 4q + 1 or 4q + 3, told apart by bit 1; subtracting is adding the complement and one
    operand = Cat(C(1, 1), negative, root)
    bits = len(root) + 3
    padded = Cat(shifted, *[shifted[-1]] * 2)[:bits]
    return (padded + (Cat(operand, C(0, 1)) ^ Mux(negative, 0, (1 << bits) - 1)) + ~negative)[:bits]
