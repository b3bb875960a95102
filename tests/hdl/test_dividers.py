# amaranth: UnusedElaboratable=no
"""Both dividers as the refinement uses them: two quotients by one denominator, under stalls."""

from __future__ import annotations

import numpy as np
import pytest

from golden.algorithm import Divider
from hdl.dividers import make_divider
from hdl.serial_divider import SerialDivider
from hdl.table_divider import TableDivider
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import ENGINES, NO_STALLS, RUN_IDS, RUNS, check_block, unpack
from tests.support.dividing import (
    FORMATS,
    STEP,
    SURFACE,
    Dividing,
    Format,
    Int64,
    operands,
    quotients,
    result_layout,
)

every_divider = pytest.mark.parametrize(
    ("kind", "bits_per_clock"),
    # a serial divider is the same for both
    [("serial", 1), ("table", 1), ("table", 2)],
    ids=["serial", "table", "table-two-digits"],
)


def check(
    kind: Divider,
    form: Format,
    x: Int64,
    y: Int64,
    denominator: Int64,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    bits_per_clock: int = 1,
) -> Capture:
    given, expected = quotients(kind, form, x, y, denominator)
    clocks = make_divider(kind, *form, bits_per_clock).clocks + 1
    block = (Dividing, kind, *form, bits_per_clock)
    return check_block(block, given, expected, name, stalls, clocks=clocks)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@every_divider
def test_operands_of_every_length(
    kind: Divider, bits_per_clock: int, name: EngineName, stalls: Stalls
) -> None:
    x, y, denominator = operands(SURFACE, 3000 if name == "compiled" else 60)
    capture = check(kind, SURFACE, x, y, denominator, name, stalls, bits_per_clock)
    if name == "compiled":
        seen = unpack(result_layout(64), capture.outputs["o"])
        assert len(np.unique(seen["quotient"]["x"])) > 120
        assert 0 < seen["reached"].mean() < 1


@pytest.mark.parametrize("form", FORMATS.values(), ids=FORMATS)
@every_divider
def test_many_operands(kind: Divider, bits_per_clock: int, form: Format) -> None:
    check(kind, form, *operands(form, 100_000), bits_per_clock=bits_per_clock)


@pytest.mark.parametrize("digits_per_clock", [1, 2])
def test_every_address_with_numerators_of_either_sign(digits_per_clock: int) -> None:
    """The whole table, at both ends of each address, with the largest numerators that fit."""
    first = np.arange(128, 512) << 11
    denominator = np.concatenate([first, first + (1 << 11) - 1, first >> 2, first >> 10])
    x = denominator // 2
    check("table", SURFACE, x, -x, denominator, bits_per_clock=digits_per_clock)
    check("table", SURFACE, x // 3 - 1, x + 1, denominator, bits_per_clock=digits_per_clock)


@pytest.mark.parametrize("name", ENGINES)
@every_divider
def test_by_hand(kind: Divider, bits_per_clock: int, name: EngineName) -> None:
    """1/4, 5/16, 1/3, -1/4, a half and minus it; of no use; far beyond, at once or when shifted."""
    x = [1, 5, 1, -1, 1, -1, 9, 1 - (1 << 21), 1 << 17, 0]
    y = [0, -5, -1, 1, 0, 0, 9, 0, -3000, 3000]
    denominator = [4, 16, 3, 4, 2, 2, 16, 1 << 19, 1 << 19, 7]
    capture = check(kind, SURFACE, *map(np.array, (x, y, denominator)), name, bits_per_clock=bits_per_clock)
    seen = unpack(result_layout(64), capture.outputs["o"])
    third = {"serial": -43, "table": -42}[kind]
    assert seen["quotient"]["x"].tolist() == [32, 40, 43, -32, 64, -64, 0, -64, 32, 0]
    assert seen["quotient"]["y"].tolist() == [0, -40, third, 32, 0, 0, 0, 0, -1, 64]
    assert seen["reached"].tolist() == [0, 0, 0, 0, 1, 1, 0, 1, 0, 1]


def test_clocks_and_memory() -> None:
    """Four shifts, three clocks to the first sum, five digits; a bit of eight per clock.

    With two digits per clock: two shifts, and three words of two digits, of which one is not used.
    """
    assert TableDivider(*SURFACE).clocks == 12 and TableDivider(*SURFACE).memory_bits == 8192
    assert TableDivider(*STEP).clocks == 15 and TableDivider(*STEP).memory_bits == 65536
    assert TableDivider(*SURFACE, 2).clocks == 8 and TableDivider(*SURFACE, 2).memory_bits == 8192
    assert TableDivider(*STEP, 2).clocks == 10 and TableDivider(*STEP, 2).memory_bits == 65536
    assert SerialDivider(*SURFACE).clocks == 8 and SerialDivider(*STEP).clocks == 11
