# amaranth: UnusedElaboratable=no
"""Both dividers as the refinement uses them: two quotients by one denominator, under stalls."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from golden.algorithm import Divider
from golden.divider import divide, quotient_bits, reaches
from golden.subpixel import FITS
from golden.table_divider import divide_by_table
from hdl.dividers import make_divider
from hdl.parts.quotients import PHASE_BITS, axes
from hdl.serial_divider import SerialDivider
from hdl.table_divider import TableDivider
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import ENGINES, NO_STALLS, RUN_IDS, RUNS, check_block, unpack

SURFACE = (FITS["nine"].mantissa_bits, FITS["nine"].limit)
STEP = (FITS["gradient"].mantissa_bits, FITS["gradient"].limit)
FORMATS = {"surface": SURFACE, "gradient-step": STEP}
Format = tuple[int, int]
Int64 = NDArray[np.int64]

every_divider = pytest.mark.parametrize(
    ("kind", "bits_per_clock"),
    # a serial divider is the same for both
    [("serial", 1), ("table", 1), ("table", 2)],
    ids=["serial", "table", "table-two-digits"],
)


def result_layout(limit: int) -> data.StructLayout:
    return data.StructLayout({"quotient": axes(quotient_bits(limit)), "reached": 1})


class Dividing(wiring.Component):
    """A divider as a stream. Like the refinement, it may wait with quotients that nobody takes."""

    def __init__(self, kind: Divider, mantissa_bits: int, limit: int, bits_per_clock: int = 1) -> None:
        self._divider = make_divider(kind, mantissa_bits, limit, bits_per_clock)
        self.interval = self._divider.clocks + 1
        self.latency = self.interval + 1
        operands = {"numerator": axes(2 * mantissa_bits + 2), "denominator": 2 * mantissa_bits, "usable": 1}
        super().__init__(
            {
                "i": In(stream.Signature(data.StructLayout(operands))),
                "o": Out(stream.Signature(result_layout(limit))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.divider = divider = self._divider
        phase = Signal(PHASE_BITS, init=divider.clocks)
        busy, usable, move = Signal(), Signal(), Signal()
        m.d.comb += [
            move.eq((phase == divider.clocks) & ~(busy & self.o.valid & ~self.o.ready)),
            self.i.ready.eq(move),
            divider.load.eq(move),
            divider.take.eq(move & busy),
            divider.phase.eq(phase),
            divider.numerator.eq(self.i.payload.numerator),
            divider.denominator.eq(self.i.payload.denominator),
            divider.usable.eq(usable),
            self.o.payload.quotient.eq(divider.quotient),
            self.o.payload.reached.eq(divider.reached),
        ]
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(move):
            m.d.sync += [
                busy.eq(self.i.valid),
                usable.eq(self.i.payload.usable),
                phase.eq(Mux(self.i.valid, 0, divider.clocks)),
            ]
            with m.If(busy):
                m.d.sync += self.o.valid.eq(1)
        with m.Elif(phase != divider.clocks):
            m.d.sync += phase.eq(phase + 1)
        return m


def golden(
    kind: Divider, form: Format, numerator: Int64, denominator: Int64
) -> tuple[Int64, NDArray[np.bool_]]:
    mantissa_bits, limit = form
    if kind == "table":
        return divide_by_table(numerator, denominator, 2 * mantissa_bits, limit)
    return divide(numerator, denominator, limit), reaches(numerator, denominator, limit)


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
    """Every seventh pair of quotients is of no use, by the way."""
    usable = np.arange(len(x)) % 7 != 6
    found = {"x": golden(kind, form, x, denominator), "y": golden(kind, form, y, denominator)}
    return check_block(
        (Dividing, kind, *form, bits_per_clock),
        {"i": {"numerator": {"x": x, "y": y}, "denominator": denominator, "usable": usable}},
        {
            "o": {
                "quotient": {axis: quotient * usable for axis, (quotient, _) in found.items()},
                "reached": (found["x"][1] | found["y"][1]) & usable,
            }
        },
        name,
        stalls,
        clocks=make_divider(kind, *form, bits_per_clock).clocks + 1,
    )


def operands(form: Format, count: int) -> tuple[Int64, Int64, Int64]:
    """Denominators of every length; numerators within the limit, at it, beyond it and anywhere."""
    mantissa_bits, limit = form
    rng = np.random.default_rng(form)
    length = rng.integers(1, 2 * mantissa_bits + 1, count)
    denominator = (1 << (length - 1)) + rng.integers(0, 1 << (length - 1))
    top = (1 << (2 * mantissa_bits + 1)) - 1
    numerators = []
    for _ in range(2):
        most = limit * denominator // 128
        choices = [
            rng.integers(-most - 1, most + 2),
            most + rng.integers(-2, 3, count),
            -most + rng.integers(-2, 3, count),
            rng.integers(-4, 5) * most,
            rng.integers(-top, top, count, endpoint=True) >> rng.integers(0, 2 * mantissa_bits, count),
            rng.integers(-3, 4, count),
        ]
        numerators.append(np.clip(np.choose(rng.integers(0, len(choices), count), choices), -top, top))
    return *numerators, denominator


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
