# amaranth: UnusedElaboratable=no
"""Products with small weights by look-up: every weight, with numbers of several widths."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, signed, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from hdl.parts.stream import Pipeline
from hdl.parts.weight_table import ONE, WEIGHT_BITS, Weighting, WeightTable
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, check_block

SHAPES = [signed(17), unsigned(6), signed(4), unsigned(23), unsigned(13), signed(7)]


class Products(wiring.Component):
    """Tables of numbers of all these shapes inside a pipeline."""

    def __init__(self) -> None:
        self._weighting = Weighting(SHAPES, "weight")
        self.latency = self._weighting.latency
        numbers = {f"x{k}": shape for k, shape in enumerate(SHAPES)}
        products = {
            f"x{k}": type(shape)(shape.width + WEIGHT_BITS, shape.signed) for k, shape in enumerate(SHAPES)
        }
        super().__init__(
            {
                "i": In(stream.Signature(data.StructLayout({"weight": WEIGHT_BITS, **numbers}))),
                "o": Out(stream.Signature(data.StructLayout(products))),
            }
        )

    @property
    def memory_bits(self) -> int:
        return self._weighting.memory_bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        pipe = Pipeline(m, self.i, self.o)
        numbers = [self.i.payload[f"x{k}"] for k in range(len(SHAPES))]
        products = self._weighting.look_up(m, pipe, numbers, self.i.payload.weight)
        m.d.comb += [self.o.payload[f"x{k}"].eq(product) for k, product in enumerate(products)]
        m.d.comb += self.o.valid.eq(pipe.delay(pipe.valid, self.latency, "valid", reset=True))
        return m


@cache
def numbers() -> tuple[NDArray[np.int64], ...]:
    """Both ends, and others, each with every weight."""
    columns = []
    for k, shape in enumerate(SHAPES):
        low = -(1 << (shape.width - 1)) if shape.signed else 0
        high = low + (1 << shape.width) - 1
        some = np.random.default_rng(k).integers(low, high, 60, endpoint=True)
        columns.append(np.concatenate([[low, high, 0, 1, high - 1], some]))
    return tuple(np.repeat(column, ONE) for column in columns)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_products(name: EngineName, stalls: Stalls) -> None:
    given = {f"x{k}": column for k, column in enumerate(numbers())}
    weight = np.resize(np.arange(ONE), len(given["x0"]))
    expected = {field: column * np.where(weight == 0, ONE, weight) for field, column in given.items()}
    check_block((Products,), {"i": {"weight": weight, **given}}, {"o": expected}, name, stalls)


def test_latency_and_size() -> None:
    """Slices are added up in a clock; 11 of them and 3 signed ones fill 6 and 2 tables."""
    assert Products().latency == WeightTable.latency + 1 == 3
    assert Products().memory_bits == 8 * 1024 * 9


def test_no_stall_is_needed_to_see_a_product() -> None:
    check_block(
        (Products,),
        {"i": {"weight": np.array([3]), **{f"x{k}": np.array([5]) for k in range(len(SHAPES))}}},
        {"o": {f"x{k}": np.array([15]) for k in range(len(SHAPES))}},
        "amaranth",
        NO_STALLS,
    )
