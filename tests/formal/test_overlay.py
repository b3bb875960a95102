# amaranth: UnusedElaboratable=no
"""Overlay: its output keeps the rule of streams for any input, with restarts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Cover, Elaboratable, Module

import hdl.edges.lane_overlay
import hdl.edges.overlay
from hdl.build import Build
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import variant
from tests.formal.properties import free, moves, stable

PARAMETERS = Build.profile("paper", max_width=15, max_height=15, buffering="lean", video_out=True)
"""The smallest, because the depth of its memory has no part in this."""


class OverlayChecker(Elaboratable):
    """Nothing is assumed."""

    def __init__(self, design: Any, lanes: int = 1) -> None:
        self._design, self._lanes = design, lanes

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        if self._lanes == 1:
            dut = self._design.Overlay(PARAMETERS)
        else:
            dut = self._design.LaneOverlay(PARAMETERS.changed(max_width=30, pixels_per_clock=self._lanes))
        m.submodules.dut = dut
        free(m, dut)
        stable(m, dut.o, "o")
        m.d.comb += Cover(moves(dut.o) & dut.o.payload.eol, "a line ends")
        return m


OVERLAY = Claim(
    says="Overlay: a pixel stays until it is taken, for any input",
    design=hdl.edges.overlay,
    check=OverlayChecker,
    depth=1,
    covered=8,
    faults=(
        Fault("(~self.o.valid | self.o.ready) & (~flagged", "(~flagged", "o: the payload changes", within=8),
        Fault(
            "with m.If(step):\n            m.d.sync += [\n                self.o",
            "if True:\n            m.d.sync += [\n                self.o",
            "o: the payload changes",
            within=8,
        ),
    ),
)
LANES = Claim(
    says="LaneOverlay, four pixels per clock: a beat stays until it is taken, for any input",
    design=hdl.edges.lane_overlay,
    small=variant(hdl.edges.lane_overlay, {"self._build.ring_beats + _RESERVE": "8"}),
    long_proof=True,
    check=lambda design: OverlayChecker(design, lanes=4),
    depth=1,
    covered=8,
    faults=(
        Fault("(~self.o.valid | self.o.ready) & (~flagged", "(~flagged", "o: the payload changes", within=8),
    ),
)


@pytest.mark.parametrize("case", cases(OVERLAY, LANES))
def test_overlay(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
