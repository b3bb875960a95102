# amaranth: UnusedElaboratable=no
"""Products become embedded multipliers, with the registers at their ports where they may."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal, signed, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from flow.cyclone4.area import Area
from flow.cyclone4.synthesis import map_component
from flow.rules import rule_text
from hdl.parts.squarer import LATENCY
from sim import Stalls, Stimulus, make_engine
from tests.hdl.parts.test_square_table import Squares
from tests.support.blocks import packed, run

FLIP_FLOPS = 2
"""Of the pipeline around the squares: one for each clock in which a number is valid."""


class Product(wiring.Component):
    """A product of two registers, and a register behind; ``kind`` is the special case."""

    def __init__(self, kind: str, bits: int, sign: bool) -> None:
        self._kind = kind
        number = signed(bits) if sign else unsigned(bits)
        self._number = number
        super().__init__(
            {"i": In(stream.Signature(unsigned(2 * bits))), "o": Out(stream.Signature(unsigned(3 * bits)))}
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bits = self._number.width
        a, b = Signal(self._number, reset_less=self._kind != "reset"), Signal(self._number, reset_less=True)
        product, valid = Signal(2 * bits, reset_less=True), Signal()
        m.d.comb += self.i.ready.eq(self.o.ready)
        with m.If(self.o.ready):
            m.d.sync += [
                *(a.eq(self.i.payload[:bits]), b.eq(self.i.payload[bits:]), product.eq(a * b)),
                *(valid.eq(self.i.valid), self.o.valid.eq(valid)),
            ]
        if self._kind == "enables":
            with m.If(self.i.valid):
                m.d.sync += a.eq(self.i.payload[:bits])
        if self._kind == "reset":
            with m.If(self.i.valid & self.o.ready & (self.i.payload == 0)):
                m.d.sync += a.eq(0)
        # what a multiplier's own register cannot give to others
        other = {"factor read": a, "product read": (a * b)[:bits]}.get(self._kind, product[:bits])
        m.d.comb += self.o.payload.eq(product | (other << 2 * bits))
        return m


def mapped(part: wiring.Component) -> tuple[Area, str]:
    tree, verilog = map_component(part, "top")
    return tree.area, verilog


@pytest.mark.parametrize(
    ("bits", "sign", "elements"), [(8, False, 1), (9, False, 1), (9, True, 1), (10, False, 2), (10, True, 2)]
)
def test_squares_take_no_logic(bits: int, sign: bool, elements: int, tmp_path: Path) -> None:
    area, verilog = mapped(Squares(bits, sign, "multipliers"))
    assert (area.ff, area.m9k, area.memory_bits) == (FLIP_FLOPS, 0, 0)
    assert area.multipliers == 2 * elements
    low = 1 - (1 << (bits - 1)) if sign else 0
    numbers = np.random.default_rng(bits).integers(low, 1 << (bits - sign), (2000, 2))
    path = tmp_path / "gates.v"
    path.write_text(rule_text("cyclone4", "cells.v") + verilog)
    block = (Squares, bits, sign, "multipliers")
    engine = make_engine("verilog", Squares(bits, sign, "multipliers"), verilog=path)
    given, expected = packed(block, {"i": numbers}), packed(block, {"o": numbers**2})
    run(engine, given, expected, Stalls(inputs=0.3, outputs=0.4, seed=3), clocks=LATENCY)


@pytest.mark.parametrize("sign", [False, True])
@pytest.mark.parametrize(
    ("kind", "factors", "results"),
    [
        ("", 0, 0),
        ("factor read", 2, 0),
        ("reset", 2, 0),
        ("enables", 2, 0),
        ("product read", 0, 1),
    ],
)
def test_registers_stay_where_they_do_something_else(
    kind: str, factors: int, results: int, sign: bool, tmp_path: Path
) -> None:
    """All of an end's registers move, or none."""
    bits = 9
    area, verilog = mapped(Product(kind, bits, sign))
    assert area.multipliers == 1
    assert area.ff == FLIP_FLOPS + factors * bits + results * 2 * bits
    path = tmp_path / "gates.v"
    path.write_text(rule_text("cyclone4", "cells.v") + verilog)
    rng = np.random.default_rng(1)
    stimulus = Stimulus({"i": rng.integers(0, 1 << 2 * bits, 1000, np.uint64)}, [], Stalls(0.3, 0.4, seed=3))
    outputs = [
        make_engine(name, Product(kind, bits, sign), **source).run(stimulus, max_clocks=20_000).outputs["o"]
        for name, source in (("amaranth", {}), ("verilog", {"verilog": path}))
    ]
    assert len(outputs[0]) == 1000 and np.array_equal(*outputs)


def test_longer_products_are_logic() -> None:
    area, verilog = mapped(Product("", 19, False))
    assert "cycloneiv_mac_mult" not in verilog and area.lut4 > 300
