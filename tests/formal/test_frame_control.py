# amaranth: UnusedElaboratable=no
"""Frame control: a frame has the size sampled with its first beat, at the default build."""

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

SMALLEST = 3
"""Least rows of a frame, and beats of a row, in a variant whose frames end within few clocks."""


def default(lanes: int) -> Build:
    return Build.profile("paper", pixels_per_clock=lanes)


def small(lanes: int) -> Build:
    # where beats are wide, as narrow as can be built
    width = 16 if lanes == 1 else 24
    return Build.profile("paper", pixel_bits=4, max_width=width, max_height=16, pixels_per_clock=lanes)


def allowed(size: Value, least: int, largest: int) -> Value:
    return Mux(size > largest, largest, Mux(size < least, least, size))


class FrameControlChecker(Elaboratable):
    """Sizes and settings change in every clock; only those at a first beat's transfer count."""

    def __init__(self, design: Any, lanes: int) -> None:
        self._design = design
        self._lanes = lanes

    def elaborate(self, platform: Any) -> Module:
        m, lanes = Module(), self._lanes
        is_small = hasattr(self._design, "SMALLEST")
        parameters = small(lanes) if is_small else default(lanes)
        least = {"x": parameters.min_width, "y": parameters.algorithm.support}
        if is_small:
            least = {"x": (SMALLEST - 1) * lanes + 1, "y": SMALLEST}
        m.submodules.dut = dut = self._design.FrameControl(parameters)
        inside = probes_of(dut)
        free(m, dut)
        assume_stable(m, dut.i, "i")
        stable(m, dut.o, "o")
        stable(m, dut.settings, "settings")

        # the row of the next beat, its place in it, and the size of its frame
        largest = {"x": parameters.max_width, "y": parameters.max_height}
        place = {axis: Signal(range(size + 1)) for axis, size in largest.items()}
        kept = {axis: Signal(range(size + 1)) for axis, size in largest.items()}
        first = (place["x"] == 0) & (place["y"] == 0)
        asked = {
            "x": allowed(dut.width, least["x"], largest["x"]),
            "y": allowed(dut.height, least["y"], largest["y"]),
        }
        size = {axis: Mux(first, asked[axis], kept[axis]) for axis in place}
        last = {"x": (place["x"] + 1) * lanes >= size["x"], "y": place["y"] + 1 == size["y"]}
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
            given=Cat(dut.next_settings, asked["x"][: lanes.bit_length() - 1]),
            leaves=moves(dut.settings),
            found=dut.settings.payload,
            capacity=1,
        )
        settings.leaves_within(1, dut.settings.ready)
        accepts_within(m, 2, dut.i, during=dut.o.ready & dut.settings.ready, name="i")
        if is_small:
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
        found = self._found(m, inside, first, place["x"])
        for axis, ends, early, step in (
            ("x", "eol", "last_but_one_x", lanes),
            ("y", "last_row", "last_but_one_y", 1),
        ):
            count = (kept[axis] + (step - 1))[step.bit_length() - 1 :]
            inside_range = (kept[axis] >= least[axis]) & (kept[axis] <= largest[axis])
            invariant(m, found[axis] == place[axis], f"{axis} differs")
            invariant(m, inside[early] >= -(-least[axis] // step) - 2, f"{axis} could end at once")
            with m.If(~first):
                invariant(m, inside_range, f"{axis} size out of range")
                invariant(m, place[axis] < count, f"{axis} out of range")
                invariant(m, inside[early] == count - 2, f"the end of {axis} differs")
                invariant(m, found[ends] == (place[axis] + 1 == count), f"{ends} differs")
            with m.Else():
                invariant(m, ~found[ends], f"{ends} at a first pixel")
        return m

    def _found(self, m: Module, inside: Any, first: Value, x: Value) -> dict[str, Value]:
        """Its registers; with several lanes those of rows as they are once a row's end has come."""
        found = {name: inside[name] for name in ("x", "y", "eol", "last_row")}
        if self._lanes == 1:
            return found
        late, y, last_row, early = (inside[name] for name in ("row_ended", "y", "last_row", "last_but_one_y"))
        with m.If(late):
            invariant(m, x == 0, "a row ended earlier")
            invariant(m, last_row == first, "another row ended")
            invariant(m, ~first | (y == early + 1), "a frame ended in another row")
        following = {"y": Mux(last_row, 0, y + 1)[: len(y)], "last_row": y == early}
        return found | {name: Mux(late, value, inside[name]) for name, value in following.items()}


SMALL = variant(
    hdl.frame_control,
    {
        "class FrameControl(": f"SMALLEST = {SMALLEST}\n\n\nclass FrameControl(",
        "least = p.pixels_per_clock, p.algorithm.support": "least = p.pixels_per_clock, SMALLEST",
        "init=-(-p.min_width // lanes) - 2": "init=SMALLEST - 2",
        "(self.width, p.min_width,": "(self.width, (SMALLEST - 1) * lanes + 1,",
    },
)


def _claim(says: str, lanes: int, *faults: Fault) -> Claim:
    return Claim(
        says=says,
        design=hdl.frame_control,
        small=SMALL,
        check=lambda design: FrameControlChecker(design, lanes),
        depth=1,
        covered=16,
        faults=faults,
    )


FRAMES = _claim(
    "FrameControl: ends of rows and frames, settings, stream rules",
    1,
    Fault("(width - (lanes + 1))", "(width - (lanes + 2))", "pixels: another beat", 16),
    Fault("p.max_height) - 2", "p.max_height) - 3", "pixels: another beat", 16),
    Fault("with m.Elif(self.settings.ready):", "with m.Else():", "settings: valid falls", 6),
    Fault("self.settings.payload.eq(settings),", "", "settings: another beat", 10),
)
LANES = _claim(
    "FrameControl, four pixels per clock: ends of rows and frames, settings, lanes of the last beat",
    4,
    Fault("(width - (lanes + 1))", "(width - lanes)", "pixels: another beat", 16),
    Fault("width[:lane_bits])", "self.width[:lane_bits])", "settings: another beat", 10),
)


@pytest.mark.parametrize("case", cases(FRAMES, LANES))
def test_frame_control(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)
