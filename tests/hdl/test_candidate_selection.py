# amaranth: UnusedElaboratable=no
"""Candidate selection: who is reported, where it lies, and how each frame is closed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from golden.formats import BUDGET_BITS
from golden.parameters import Parameters
from hdl.build import Build
from hdl.candidate_selection import INSIDE, CandidateSelection, pending_record_layout
from hdl.cell_grid import cell_settings_layout
from hdl.fits import derivatives_layout
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls, Stimulus
from tests.support.blocks import (
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    Size,
    Words,
    engine,
    pack,
    same,
    tags,
    unpack,
)

PARAMETERS = Build.profile("paper")
MARGIN = PARAMETERS.algorithm.margin
FULL = PARAMETERS.response_max
SURFACE = derivatives_layout(PARAMETERS)
CENTRE = data.StructLayout(
    {
        "corner": 1,
        "response": PARAMETERS.response_bits,
        "textured": 1,
        "keep": 1,
        "surface": SURFACE,
        "eol": 1,
        "eof": 1,
    }
)

CANDIDATES = Build.profile("paper").queue_depth
PENDING = CANDIDATES + INSIDE


class InStep(wiring.Component):
    """The selection with all inputs of a centre in one clock, and a clock between frames.

    ``broken`` says that its three inputs were not ready together.
    """

    def __init__(self, parameters: Parameters = PARAMETERS) -> None:
        self._budget, self._cells = parameters.budget, parameters.max_per_cell > 0
        self._filtered = parameters.algorithm.texture != "none"
        self.selection = CandidateSelection(parameters)
        super().__init__(
            {
                **({"max_corners": In(BUDGET_BITS)} if parameters.budget else {}),
                **({"cells": In(cell_settings_layout())} if self._cells else {}),
                "i": In(stream.Signature(CENTRE)),
                "candidate": Out(stream.Signature(SURFACE)),
                "pending": Out(stream.Signature(pending_record_layout(parameters))),
                "broken": Out(stream.Signature(1)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.selection = selection = self.selection
        corners, surfaces = selection.corners, selection.surfaces
        joined = [corners, surfaces]
        centre, valid = self.i.payload, Signal()
        # the grid takes two clocks for new settings
        pause = Signal(2, init=2 * self._cells)
        m.d.comb += [
            valid.eq(self.i.valid & (pause == 0)),
            self.i.ready.eq(corners.ready & (pause == 0)),
            corners.payload.data.corner.eq(centre.corner),
            corners.payload.data.response.eq(centre.response),
            *(corners.payload.eol.eq(centre.eol), corners.payload.eof.eq(centre.eof)),
            surfaces.payload.eq(centre.surface),
        ]
        if self._filtered:
            textures = selection.textures
            joined.append(textures)
            m.d.comb += [
                textures.payload.data.textured.eq(centre.textured),
                textures.payload.data.keep.eq(centre.keep),
                *(textures.payload.eol.eq(centre.eol), textures.payload.eof.eq(centre.eof)),
            ]
        m.d.comb += [source.valid.eq(valid) for source in joined]
        # what ends a row of cells needs a clock, too
        ends = centre.eol if self._cells else centre.eof
        m.d.sync += pause.eq(Mux(self.i.valid & self.i.ready & ends, 1, pause >> 1))
        with m.If(Cat(corners.ready != source.ready for source in joined).any()):
            m.d.sync += self.broken.valid.eq(1)
        if self._budget:
            m.d.comb += selection.max_corners.eq(self.max_corners)
        if self._cells:
            m.d.comb += selection.cells.eq(self.cells)
        wiring.connect(m, selection.candidate, wiring.flipped(self.candidate))
        wiring.connect(m, selection.pending, wiring.flipped(self.pending))
        return m


def centres(sizes: list[Size], chances: tuple[float, float, float]) -> dict[str, Array | dict[str, Array]]:
    """Frames of so many window centres, random ones of them corners, textured, and kept."""
    rng = np.random.default_rng(len(sizes))
    tagged = tags(sizes)
    total = len(tagged["eol"])
    corner, textured, keep = (rng.random(total) < chance for chance in chances)
    surface = {}
    for name, field in SURFACE:
        top = 1 << (field.width - 1)
        surface[name] = rng.integers(-top, top, total)
    response = rng.integers(0, FULL, total, endpoint=True)
    return {
        "corner": corner,
        "response": response,
        "textured": textured,
        "keep": keep,
        "surface": surface,
        **tagged,
    }


def wanted(sizes: list[Size], centre: dict[str, Any]) -> tuple[Array, Words, Words]:
    """Numbers of the candidates' centres, their surfaces, and all pending records with ends."""
    chosen = np.flatnonzero(centre["corner"] & centre["keep"])
    surfaces = pack(SURFACE, {name: values[chosen] for name, values in centre["surface"].items()})
    x = np.concatenate([np.tile(np.arange(width), height) for height, width in sizes]) + MARGIN
    y = np.concatenate([np.repeat(np.arange(height), width) for height, width in sizes]) + MARGIN
    pending = {field: centre[field] for field in ("response", "textured")} | {"x": x, "y": y, "end": 0 * x}
    pending = {field: values[chosen] for field, values in pending.items()}
    frame_ends = np.flatnonzero(centre["eof"])
    ends = np.searchsorted(chosen, frame_ends, side="right")
    # of a frame's end only the flag `end` counts, and the largest response of the whole frame
    of_ends: dict[str, Any] = dict.fromkeys(pending, 0)
    of_ends["end"] = 1
    of_ends["response"] = np.maximum.reduceat(centre["response"], [0, *(frame_ends[:-1] + 1)])
    pending = {field: np.insert(values, ends, of_ends[field]) for field, values in pending.items()}
    return chosen, surfaces, pack(pending_record_layout(PARAMETERS), pending)


