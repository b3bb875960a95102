# amaranth: UnusedElaboratable=no
"""Frame control of several pixels per clock: rows of whole beats, and lanes of the last one."""

from __future__ import annotations

import numpy as np
import pytest

from hdl.build import Build
from hdl.frame_control import FrameControl
from hdl.thresholds import settings_layout
from sim.stimulus import Stalls
from tests.support.beats import in_beats
from tests.support.blocks import NO_STALLS, Size, check_block, noise, raster

SETTINGS_BITS = settings_layout(Build.profile("paper", pixel_bits=4)).size


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.4, 0.4, 1)], ids=["unstalled", "stalled"])
@pytest.mark.parametrize("lanes", [2, 4, 8])
def test_any_width(lanes: int, stalls: Stalls) -> None:
    """Every remainder, the narrowest and the widest; out of range, the nearest that is allowed."""
    build = Build.profile("paper", pixel_bits=4, max_width=43, max_height=21, pixels_per_clock=lanes)
    assert build.min_width in (17, 19, 25)
    widths = [*range(build.min_width, build.min_width + lanes + 1), 43, 42, 0, build.min_width - 1, 44, 63]
    asked: list[Size] = [(15 + k % 3, width) for k, width in enumerate(widths)]
    sizes = [(height, min(max(width, build.min_width), 43)) for height, width in asked]
    frames, _ = in_beats(noise(sizes, 15), lanes, largest=15)
    latched = np.random.default_rng(1).integers(0, 1 << SETTINGS_BITS, len(asked)).tolist()
    levels, settings, start = [], [], 0
    for (height, width), (_, true_width), frame, word in zip(asked, sizes, frames, latched, strict=True):
        levels.append((start, {"width": width, "height": height, "next_settings": word}))
        # a frame is what it was with its first beat
        levels.append((start + 1, {"width": 30, "height": 17, "next_settings": word ^ 0x5555}))
        settings.append(word | true_width % lanes << SETTINGS_BITS)
        start += frame.shape[0] * frame.shape[1]

    beats = raster(frames)
    check_block(
        (FrameControl, build),
        {"i": beats["data"]},
        {"o": beats, "settings": np.array(settings, np.uint64)},
        stalls=stalls,
        levels=levels,
    )
