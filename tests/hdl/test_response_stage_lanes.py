# amaranth: UnusedElaboratable=no
"""The response stage with several pixels per clock: frames of every width, back to back."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from golden.frame import response_map
from hdl.build import Build
from hdl.response_stage import ResponseStage
from sim.stimulus import Stalls
from tests.support.beats import in_beats
from tests.support.blocks import NO_STALLS, Array, engine, noise, pack, run, tags


def stage_build(profile: str, lanes: int, **changes: Any) -> Build:
    return Build.profile(profile, max_width=45, max_height=24, pixels_per_clock=lanes, **changes)


BUILDS = {
    "lean": stage_build("robust", 2),
    "without filters": stage_build("paper", 4),
    "filtered": stage_build("robust", 8, buffering="banked"),
    "10-bit pixels": stage_build("paper", 2, pixel_bits=10, gradient="signed", derivative="sobel"),
    "4-bit pixels": stage_build("robust", 4, pixel_bits=4, pixel_filter="twice", gradient="absolute"),
    "10-bit pixels, filtered": stage_build("robust", 4, pixel_bits=10),
}


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.3, 0.4, 13)], ids=["unstalled", "both-stall"])
@pytest.mark.parametrize(
    "build",
    [
        pytest.param(build, id=name, marks=[] if name == "lean" else [pytest.mark.verify])
        for name, build in BUILDS.items()
    ],
)
def test_frames(build: Build, stalls: Stalls) -> None:
    """The narrowest frame, every remainder of the width, the widest; what rides along with it."""
    lanes, narrowest, support = build.pixels_per_clock, build.min_width, build.algorithm.support
    widths = [narrowest, build.max_width, *range(narrowest, narrowest + lanes), build.max_width - 1]
    frames: list[Array] = noise(
        [(support + k % 3, width) for k, width in enumerate(widths)], build.pixel_max, dtype=np.uint16
    )
    lost = 2 * build.algorithm.response_margin
    responses = [response_map(frame, build).astype(np.int64) for frame in frames]
    beats, _ = in_beats(frames, lanes, largest=build.pixel_max)
    expected, counting = in_beats(responses, lanes, lost=lost, largest=0)

    stage = ResponseStage(build)
    sample, limit = stage.samples.payload.shape(), stage.limits.payload.shape()
    values = np.concatenate([frame.reshape(-1, lanes) for frame in expected])
    marks = np.concatenate([np.where(counts, -1, 0).reshape(-1, lanes) for counts in counting])
    ends = tags([frame.shape[:2] for frame in expected])
    last = np.array([width % lanes for width in widths])
    limits = {str(name): last if name == "last_lanes" else 0 * last for name, _ in limit}

    starts = np.cumsum([0, *(frame.shape[0] * frame.shape[1] for frame in beats)])
    levels = [
        (int(start), {"width": frame.shape[1], "height": frame.shape[0]})
        for start, frame in zip(starts, frames, strict=False)
    ]
    pixels = np.concatenate([frame.reshape(-1, lanes) for frame in beats])
    run(
        engine("compiled", ResponseStage, build),
        {"i": pack(stage.i.payload.shape(), pixels)},
        {
            "samples": pack(sample, {"data": {"response": values}, **ends}),
            "limits": pack(limit, limits),
        },
        stalls,
        levels=levels,
        counting={
            "samples": pack(
                sample, {"data": {"response": marks}, **{name: 0 * ends[name] - 1 for name in ends}}
            )
        },
    )
