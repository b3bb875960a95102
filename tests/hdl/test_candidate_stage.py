# amaranth: UnusedElaboratable=no
"""Middle stage with several pixels per clock: candidates of any responses, against golden."""

from __future__ import annotations

from functools import cache
from itertools import cycle
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from numpy.typing import NDArray

from golden import Settings
from golden.frame import Frame, History
from golden.subpixel import FITS
from golden.thresholds import Thresholds
from hdl.build import Build
from hdl.candidate_selection import pending_record_layout
from hdl.candidate_stage import CandidateStage
from hdl.fits import candidate_layout
from hdl.parts.nets import connect_by_name
from hdl.parts.stream import Beat
from hdl.sample import responses_shape
from hdl.surface import SURFACES
from hdl.thresholds import thresholds_layout
from sim.engine import Engine
from sim.engines import make_engine
from sim.stimulus import Stalls, Stimulus
from tests.support.blocks import NO_STALLS, pack, same, tags, unpack
from tests.support.builds import each
from tests.support.filters import selective

SMALL = {"max_width": 64, "max_height": 64}
BUILDS = {
    "paper": Build.profile("paper", **SMALL, buffering="lean"),
    "robust": Build.profile("robust", **SMALL),
    "mean, smoothed": Build.profile("robust", **SMALL, texture="mean"),
    "suppression 4": Build.profile("paper", **SMALL, texture="none", suppression=4, ties="first"),
    "suppression 3": Build.profile("paper", **SMALL, texture="mean", suppression=3, fit="six"),
    "suppression 2, banked": Build.profile(
        "paper", **SMALL, texture="none", suppression=2, buffering="banked", ties="first"
    ),
    "3x3": Build.profile("paper", **SMALL, texture="none", ties="first"),
    "3x3, smoothed": Build.profile("paper", **SMALL, texture="none", response_filter="binomial"),
}
# each number of lanes with different values of the other fields
EACH = {
    f"{name}, P={lanes}": build.changed(pixels_per_clock=lanes)
    for (name, build), lanes in zip(BUILDS.items(), cycle((4, 2, 8)), strict=False)
}
builds = each("build", EACH, quick=("robust, P=2", "3x3, smoothed, P=2", "suppression 2, banked, P=8"))
PATTERNS = {
    "unstalled": NO_STALLS,
    "both-stall": Stalls(0.3, 0.4, 13),
    "clogged": Stalls(outputs=0.9, seed=15),
}


class Held(wiring.Component):
    """The stage behind what thresholds do.

    A frame's first beat waits until the limits before have been taken, and limits for that beat.
    """

    def __init__(self, build: Build) -> None:
        self._stage = CandidateStage(build)
        super().__init__(dict(self._stage.signature.members.items()))

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.stage = stage = self._stage
        first, free, passes = Signal(init=1), Signal(init=1), Signal()
        connect_by_name(m, wiring.flipped(self), stage, names={"candidate", "pending", "largest"})
        m.d.comb += [
            passes.eq(~first | free),
            stage.samples.valid.eq(self.samples.valid & passes),
            stage.samples.payload.eq(self.samples.payload),
            self.samples.ready.eq(stage.samples.ready & passes),
            stage.limits.valid.eq(self.limits.valid & ~free),
            stage.limits.payload.eq(self.limits.payload),
            self.limits.ready.eq(stage.limits.ready & ~free),
        ]
        with m.If(self.samples.valid & self.samples.ready):
            m.d.sync += [first.eq(self.samples.payload.eof), free.eq(0)]
        with m.If(self.limits.valid & self.limits.ready):
            m.d.sync += free.eq(1)
        return m


@cache
def engine(build: Build) -> Engine:
    return make_engine("compiled", Held(build))