def check(
    sizes: list[Size],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    chances: tuple[float, float, float] = (0.2, 0.4, 0.7),
    parameters: Parameters = PARAMETERS,
) -> Capture:
    centre = centres(sizes, chances)
    chosen, surfaces, expected = wanted(sizes, centre)
    quiet = 20 * int(1 / ((1 - stalls.inputs) * (1 - stalls.outputs))) + 200
    capture = engine(name, InStep, parameters).run(
        Stimulus({"i": pack(CENTRE, centre)}, [], stalls), quiet=quiet
    )
    pending = unpack(pending_record_layout(PARAMETERS), capture.outputs["pending"])
    # of a frame's end only the flag `end` counts, and the response
    marked = {field: pending[field] * (1 - pending["end"]) for field in ("x", "y", "textured")}
    marked = pending | marked
    same("pending", pack(pending_record_layout(PARAMETERS), marked), expected)
    same("candidate", capture.outputs["candidate"], surfaces)
    assert not len(capture.outputs["broken"])
    if not stalls.outputs:
        # room for everything: each at once
        accepted, is_end = capture.input_clocks["i"], pending["end"] == 1
        latency = CandidateSelection.latency
        assert np.array_equal(capture.output_clocks["candidate"], accepted[chosen] + latency)
        assert np.array_equal(capture.output_clocks["pending"][~is_end], accepted[chosen] + latency)
        frame_ends = np.flatnonzero(centre["eof"])
        assert np.array_equal(capture.output_clocks["pending"][is_end], accepted[frame_ends] + latency + 1)
    if stalls == NO_STALLS:
        # full rate, but for the clock that is missing between frames
        waits = np.diff(accepted) - 1
        assert (waits[frame_ends[:-1]] == 1).all() and waits.sum() == len(frame_ends) - 1
    return capture


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_frames(name: EngineName, stalls: Stalls) -> None:
    sizes = [(20, 31), (1, 1), (1, 9), (9, 1), (1, 1), (14, 14)]
    check(sizes if name == "compiled" else [(3, 5), (1, 1), (1, 4), (4, 1)], name, stalls)


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(inputs=0.3, outputs=0.4, seed=13)], ids=str)
def test_without_a_texture_filter_every_corner_is_kept(stalls: Stalls) -> None:
    # with the margin of the others
    parameters = Build.profile("paper", texture="none", suppression=4)
    check([(20, 31), (1, 1), (9, 9)], stalls=stalls, chances=(0.3, 0, 1), parameters=parameters)


