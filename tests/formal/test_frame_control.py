# amaranth: UnusedElaboratable=no
"""Frame control: a frame has the size sampled with its first pixel, at the default build."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from amaranth.hdl import Cat, Cover, Elaboratable, Module, Mux, Signal, Value

import hdl.frame_control
from hdl.build import Build
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import probes_of, variant
from tests.formal.properties import (
    Scoreboard,
    accepts_within,
    assume_stable,
    free,
    invariant,
    moves,
    stable,
)

DEFAULT = Build.profile("paper")
SMALL = Build.profile("paper", pixel_bits=4, max_width=16, max_height=16)
SMALLEST = 3
"""Least side of a frame in a variant whose frames can end within few clocks."""


def allowed(size: Value, least: int, largest: int) -> Value:
    return Mux(size > largest, largest, Mux(size < least, least, size))


class FrameControlChecker(Elaboratable):
    """Sizes and settings change in every clock; only those at a first pixel's transfer count."""

    def __init__(self, design: Any) -> None:
        self._design = design

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        small = hasattr(self._design, "SMALLEST")
        parameters = SMALL if small else DEFAULT
        least = SMALLEST if small else parameters.algorithm.support
        m.submodules.dut = dut = self._design.FrameControl(parameters)
        inside = probes_of(dut)
        free(m, dut)
        assume_stable(m, dut.i, "i")
        stable(m, dut.o, "o")
        stable(m, dut.settings, "settings")

        # the place of the next pixel, and the size of its frame
        sizes = {"x": parameters.max_width, "y": parameters.max_height}
        place = {axis: Signal(range(size + 1)) for axis, size in sizes.items()}
        kept = {axis: Signal(range(size + 1)) for axis, size in sizes.items()}
        first = (place["x"] == 0) & (place["y"] == 0)
        asked = {
            "x": allowed(dut.width, least, parameters.max_width),
            "y": allowed(dut.height, least, parameters.max_height),
        }
        last = {axis: place[axis] + 1 == Mux(first, asked[axis], kept[axis]) for axis in place}
        eol, eof = last["x"], last["x"] & last["y"]
        with m.If(moves(dut.i)):
            m.d.sync += place["x"].eq(Mux(eol, 0, place["x"] + 1))
            with m.If(eol):
                m.d.sync += place["y"].eq(Mux(eof, 0, place["y"] + 1))
            with m.If(first):
                m.d.sync += [kept[axis].eq(asked[axis]) for axis in kept]
        pixels = Scoreboard(
            m,
            "pixels",
            enters=moves(dut.i),
            given=Cat(dut.i.payload, eol, eof),
            leaves=moves(dut.o),
            found=dut.o.payload,
            capacity=1,
        )
        pixels.leaves_within(1, dut.o.ready)
        settings = Scoreboard(
            m,
            "settings",
            enters=moves(dut.i) & first,
            given=dut.next_settings,
            leaves=moves(dut.settings),
            found=dut.settings.payload,
            capacity=1,
        )
        settings.leaves_within(1, dut.settings.ready)
        accepts_within(m, 2, dut.i, during=dut.o.ready & dut.settings.ready, name="i")
        if small:
            m.d.comb += [
                Cover(moves(dut.o) & dut.o.payload.eol, "a row ends"),
                Cover(moves(dut.o) & dut.o.payload.eof, "a frame ends"),
                Cover(moves(dut.i) & (place["x"] == 4) & (place["y"] == 1), "a row is longer"),
            ]

        for board, port in ((pixels, dut.o), (settings, dut.settings)):
            invariant(m, board.inside == port.valid, "beats and valid differ")
            with m.If(board.following):
                invariant(m, Value.cast(port.payload) == board.value, "another beat waits at the output")
        invariant(m, inside["first"] == first, "first differs")
        for axis, ends, early, largest in (
            ("x", "eol", "last_but_one_x", parameters.max_width),
            ("y", "last_row", "last_but_one_y", parameters.max_height),
        ):
            size = kept[axis]
            invariant(m, inside[axis] == place[axis], f"{axis} differs")
            invariant(m, inside[early] >= least - 2, f"{axis} could end at once")
            with m.If(~first):
                invariant(m, (size >= least) & (size <= largest), f"{axis} size out of range")
                invariant(m, place[axis] < size, f"{axis} out of range")
                invariant(m, inside[early] == size - 2, f"the end of {axis} differs")
                invariant(m, inside[ends] == (place[axis] + 1 == size), f"{ends} differs")
            with m.Else():
                invariant(m, ~inside[ends], f"{ends} at a first pixel")
        return m


def _size_fault(axis: str, within: int) -> Fault:
    old = f"self._parameters.max_{axis}) - 2"
    return Fault(old, old.replace("- 2", "- 3"), "pixels: another beat", within)


FRAMES = Claim(
    says="FrameControl: ends of rows and frames, settings, stream rules",
    design=hdl.frame_control,
    small=variant(
        hdl.frame_control,
        {
            "class FrameControl(": f"SMALLEST = {SMALLEST}\n\n\nclass FrameControl(",
            "least = self._parameters.algorithm.support": "least = SMALLEST",
        },
    ),
    check=FrameControlChecker,
    depth=1,
    covered=16,
    faults=(
        _size_fault("width", 16),
        _size_fault("height", 16),
        Fault("with m.Elif(self.settings.ready):", "with m.Else():", "settings: valid falls", 6),
        Fault("self.settings.payload.eq(self.next_settings),", "", "settings: another beat", 10),
    ),
)


@pytest.mark.parametrize("case", cases(FRAMES))
def test_frame_control(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
