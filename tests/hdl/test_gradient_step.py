# amaranth: UnusedElaboratable=no
"""Gradient steps out of the pixel store against the golden model, candidate by candidate."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.lib.stride_tricks import sliding_window_view

from golden.subpixel import FITS, subpixel
from hdl.build import Build
from hdl.fits import derivatives_layout
from hdl.gradient_step import GradientStep
from hdl.parts.stream import Beat
from hdl.pixel_store import PixelStore
from hdl.sample import pixels_shape
from hdl.step_layouts import rows_kept
from hdl.subpixel import offset_layout
from hdl.surface import SurfaceFit
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.beats import LANES_IN_TURN, in_beats
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, Array, raster, run_block
from tests.support.photographs import photograph

BUILD = Build.profile("paper", fit="gradient", max_width=80, max_height=64)
in_turn = pytest.mark.parametrize("lanes", LANES_IN_TURN)
HEIGHT, WIDTH = 15, 80


class WithStore(wiring.Component):
    """The steps of candidates in the middle row of one frame, which come when it is there."""

    def __init__(self, build: Build) -> None:
        self._build = build
        self.step = GradientStep(build)
        candidate = data.StructLayout({"surface": derivatives_layout(build), "x": range(build.max_width)})
        super().__init__(
            {
                "candidate": In(stream.Signature(candidate)),
                "pixels": In(stream.Signature(Beat(pixels_shape(build)))),
                "o": Out(stream.Signature(offset_layout("gradient"))),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.store = store = PixelStore(self._build, rows_kept(self._build))
        m.submodules.step = step = self.step
        wiring.connect(m, wiring.flipped(self.pixels), store.i)
        complete = Signal()
        with m.If(store.o.valid & store.o.payload.eof):
            m.d.sync += complete.eq(1)
        given = self.candidate.payload
        m.d.comb += [
            store.o.ready.eq(1),
            *(getattr(store, name).eq(getattr(step, name)) for name in ("needed", "reading", "place")),
            step.column.eq(store.column),
            step.i.valid.eq(self.candidate.valid & complete),
            self.candidate.ready.eq(step.i.ready & complete),
            step.i.payload.surface.eq(given.surface),
            step.i.payload.place.x.eq(given.x),
            step.picked.eq(step.i.valid & step.i.ready),
        ]
        wiring.connect(m, step.o, wiring.flipped(self.o))
        return m


def check(
    frame: Array, responses: Array, parameters: Build, name: EngineName, stalls: Stalls, seed: int = 0
) -> Any:
    """A candidate for each of the (n, 3, 3) responses, somewhere in the middle row."""
    rng = np.random.default_rng(seed)
    x = rng.integers(7, WIDTH - 7, len(responses))
    windows = sliding_window_view(frame, (15, 15))[0, x - 7]
    expected = subpixel(responses, parameters, windows)
    surface = FITS["gradient"].derivatives(responses)._asdict()
    formats = SurfaceFit.formats(parameters)._asdict()
    given = {field: value >> formats[field].zeros for field, value in surface.items()}
    pixels = raster(in_beats([frame], parameters.pixels_per_clock)[0])
    capture = run_block(
        (WithStore, parameters),
        {"candidate": {"surface": given, "x": x}, "pixels": pixels},
        {"o": vars(expected)},
        name,
        stalls,
        clocks=130,
    )
    return capture, expected


def corners(frame_kind: str) -> Array:
    if frame_kind == "noise":
        return np.random.default_rng(2).integers(0, 255, (HEIGHT, WIDTH), np.uint8, endpoint=True)
    return np.ascontiguousarray(photograph("camera")[200 : 200 + HEIGHT, 200 : 200 + WIDTH])


@pytest.mark.parametrize("frame_kind", ["noise", "photograph"])
@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_offsets(name: EngineName, stalls: Stalls, frame_kind: str) -> None:
    count = 300 if name == "compiled" else 6
    top = BUILD.response_max
    responses = np.random.default_rng(1).integers(0, top, (count, 3, 3), endpoint=True)
    responses[::2, 1, 1] = top
    capture, expected = check(corners(frame_kind), responses, BUILD, name, stalls)
    if stalls == NO_STALLS and name == "compiled":
        assert expected.clamped.any() and not expected.clamped.all()
        keeps_its_pace(BUILD, capture)


def keeps_its_pace(build: Build, capture: Any) -> None:
    step = GradientStep(build)
    late = capture.output_clocks["o"] - capture.input_clocks["candidate"]
    assert late.max() <= step.latency + step.inside * step.interval
    steps = np.diff(capture.output_clocks["o"])
    assert steps[8:].mean() <= step.interval


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.3, 0.9, 13)], ids=["unstalled", "both-stall"])
@in_turn
def test_offsets_with_several_pixels_per_clock(lanes: int, stalls: Stalls) -> None:
    """Windows begin in every lane, at whatever row."""
    build = BUILD.changed(pixels_per_clock=lanes)
    responses = np.random.default_rng(1).integers(0, build.response_max, (200, 3, 3), endpoint=True)
    responses[::2, 1, 1] = build.response_max
    capture, _ = check(corners("photograph"), responses, build, "compiled", stalls)
    if stalls == NO_STALLS:
        keeps_its_pace(build, capture)


@in_turn
def test_a_lone_candidate_is_done_in_time(lanes: int) -> None:
    """At no pace does it take longer than the latency says."""
    build, responses = BUILD.changed(pixels_per_clock=lanes), np.full((1, 3, 3), 5)
    capture, _ = check(corners("photograph"), responses, build, "compiled", NO_STALLS)
    late = capture.output_clocks["o"] - capture.input_clocks["candidate"]
    assert late.max() <= GradientStep(build).latency
