# amaranth: UnusedElaboratable=no
"""The response filter by lanes, against the golden model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from numpy.lib.stride_tricks import sliding_window_view

from golden.response_filter import response_filter
from hdl.build import Build
from hdl.centre_rows import CENTRE_SIZE
from hdl.smoothed_beats import SMOOTHED_ROWS, SmoothedBeats
from sim.stimulus import Stalls
from tests.support.beats import in_beats
from tests.support.blocks import NO_STALLS, Array, check_block, noise, pack, tags


def columns_of(frames: list[Array], rows: int) -> Array:
    """Columns of so many rows of (height, beats, lanes) frames: (columns, rows, lanes)."""
    windows = [np.moveaxis(sliding_window_view(frame, rows, axis=0), -1, 2) for frame in frames]
    return np.concatenate([window.reshape(-1, rows, window.shape[-1]) for window in windows])


class Rejoined(wiring.Component):
    """Smoothed beats whose tags come first, and wait here for their values."""

    latency = SmoothedBeats(Build.profile("robust", pixels_per_clock=2)).latency

    def __init__(self, build: Build) -> None:
        self._block = block = SmoothedBeats(build, tags_first=True)
        assert block.latency == self.latency - 1
        super().__init__(dict(block.signature.members))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.block = block = self._block
        given, taken = block.o, self.o
        m.d.comb += [
            block.permit.eq(self.permit),
            given.ready.eq(taken.ready),
            taken.payload.data.eq(given.payload.data),
        ]
        with m.If(taken.ready):
            m.d.sync += [
                taken.valid.eq(given.valid),
                taken.payload.eol.eq(given.payload.eol),
                taken.payload.eof.eq(given.payload.eof),
            ]
        wiring.connect(m, wiring.flipped(self.i), block.i)
        return m


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.3, 0.4, 13)], ids=["unstalled", "both-stall"])
@pytest.mark.parametrize(
    ("block", "lanes"), [*((SmoothedBeats, lanes) for lanes in (2, 4, 8)), (Rejoined, 4)]
)
def test_noise(block: Callable[[Build], Any], lanes: int, stalls: Stalls) -> None:
    """Every beat comes out; those of a row's first two responses mean nothing."""
    build = Build.profile("robust", pixels_per_clock=lanes)
    lost = 2 * build.algorithm.response_margin
    sizes = [(7, 2 * lanes + 3 + k) for k in range(lanes)]
    frames = noise(sizes, build.response_max)
    smoothed = [np.pad(response_filter(frame), ((0, 0), (2, 0))) for frame in frames]
    beats, _ = in_beats(frames, lanes, lost=lost, largest=build.response_max)
    expected, _ = in_beats(smoothed, lanes, lost=lost, largest=0)
    whole = [
        np.pad(np.ones((frame.shape[0] - 2, frame.shape[1] - 2), bool), ((0, 0), (2, 0))) for frame in frames
    ]
    counts, _ = in_beats(whole, lanes, lost=lost, largest=0)
    ends = tags([(len(frame) - SMOOTHED_ROWS + 1, frame.shape[1]) for frame in beats])
    out = SmoothedBeats(build).o.payload.shape()
    marks = np.where(columns_of(counts, CENTRE_SIZE), -1, 0)
    check_block(
        (block, build),
        {"i": {"data": {"response": columns_of(beats, SMOOTHED_ROWS)}, **ends}},
        {"o": {"data": {"response": columns_of(expected, CENTRE_SIZE)}, **ends}},
        "amaranth",
        stalls,
        levels=[(0, {"permit": 1})],
        counting={"o": pack(out, {"data": {"response": marks}, **{end: 0 * ends[end] - 1 for end in ends}})},
    )