@pytest.mark.parametrize(
    "chances", [(0, 0.5, 0.5), (1, 0.5, 0), (1, 0.5, 1), (1, 1, 1), (1, 0, 0.5)], ids=str
)
def test_none_and_all(chances: tuple[float, float, float]) -> None:
    check([(5, 7), (1, 1), (2, 2)], chances=chances)


def test_places_to_the_built_maximum() -> None:
    """The last centre of the largest frame there is in x, and in y."""
    capture = check([(2, 8192 - 2 * MARGIN), (8192 - 2 * MARGIN, 2), (1, 3)], chances=(1, 0.5, 1))
    pending = unpack(pending_record_layout(PARAMETERS), capture.outputs["pending"])
    corners = pending["end"] == 0
    assert pending["x"][corners].max() == pending["y"][corners].max() == 8191 - MARGIN
    assert pending["x"][corners].min() == pending["y"][corners].min() == MARGIN


@pytest.mark.parametrize("chances", [(1, 0.5, 1), (0.5, 0.5, 1), (0, 0, 0)], ids=str)
@pytest.mark.parametrize(
    "stalls", [Stalls(outputs=p, seed=s) for s, p in enumerate((0.5, 0.9, 0.98))], ids=str
)
def test_full_queues_lose_nothing(chances: tuple[float, float, float], stalls: Stalls) -> None:
    """More candidates than are taken, in all small frames: ends meet queues of every filling."""
    sizes = [(1, 1)] * 60 + [(1, width) for width in range(1, 40)] + [(2, 9)] * 30
    check(sizes, stalls=stalls, chances=chances)


@pytest.mark.parametrize("sink", ["candidate", "pending"])
def test_a_blocked_output_stops_the_input_and_not_the_other_output(sink: str) -> None:
    """It goes on until the queue is nearly full, and everything that went in comes out."""
    dut = InStep()
    depth = {"candidate": CANDIDATES, "pending": PENDING}[sink]
    other = dut.pending if sink == "candidate" else dut.candidate

    async def bench(ctx: Any) -> None:
        ctx.set(dut.i.valid, 1)
        ctx.set(dut.i.payload.corner, 1)
        ctx.set(dut.i.payload.keep, 1)
        ctx.set(other.ready, 1)
        taken = out = 0
        for clock in range(4 * PENDING):
            ctx.set(dut.i.payload.response, taken)
            taken += ctx.get(dut.i.ready)
            out += ctx.get(other.valid)
            if clock >= 2 * PENDING:
                assert not ctx.get(dut.i.ready)
            await ctx.tick()
        assert depth - 4 < taken <= depth and out == taken
        # and on again, once it is free
        ctx.set(getattr(dut, sink).ready, 1)
        for _ in range(depth):
            await ctx.tick()
        assert ctx.get(dut.i.ready)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()


def test_latency() -> None:
    assert CandidateSelection.latency == 2


