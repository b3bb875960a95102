# amaranth: UnusedElaboratable=no
"""The ring behind the queue of candidates: a window has its columns, however long it waits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.candidate_queue import CandidateQueue
from hdl.candidate_ring import CandidateRing, window_order
from hdl.sample import responses_shape
from sim.engine import Engine
from sim.stimulus import Stalls, Stimulus
from tests.support.blocks import engine, pack, unpack

SIZE = 9
"""Columns of a window."""


class Windows(wiring.Component):
    """Beats of one row of responses, with a mask of those that end a window."""

    def __init__(self, build: Build) -> None:
        self._build = build
        self._ring = CandidateRing(build, 1, SIZE, 0)
        given = {"columns": responses_shape(build), "mask": build.pixels_per_clock}
        super().__init__(
            {
                "i": In(stream.Signature(data.StructLayout(given))),
                "o": Out(stream.Signature(self._ring.o.payload.shape())),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.queue = queue = CandidateQueue(self._build)
        m.submodules.ring = ring = self._ring
        wiring.connect(m, queue.o, ring.i)
        wiring.connect(m, ring.o, wiring.flipped(self.o))
        m.d.comb += [
            self.i.ready.eq(queue.i.ready),
            queue.i.valid.eq(self.i.valid),
            queue.i.payload.mask.eq(self.i.payload.mask),
            ring.step.eq(self.i.valid & self.i.ready),
            ring.columns[0].eq(self.i.payload.columns),
            ring.waiting.eq(queue.waiting),
            queue.full.eq(ring.full),
        ]
        return m


@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_windows_that_wait_long(lanes: int) -> None:
    build = Build.profile("paper", pixel_bits=4, pixels_per_clock=lanes)
    check_windows(build, engine("amaranth", Windows, build))


def check_windows(build: Build, runner: Engine) -> None:
    """Sparse ones, so that the queue has room while beats come that would write over them."""
    lanes = build.pixels_per_clock
    rng = np.random.default_rng(lanes)
    count = 3 * build.ring_beats
    values = rng.integers(0, build.response_max, (count, lanes), endpoint=True)
    ends = rng.random((count, lanes)) < 1 / (40 * lanes)
    ends[: SIZE // lanes + 1] = False
    block = Windows(build)
    given = {"columns": {"response": values}, "mask": ends @ (1 << np.arange(lanes))}
    stimulus = Stimulus({"i": pack(block.i.payload.shape(), given)}, [], Stalls(0, 0.9, lanes))
    capture = runner.run(stimulus, quiet=500, max_clocks=200_000)
    seen = unpack(block.o.payload.shape(), capture.outputs["o"])["data"]["response"]
    found = seen.reshape(len(seen), build.window_reads)
    # one row: columns are numbered through all beats
    newest, order = np.flatnonzero(ends.reshape(-1)), np.array(window_order(build, SIZE))
    halves = order[:, None] + np.arange(build.window_reads) * (SIZE // 2)
    expected = values.reshape(-1)[newest[:, None, None] - (SIZE - 1) + halves]
    assert np.array_equal(found, expected.reshape(-1, build.window_reads))
    assert len(newest) > 10