def frame_of(size: tuple[int, int], seed: int, build: Build) -> Frame:
    """Noise of few values, so that neighbours are often equal; every pixel is 0."""
    lost = 2 * build.algorithm.response_margin
    levels = np.linspace(0, build.response_max, 3 + 20 * (seed % 3), dtype=np.int32)
    responses = np.random.default_rng(seed).choice(levels, (size[0] - lost, size[1] - lost))
    settings = Settings.default(
        build, sigma1=(0.3, 0.0, 0.7)[seed % 3], sigma2=selective(build), report_rejected=seed % 2 == 0
    )
    return Frame(np.zeros(size, np.uint8), build, settings, responses)


def limits_of(frame: Frame) -> Thresholds:
    return frame.thresholds(History(frame.maximum))[1]


def beats_of(frame: Frame, lanes: int) -> tuple[NDArray[np.int64], tuple[int, int]]:
    """Responses by beats, (beats, lanes), what lies beside a row is noise; and beats by rows."""
    lost = 2 * frame.parameters.algorithm.response_margin
    height, width = frame.responses.shape
    first, after = lost // lanes, -(-(width + lost) // lanes)
    rng = np.random.default_rng(height * width)
    rows = rng.integers(0, frame.parameters.response_max, (height, (after - first) * lanes), endpoint=True)
    start = lost - first * lanes
    rows[:, start : start + width] = frame.responses
    return rows.reshape(-1, lanes), (height, after - first)


def check(build: Build, sizes: list[tuple[int, int]], stalls: Stalls, seed: int = 0) -> None:
    lanes = build.pixels_per_clock
    frames = [frame_of(size, seed + k, build) for k, size in enumerate(sizes)]
    limits = [limits_of(frame) for frame in frames]
    beats, rows = zip(*(beats_of(frame, lanes) for frame in frames), strict=True)
    shape = Beat(responses_shape(build))
    samples = pack(shape, {"data": {"response": np.concatenate(beats)}, **tags(list(rows))})
    given = {
        "t1": [limit.t1 for limit in limits],
        "t2": [limit.t2 for limit in limits],
        "report_rejected": [frame.settings.report_rejected for frame in frames],
        "last_lanes": [width % lanes for _, width in sizes],
    }
    if build.algorithm.texture == "none":
        given["t2"] = [0] * len(sizes)
    stimulus = Stimulus({"samples": samples, "limits": pack(thresholds_layout(build), given)}, [], stalls)
    capture = engine(build).run(stimulus, quiet=3000)
    pending = unpack(pending_record_layout(build), capture.outputs["pending"])
    corners = [frame.corners(limit) for frame, limit in zip(frames, limits, strict=True)]
    ends = np.cumsum([len(found.x) + 1 for found in corners]) - 1
    assert np.flatnonzero(pending["end"]).tolist() == ends.tolist()
    assert pending["response"][ends].tolist() == [frame.maximum for frame in frames]
    is_corner = pending["end"] == 0
    for field, values in {
        "x": [found.x for found in corners],
        "y": [found.y for found in corners],
        "response": [found.response for found in corners],
        "textured": [~found.accepted for found in corners],
    }.items():
        assert np.array_equal(pending[field][is_corner], np.concatenate(values)), field
    samples_of = [frame.surroundings(found)[0] for frame, found in zip(frames, corners, strict=True)]
    surfaces = FITS[build.algorithm.fit].derivatives(np.concatenate(samples_of).astype(np.int64))
    formats = SURFACES[build.algorithm.fit].formats
    expected = {
        name: value >> form.zeros
        for (name, value), form in zip(surfaces._asdict().items(), formats, strict=True)
    }
    same("candidate", capture.outputs["candidate"], pack(candidate_layout(build), expected))


@pytest.mark.parametrize("stalls", PATTERNS.values(), ids=PATTERNS)
@builds
def test_frames(build: Build, stalls: Stalls) -> None:
    """Sizes with every number of lanes in a row's last beat, back to back with others."""
    lanes = build.pixels_per_clock
    least, high = build.min_width, build.algorithm.support
    sizes = [(high, least), *((high + 3 + k, least + 5 + k) for k in range(lanes)), (high, 64), (40, 61)]
    check(build, sizes, stalls)
