# amaranth: UnusedElaboratable=no
"""LUT divider: every table entry with every dividend, wide operands, clamping, and the stated error."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from golden.divider import HALF, INDEX_BITS, NUMERATOR_BITS, divide, worst_error
from hdl.divider import Divider
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.hdl.blocks import ENGINES, NO_STALLS, RUN_IDS, RUNS, assert_timing, engine, pack, run

ASIDE = 3
NARROWEST = NUMERATOR_BITS + 1
WIDTHS = [NARROWEST, 20, 40, 51]

Int64 = NDArray[np.int64]


def check(
    bits: int,
    numerator: Int64,
    denominator: Int64,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
) -> Capture:
    block = Divider(bits, ASIDE)
    clamped = 2 * numerator > denominator
    quotient = np.where(clamped, HALF, divide(np.where(clamped, 0, numerator), denominator))
    aside = np.arange(len(numerator)) % (1 << ASIDE)
    given = {"numerator": numerator, "denominator": denominator, "aside": aside}
    expected = {"quotient": quotient, "clamped": clamped, "aside": aside}
    capture = run(
        engine(name, Divider, bits, ASIDE),
        {"i": pack(block.i.payload.shape(), given)},
        {"o": pack(block.o.payload.shape(), expected)},
        stalls,
    )
    if stalls == NO_STALLS:
        assert_timing(capture, block.latency)
    return capture


def operands(bits: int, count: int, seed: int = 0) -> tuple[Int64, Int64]:
    """Divisors of every length; dividends below, at, just above and far above their half."""
    rng = np.random.default_rng([bits, seed])
    length = rng.integers(1, bits + 1, count)
    denominator = (1 << (length - 1)) + rng.integers(0, 1 << (length - 1))
    below = rng.integers(0, denominator // 2 + 1)
    kind = np.arange(count) % 8
    numerator = np.select(
        [kind == 0, kind == 1, kind == 2, kind == 3, kind == 4],
        [
            0 * below,
            denominator // 2,
            denominator // 2 + 1,
            denominator,
            rng.integers(0, 1 << bits, count),
        ],
        below,
    )
    return np.minimum(numerator, (1 << bits) - 1), denominator


@pytest.mark.parametrize("bits", WIDTHS)
def test_operands_of_every_length(bits: int) -> None:
    numerator, denominator = operands(bits, 100_000)
    check(bits, numerator, denominator)


def test_every_table_entry_with_every_dividend() -> None:
    """All 256 by 1024, of which the result is made, at the low and at the high end of what is cut to them."""
    bits = 20
    index, cut = (
        grid.reshape(-1) for grid in np.mgrid[: 1 << INDEX_BITS, : 1 << NUMERATOR_BITS].astype(np.int64)
    )
    low_bits, cut_bits = bits - INDEX_BITS - 1, bits - NUMERATOR_BITS - 1
    for end in (0, 1):
        denominator = (((1 << INDEX_BITS) + index + end) << low_bits) - end
        check(bits, ((cut + end) << cut_bits) - end, denominator)


def test_every_divisor() -> None:
    """The narrowest divider: each of its divisors with a hundred dividends."""
    denominator = np.repeat(np.arange(1, 1 << NARROWEST), 100)
    numerator = np.random.default_rng(1).integers(0, denominator // 2 + 2)
    check(NARROWEST, numerator, denominator)


@pytest.mark.parametrize("bits", WIDTHS)
def test_error_against_exact_quotients(bits: int) -> None:
    """What comes out of the hardware itself, compared with fractions."""
    numerator, denominator = operands(bits, 4000, 1)
    capture = check(bits, numerator, denominator)
    quotient = capture.outputs["o"] & np.uint64(127)
    limit = Fraction(worst_error())
    assert limit <= Fraction(1, 128)
    for n, d, q in zip(numerator.tolist(), denominator.tolist(), quotient.tolist(), strict=True):
        assert abs(Fraction(q, 128) - min(Fraction(n, d), Fraction(1, 2))) <= limit


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_stalls(name: EngineName, stalls: Stalls) -> None:
    numerator, denominator = operands(40, 4000 if name == "compiled" else 200)
    check(40, numerator, denominator, name, stalls)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """0, 1/4, 1/3, 1/2, and beyond: 127.5/256 of a pixel would be 64; clamped only above one half."""
    cases = [(0, 5, 0, 0), (1, 4, 32, 0), (333_333, 1_000_000, 43, 0), (500, 1000, 64, 0)]
    cases += [(501, 1000, 64, 1), (3, 2, 64, 1), ((1 << 40) - 1, 1, 64, 1), (1, (1 << 40) - 1, 0, 0)]
    numerator, denominator, quotient, clamped = np.array(cases).T
    capture = check(40, numerator, denominator, name)
    assert (capture.outputs["o"] & np.uint64(127)).tolist() == quotient.tolist()
    assert (capture.outputs["o"] >> np.uint64(7) & np.uint64(1)).tolist() == clamped.tolist()


@pytest.mark.parametrize("bits", [1, 8, NARROWEST - 1])
def test_too_narrow_ones_are_refused(bits: int) -> None:
    with pytest.raises(ValueError, match=rf"bits is {bits}; allowed: whole numbers from {NARROWEST}"):
        Divider(bits)


def test_latency() -> None:
    """One shift per bit of the width's length, table, a tree of ten, rounding."""
    assert [Divider(bits).latency for bits in (11, 16, 17, 40, 51)] == [10, 10, 11, 12, 12]
