# amaranth: UnusedElaboratable=no
"""Either divider as a block with streams; operands, and the quotients of the golden functions."""

from __future__ import annotations

from typing import Any

import numpy as np
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

SURFACE = (FITS["nine"].mantissa_bits, FITS["nine"].limit)
STEP = (FITS["gradient"].mantissa_bits, FITS["gradient"].limit)
FORMATS = {"surface": SURFACE, "gradient-step": STEP}
Format = tuple[int, int]
Int64 = NDArray[np.int64]
Beats = dict[str, Any]


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


def quotients(kind: Divider, form: Format, x: Int64, y: Int64, denominator: Int64) -> tuple[Beats, Beats]:
    """Beats given and expected; every seventh pair of quotients is of no use, by the way."""
    usable = np.arange(len(x)) % 7 != 6
    found = {"x": golden(kind, form, x, denominator), "y": golden(kind, form, y, denominator)}
    given = {"numerator": {"x": x, "y": y}, "denominator": denominator, "usable": usable}
    expected = {
        "quotient": {axis: quotient * usable for axis, (quotient, _) in found.items()},
        "reached": (found["x"][1] | found["y"][1]) & usable,
    }
    return {"i": given}, {"o": expected}


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
