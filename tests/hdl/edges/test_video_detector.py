"""The guarded detector against its golden model: any video, any stalls, every well-formed frame exact."""

from __future__ import annotations

import numpy as np
import pytest

from golden import Parameters, Settings, profile
from golden.video import VideoModel, VideoSettings
from sim import Stalls, Stimulus, make_engine
from tests.hdl.edges.components import PlainVideoDetector, levels, packets, payloads
from tests.malformed import random_video

BUILDS = {
    f"{name}-{buffering}": profile(name, buffering=buffering, max_width=40, max_height=32)
    for name in ("paper", "robust")
    for buffering in ("banked", "lean")
}


@pytest.mark.parametrize(
    "stalls", [Stalls(), Stalls(0.4, 0.4, 1), Stalls(0, 0.7, 2), Stalls(0.7, 0, 3)], ids=str
)
@pytest.mark.parametrize("parameters", BUILDS.values(), ids=BUILDS.keys())
def test_malformed_video(parameters: Parameters, stalls: Stalls) -> None:
    engine = make_engine("compiled", PlainVideoDetector(parameters))
    for seed in range(3):
        random = np.random.default_rng(seed)
        width, height = int(random.integers(15, 41)), int(random.integers(15, 33))
        video = VideoSettings(width, height, Settings.default(parameters, sigma1=0.02, sigma2=2.0))
        frames = random_video(random, 128, width, height)
        model = VideoModel(parameters)
        beats = [beat for _, frame in frames.frames for beat in frame]
        expected = model.feed(beats, video)
        capture = engine.run(
            Stimulus({"video": payloads(beats, parameters)}, [(0, levels(video))], stalls), quiet=2000
        )
        got = packets(capture)
        print(frames.tried, len(got), len(expected), sum(not p.cut for p in expected))
        for k, (packet, words) in enumerate(zip(expected, got, strict=False)):
            assert packet.matches(words), (k, packet.cut, packet.records, words)
        assert len(got) - len(expected) in (0, 1)
