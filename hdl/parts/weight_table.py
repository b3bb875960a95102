# amaranth: UnusedElaboratable=no
"""Products with small weights by look-up: tables in block RAM take the place of multipliers."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Cat, Module, Shape, Signal, Value, signed, unsigned
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.parts.stream import Pipeline

WEIGHT_BITS = 4
ONE = 1 << WEIGHT_BITS
"""The weight of which 0 is the code: weights are 1 to 16."""
SLICE_BITS = 6
PRODUCT_BITS = WEIGHT_BITS + SLICE_BITS
"""A product fits: 16·63, and 16·-32. Its lowest bit, that of both, is not stored."""


class WeightTable(wiring.Component):
    """Two products per clock of one weight and a slice each, by the two ports of one table.

    Latency 2: the memory's own register and one behind it.

    Parameters
    ----------
    signed_slices
        They are in two's complement.

    Members
    -------
    enable
        The registers move: ``advance`` of the pipeline around.
    weight
        From 1 to 15; 0 is 16.
    x
        The two slices.
    product
        Two enabled clocks later.
    """

    latency = 2
    memory_bits = (PRODUCT_BITS - 1) << PRODUCT_BITS

    def __init__(self, *, signed_slices: bool = False) -> None:
        self._signed = signed_slices
        make = signed if signed_slices else unsigned
        self._product = make(PRODUCT_BITS)
        super().__init__(
            {
                "enable": In(1),
                "weight": In(WEIGHT_BITS),
                "x": In(data.ArrayLayout(make(SLICE_BITS), 2)),
                "product": Out(data.ArrayLayout(make(PRODUCT_BITS), 2)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        size = 1 << SLICE_BITS
        slices = [*range(size // 2), *range(-size // 2, 0)] if self._signed else list(range(size))
        stored = (1 << (PRODUCT_BITS - 1)) - 1
        m.submodules.table = table = Memory(
            shape=PRODUCT_BITS - 1,
            depth=1 << PRODUCT_BITS,
            init=[((weight or ONE) * x >> 1) & stored for weight in range(ONE) for x in slices],
            attrs={"ram_style": "block"},
        )
        for k in range(2):
            port = table.read_port()
            m.d.comb += [port.addr.eq(Cat(self.x[k], self.weight)), port.en.eq(self.enable)]
            high = Signal(len(port.data), name=f"high_{k}", reset_less=True)
            odd = Signal(name=f"odd_{k}", reset_less=True)
            odd_before = Signal.like(odd, name=f"odd_before_{k}")
            both_odd = Value.cast(self.x[k])[0] & self.weight[0]
            with m.If(self.enable):
                m.d.sync += [high.eq(port.data), odd_before.eq(both_odd), odd.eq(odd_before)]
            m.d.comb += Value.cast(self.product[k]).eq(Cat(odd, high))
        return m


class Weighting:
    """Tables for the products of a weight and several numbers, slice by slice.

    Two slices share a table. The products of a number's slices are added up in one clock.

    Parameters
    ----------
    shapes
        Of the numbers.
    name
        Of the tables.
    """

    latency = WeightTable.latency + 1
    """Clocks from the numbers to their products."""

    def __init__(self, shapes: list[Shape], name: str) -> None:
        self._shapes = shapes
        self._name = name
        signed_tops = sum(shape.signed for shape in shapes)
        unsigned_slices = sum(map(_slices, shapes)) - signed_tops
        self._tables = {
            False: [WeightTable() for _ in range(0, unsigned_slices, 2)],
            True: [WeightTable(signed_slices=True) for _ in range(0, signed_tops, 2)],
        }

    @property
    def memory_bits(self) -> int:
        return sum(table.memory_bits for tables in self._tables.values() for table in tables)

    def look_up(self, m: Module, pipe: Pipeline, numbers: list[Value], weight: Value) -> list[Value]:
        """The products. The tables are added to the block that this is a part of.

        ``weight`` is that of WeightTable, and comes with the numbers.
        """
        for signed_slices, tables in self._tables.items():
            for k, table in enumerate(tables):
                m.submodules[f"{self._name}_{'signed_' if signed_slices else ''}{k}"] = table
                m.d.comb += [table.enable.eq(pipe.advance), table.weight.eq(weight)]
        ports = {
            kind: iter([(t, k) for t in tables for k in range(2)]) for kind, tables in self._tables.items()
        }
        results = []
        for n, (number, shape) in enumerate(zip(numbers, self._shapes, strict=True)):
            parts = []
            for low in range(0, shape.width, SLICE_BITS):
                is_signed = shape.signed and low + SLICE_BITS >= shape.width
                table, k = next(ports[is_signed])
                piece = number[low : low + SLICE_BITS]
                m.d.comb += table.x[k].eq(piece.as_signed() if is_signed else piece)
                parts.append(table.product[k])
            results.append(pipe.register(_added_up(parts), f"{self._name}_{n}"))
        return results


def _slices(shape: Shape) -> int:
    return -(-shape.width // SLICE_BITS)


def _added_up(parts: list[Value]) -> Value:
    """Sum of part k times 2**(k·SLICE_BITS), in a tree."""
    step = SLICE_BITS
    while len(parts) > 1:
        pairs = [parts[k : k + 2] for k in range(0, len(parts), 2)]
        parts = [pair[0] + (pair[1] << step) if len(pair) == 2 else pair[0] for pair in pairs]
        step *= 2
    return parts[0]