@pytest.mark.parametrize("most", [0, 1, 5, 17, 1000])
@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.2, 0.9, 3)], ids=["flowing", "stalled"])
def test_limit(most: int, stalls: Stalls) -> None:
    """The first untextured ones of each frame; an end's x and y are the number of all."""
    sizes = [(12, 20), (9, 9), (1, 30), (30, 25)]
    centre = centres(sizes, (0.3, 0.4, 0.7))
    # not two in two clocks, which cannot be
    centre["corner"][1::2] = False
    capture = engine("compiled", InStep, Build.profile("paper", budget=True)).run(
        Stimulus({"i": pack(CENTRE, centre)}, [(0, {"max_corners": most})], stalls), quiet=500
    )
    pending = unpack(pending_record_layout(PARAMETERS), capture.outputs["pending"])
    chosen, surfaces, expected = wanted(sizes, centre)
    frame = np.repeat(np.arange(len(sizes)), [height * width for height, width in sizes])[chosen]
    found = np.bincount(frame, minlength=len(sizes))
    accepted = ~centre["textured"][chosen]
    before = [np.cumsum(accepted[frame == k]) - accepted[frame == k] for k in range(len(sizes))]
    kept = np.concatenate(before) < most if most else frame >= 0
    assert not accepted.all() and kept.all() == (most in (0, 1000))
    same("candidate", capture.outputs["candidate"], surfaces[kept])
    is_end = pending["end"] == 1
    said = pending["x"] | pending["y"] << (pending["x"].dtype.type(13))
    assert said[is_end].tolist() == found.tolist()
    corners = unpack(pending_record_layout(PARAMETERS), expected)
    reported = {field: values[corners["end"] == 0][kept] for field, values in corners.items()}
    assert all(np.array_equal(pending[field][~is_end], reported[field]) for field in reported)
    assert (
        np.flatnonzero(is_end).tolist()
        == (np.cumsum(np.bincount(frame[kept], minlength=4)) + range(4)).tolist()
    )


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@pytest.mark.parametrize("per_cell", [0, 3])
def test_cells(name: EngineName, stalls: Stalls, per_cell: int) -> None:
    """Each corner with its cell, and ends of rows of cells; where cells choose, no limit before."""
    parameters = Build.profile("paper", budget=True, max_width=64, max_per_cell=4)
    layout, (height, width), side = pending_record_layout(parameters), (21, 40), {"x": 9, "y": 8}
    chosen = side["x"], side["y"], per_cell
    sizes = [(height, width)] * (3 if name == "compiled" else 1)
    centre = centres(sizes, (0.3, 0.4, 0.7))
    centre["corner"][1::2] = False
    levels = {
        "max_corners": 5,
        "cells": sum(value << at for at, value in zip((0, 8, 16), chosen, strict=True)),
    }
    capture = engine(name, InStep, parameters).run(
        Stimulus({"i": pack(CENTRE, centre)}, [(0, levels)], stalls),
        quiet=500 + 20 * int(1 / ((1 - stalls.inputs) * (1 - stalls.outputs))),
    )
    pending = unpack(layout, capture.outputs["pending"])
    cell, marks = pending["cell"], pending["end"] == 1
    if not per_cell:
        assert not cell["row_end"].any() and not cell["per_cell"].any()
        accepted = (pending["textured"] == 0) & ~marks
        assert accepted.sum() == 5 * len(sizes)
        return
    marks |= cell["row_end"] == 1
    picked = np.flatnonzero(centre["corner"] & centre["keep"])
    frame, place = np.divmod(picked, height * width)
    y, x = (at + MARGIN for at in np.divmod(place, width))
    assert pending["x"][~marks].tolist() == x.tolist() and pending["y"][~marks].tolist() == y.tolist()
    columns = x // side["x"] - MARGIN // side["x"]
    assert cell["column"][~marks].tolist() == columns.tolist()
    assert (cell["per_cell"] == per_cell).all() and (cell["max_corners"] == 5).all()
    # every row of cells ends after the last of its corners
    rows = frame * 100 + y // side["y"]
    each = [100 * k + row for k in range(len(sizes)) for row in range(MARGIN // side["y"], 4)]
    ends = [int((rows <= row).sum()) + k for k, row in enumerate(each)]
    assert np.flatnonzero(marks).tolist() == ends
    assert (pending["end"][marks] == [row % 100 == 3 for row in each]).all()
