# amaranth: UnusedElaboratable=no
"""Thresholds: each frame gets its own, and nothing waits for ever."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Assert, Cat, Cover, Elaboratable, Module, Mux, Signal, Value

import hdl.thresholds
from hdl.build import Build
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of, variant
from tests.formal.properties import Scoreboard, assume_stable, free, invariant, moves, stable, within

DEFAULT = Build.profile("paper")
NARROW = Build.profile("paper", pixel_bits=4)
"""Here multiplications take few clocks, so that covers and faults are found soon."""


class ThresholdsChecker(Elaboratable):
    def __init__(self, design: Any, lanes: int = 1) -> None:
        self._design = design
        self._lanes = lanes

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bits = self._design.SIGMA2_BITS
        built = DEFAULT if bits == hdl.thresholds.SIGMA2_BITS else NARROW
        parameters = built.changed(pixels_per_clock=self._lanes)
        m.submodules.dut = dut = self._design.Thresholds(parameters)
        inside = probes_of(dut)
        free(m, dut)
        for name in ("i", "settings"):
            assume_stable(m, getattr(dut, name), name)
        for name in ("o", "thresholds"):
            stable(m, getattr(dut, name), name)
        m.d.comb += [
            Assert(moves(dut.i) == moves(dut.o), "a beat does not pass through in its clock"),
            Assert(~dut.o.valid | (dut.i.payload == dut.o.payload), "a beat changes on its way through"),
        ]

        first, step = Signal(init=1), moves(dut.i)
        with m.If(step):
            m.d.sync += first.eq(dut.i.payload.eof)
        taken = Scoreboard(
            m,
            "settings taken",
            enters=step & first,
            given=0,
            leaves=moves(dut.settings),
            found=0,
            capacity=1,
        )
        soon = taken.leaves_within(2, dut.settings.valid)
        made = Scoreboard(
            m,
            "thresholds",
            enters=moves(dut.settings),
            given=self._passed_on(dut.settings.payload),
            leaves=moves(dut.thresholds),
            found=self._passed_on(dut.thresholds.payload),
            capacity=1,
        )
        made_within = made.leaves_within(bits + 1, dut.thresholds.ready)
        ready = dut.o.ready & dut.settings.valid & dut.thresholds.ready
        # from a frame's first response to the thresholds' leaving, and one clock to look at it
        most = bits + 5
        late = within(m, most, during=ready & dut.i.valid, happens=step, name="i: a beat is not accepted")
        m.d.comb += Cover(moves(dut.thresholds) & first, "thresholds later than their frame")

        chosen, referred, multiplying = (inside[name] for name in ("chosen", "referred", "multiplying"))
        busy, count, may_start = (inside[name] for name in ("busy", "count", "may_start"))
        valid = dut.thresholds.valid
        invariant(m, chosen + referred + multiplying + valid <= 1, "two things at once")
        invariant(m, busy == (chosen | referred | multiplying), "busy differs")
        invariant(m, ~may_start | (dut.settings.valid & ~busy & ~valid), "a start too early")
        invariant(m, ~multiplying | (count < bits), "too many bits")
        invariant(m, taken.inside == (chosen | referred), "frames and settings differ")
        invariant(m, made.inside == (multiplying | valid), "settings and thresholds differ")
        invariant(m, ~(chosen | referred) | dut.settings.valid, "settings are gone")
        invariant(m, inside["first"] == first, "frames differ")
        with m.If(made.following):
            invariant(m, self._passed_on(dut.thresholds.payload) == made.value, "another frame's thresholds")
        # how far it has come with a frame: what is overdue cannot be so for longer
        invariant(m, soon <= referred, "settings come late")
        invariant(m, ~multiplying | (made_within <= count), "thresholds come late")
        invariant(m, ~valid | (made_within <= bits), "thresholds stay")
        with m.If(~may_start):
            come = Mux(multiplying, count + 2, Mux(valid, bits + 2, Mux(busy, referred, bits + 3)))
            invariant(m, late <= come, "an input waits for longer than all these take")
        with m.Else():
            invariant(m, late <= bits + 4, "an input waits longer")
        return m

    def _passed_on(self, payload: Any) -> Value:
        """What settings and thresholds have in common."""
        return Cat(payload.report_rejected, payload.last_lanes if self._lanes > 1 else ())


SMALL = variant(
    hdl.thresholds,
    {
        "    SIGMA2_INTEGER_BITS,\n    SIGMA_BITS,\n": "",
        "SIGMA2_BITS = ": "SIGMA_BITS, SIGMA2_INTEGER_BITS = 2, 1\nSIGMA2_BITS = ",
    },
)
THRESHOLDS = Claim(
    says="Thresholds: one set per frame, stream rules, no deadlock",
    design=hdl.thresholds,
    small=SMALL,
    check=ThresholdsChecker,
    depth=2,
    covered=14,
    faults=(
        Fault("first.eq(self.i.payload.eof)", "first.eq(0)", "", 20),
        Fault("& ~busy & ~self.thresholds.valid & ~start", "& ~busy & ~start", "thresholds: ", 20),
        Fault(
            "with m.If(self.thresholds.ready):",
            "with m.If(self.thresholds.ready & self.i.valid):",
            "thresholds: ",
            32,
        ),
    ),
)
LANES = Claim(
    says="Thresholds, four pixels per clock: one set per frame, with the lanes of its rows' last beats",
    design=hdl.thresholds,
    small=SMALL,
    check=lambda design: ThresholdsChecker(design, lanes=4),
    depth=2,
    covered=14,
    faults=(
        Fault(
            "last_lanes.eq(self.settings.payload.last_lanes)", "last_lanes.eq(0)", "thresholds: another", 20
        ),
    ),
)


@pytest.mark.parametrize("case", cases(THRESHOLDS, LANES))
def test_thresholds(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
