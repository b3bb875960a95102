# amaranth: UnusedElaboratable=no
"""Adaptive threshold: S less the weighted local level, with and without response filter."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from numpy.lib.stride_tricks import sliding_window_view

from golden.adaptive_threshold import adaptive_threshold, local_level, prominence
from golden.algorithm import ResponseFilter
from golden.parameters import Parameters
from golden.response_filter import response_filter
from hdl.adaptive_threshold import AdaptiveThreshold
from hdl.build import Build
from hdl.centre_rows import CentreRows
from hdl.response_filter import ResponseFilter as ResponseFilterBlock
from hdl.texture_filter import TextureFilter
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls, Stimulus
from tests.support.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    check_block,
    columns,
    engine,
    extremes,
    noise,
    packed,
    raster,
    same,
)

FILTERS: list[ResponseFilter] = ["none", "binomial"]
both = pytest.mark.parametrize("kind", FILTERS)


def built(kind: ResponseFilter, pixel_bits: int = 8) -> Parameters:
    return Build.profile(
        "paper", texture="mean", gradient="signed", response_filter=kind, pixel_bits=pixel_bits
    )


FULL = built("none").response_max


class InStep(wiring.Component):
    """The block as the detector feeds it: with the centres that come of the same columns."""

    def __init__(self, parameters: Parameters) -> None:
        self.block = AdaptiveThreshold(parameters)
        filtered = parameters.algorithm.response_filter == "binomial"
        self._centres = ResponseFilterBlock(parameters) if filtered else CentreRows(parameters)
        super().__init__(
            {
                "i": In(stream.Signature(self.block.i.payload.shape())),
                "thresholds": In(stream.Signature(self.block.thresholds.payload.shape())),
                "o": Out(stream.Signature(self.block.o.payload.shape())),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.block, m.submodules.centres = block, centres = self.block, self._centres
        wiring.connect(m, wiring.flipped(self.thresholds), block.thresholds)
        wiring.connect(m, block.o, wiring.flipped(self.o))
        m.d.comb += [
            self.i.ready.eq(block.i.ready),
            block.i.valid.eq(self.i.valid),
            block.i.payload.eq(self.i.payload),
            # in the detector thresholds are never late
            centres.i.valid.eq(self.i.valid & self.thresholds.valid),
            centres.i.payload.eq(self.i.payload),
        ]
        wiring.connect(m, centres.o, block.centres)
        return m


def peaks_and_windows(frame: Array, kind: ResponseFilter) -> tuple[Array, Array]:
    peaks = response_filter(frame)[3:-3, 3:-3] if kind == "binomial" else frame[4:-4, 4:-4]
    return peaks, sliding_window_view(frame, (9, 9))


def streams(
    kind: ResponseFilter, frames: list[Array], limits: list[tuple[int, int]]
) -> tuple[dict[str, Any], dict[str, Any]]:
    """``limits``: T1 and weight of each frame. Every other frame also reports what is rejected."""
    reported = [k % 2 for k in range(len(frames))]
    results = []
    for frame, (t1, weight), report in zip(frames, limits, reported, strict=True):
        accepted, response = adaptive_threshold(*peaks_and_windows(frame, kind), t1, weight)
        results.append(np.stack([~accepted, accepted | bool(report), response], axis=-1))
    t1s, weights = (np.array(values) for values in zip(*limits, strict=True))
    thresholds = {"t1": t1s, "t2": weights, "report_rejected": np.array(reported)}
    given = {"i": columns(frames, 9), "thresholds": thresholds}
    return given, {"o": raster(results, ("textured", "keep", "response"))}


def check(
    kind: ResponseFilter,
    frames: list[Array],
    limits: list[tuple[int, int]],
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    pixel_bits: int = 8,
) -> Capture:
    return check_block(
        (InStep, built(kind, pixel_bits)),
        *streams(kind, frames, limits),
        name,
        stalls,
        window=9,
        latency=AdaptiveThreshold.latency,
        held={"thresholds": "o"},
    )


def between(frame: Array, kind: ResponseFilter, weight: int) -> int:
    """T1 is a T from the middle of the frame's, so that the comparison is exact."""
    left = np.sort(prominence(*peaks_and_windows(frame, kind), weight), axis=None)
    return max(0, int(left[3 * len(left) // 4]))


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@both
def test_noise(kind: ResponseFilter, name: EngineName, stalls: Stalls) -> None:
    sizes = [(25, 30), (9, 9), (9, 40), (14, 9), (11, 17), (9, 9)]
    frames = noise(sizes if name == "compiled" else [(9, 9), (10, 13), (10, 9)], FULL)
    weights = [4, 0, 7, 1, 15, 2][: len(frames)]
    limits = [(between(frame, kind, weight), weight) for frame, weight in zip(frames, weights, strict=True)]
    check(kind, frames, limits, name, stalls)


@both
@pytest.mark.parametrize("weight", range(16))
def test_around_every_value_that_is_left(kind: ResponseFilter, weight: int) -> None:
    """T1 at each T of a small frame, and one below it: F is T > T1."""
    (frame,) = noise([(10, 11)], 4000, 1)
    left = np.unique(prominence(*peaks_and_windows(frame, kind), weight))
    t1 = sorted({0, *(int(value) for value in left if value >= 0), *(int(v) - 1 for v in left if v >= 1)})
    check(kind, [frame] * len(t1), [(value, weight) for value in t1])


@both
def test_every_place_of_the_window(kind: ResponseFilter) -> None:
    """A lone response in each of the 81 places counts once, also in neighbouring windows."""
    frames = []
    for place in range(81):
        lone = np.where(np.arange(81).reshape(9, 9) == place, FULL, 0)
        frames.append(np.pad(lone, ((0, 0), (2, 3))))
    assert {int(local_level(frame[:, 2:11])) for frame in frames} == {FULL // 64}
    check(kind, frames, [(place * 7, 1 + place % 15) for place in range(81)])


@both
@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
def test_extremes(kind: ResponseFilter, pixel_bits: int) -> None:
    full = built(kind, pixel_bits).response_max
    frames = [frame for frame in extremes((11, 18), full) for _ in range(4)]
    limits = [((0, 15), (full, 0), (full // 3, 4), (0, 1))[k % 4] for k in range(len(frames))]
    check(kind, frames, limits, pixel_bits=pixel_bits)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """1000 amid 5400: L = 100. A weight of 4 eighths leaves 950, which is not above 950."""
    frame = np.zeros((9, 9), np.int64)
    frame[4, 4], frame[0, 8] = 1000, 5400
    capture = check("none", [frame] * 4, [(950, 4), (950, 4), (949, 4), (999, 0)], name)
    words = capture.outputs["o"].astype(int)
    assert (words & 1).tolist() == [1, 1, 0, 0]
    assert (words >> 1 & 1).tolist() == [0, 1, 1, 1]
    assert (words >> 2 & 0x1FFFF).tolist() == [950, 950, 950, 1000]


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
@both
def test_each_result_has_its_own_frames_threshold(
    kind: ResponseFilter, name: EngineName, stalls: Stalls
) -> None:
    """Frames of one window, back to back: the next T1 and weight must not come too soon."""
    frames = noise([(9, 9)] * 12, FULL, 5)
    check(kind, frames, [(0, 0), (FULL, 0), (0, 15), (0, 1)] * 3, name, stalls)


@both
def test_reset_in_mid_window_leaves_nothing_of_what_was_before(kind: ResponseFilter) -> None:
    before, after = noise([(20, 21), (14, 15)], FULL, 6)
    block = InStep, built(kind)
    old = packed(block, streams(kind, [before], [(9, 4)])[0])
    new, expected = (packed(block, some) for some in streams(kind, [after], [(20_000, 4)]))
    for cut in (1, 9, 30, 100):
        beats = {
            "i": np.concatenate([old["i"][:cut], new["i"]]),
            # the first is on offer when reset comes, and lost
            "thresholds": np.concatenate([old["thresholds"], new["thresholds"]]),
        }
        stimulus = Stimulus(beats, [], NO_STALLS, reset_after=cut)
        words = engine("compiled", *block).run(stimulus, quiet=200).outputs["o"]
        same("o", words[len(words) - len(expected["o"]) :], expected["o"])


def test_latency() -> None:
    assert AdaptiveThreshold.latency == TextureFilter.latency == 5
