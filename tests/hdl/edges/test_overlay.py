# amaranth: UnusedElaboratable=no
"""The pixels passed on: the same, in place, with flags where the golden model has corners."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from golden import Parameters, Settings
from golden.preprocessing import Image
from golden.thresholds import thresholds
from golden.video import VideoSettings, framed
from hdl.build import Build
from hdl.edges.overlay import Overlay
from sim import Stalls, Stimulus
from sim.engine import Engine
from tests.hdl.edges.components import PlainVideoDetector, packets, payloads
from tests.support.accepted import accepted
from tests.support.blocks import engine
from tests.support.builds import each
from tests.support.filters import lenient, selective
from tests.support.malformed import random_video
from tests.support.photographs import photograph

MAX_WIDTH, MAX_HEIGHT = 150, 40
BUILDS = {
    "smoothed": Build.profile(
        "paper",
        max_width=MAX_WIDTH,
        max_height=MAX_HEIGHT,
        video_out=True,
        pixel_filter="twice",
        texture="none",
    ),
    "banked": Build.profile("paper", max_width=MAX_WIDTH, max_height=MAX_HEIGHT, video_out=True),
    "lean": Build.profile("robust", max_width=MAX_WIDTH, max_height=MAX_HEIGHT, video_out=True),
    "budget": Build.profile(
        "robust",
        response_filter="none",
        max_width=MAX_WIDTH,
        max_height=MAX_HEIGHT,
        video_out=True,
        budget=True,
        suppression=2,
    ),
}
builds = each("parameters", BUILDS, quick=("lean",))


def video_settings(parameters: Parameters, width: int, height: int, sigma2: float) -> VideoSettings:
    # a constant reference: what is flagged depends on the frame alone
    settings = Settings.default(
        parameters, sigma1=0.02, sigma2=sigma2, reference="constant", max_corners=4 * parameters.budget
    )
    return VideoSettings(width, height, settings)


def beats_of(image: Image, parameters: Parameters, settings: Settings) -> list[tuple[int, int, int, int]]:
    """(pixel, corner, sof, eol) as they must come out."""
    limits = thresholds(settings, settings.constant, parameters)
    corners = accepted(image, limits, parameters).ravel()
    if settings.max_corners:
        corners &= corners.cumsum() <= settings.max_corners
    return [
        (pixel, int(corner), int(sof), int(eol))
        for (pixel, sof, eol), corner in zip(framed(image), corners, strict=True)
    ]


def shown(words: np.ndarray) -> list[tuple[int, int, int, int]]:
    return [(w & 255, w >> 8 & 1, w >> 9 & 1, w >> 10 & 1) for w in words.tolist()]


def run(runner: Engine, parameters: Parameters, images: list[Image], stalls: Stalls) -> None:
    """Compare every pixel that comes out, and its flag."""
    changes, start, expected, edges = [], 0, [], 0
    for number, image in enumerate(images):
        sigma2 = selective(parameters) if number % 3 == 1 else lenient(parameters)
        video = video_settings(parameters, image.shape[1], image.shape[0], sigma2)
        changes.append((start, video.fixed(parameters)))
        beats = beats_of(image, parameters, video.settings)
        # a flag that waits for its pixel is the row's first, and must say that there is a corner
        edges += sum(corner for _, corner, _, _ in beats[parameters.algorithm.margin :: image.shape[1]])
        expected += beats
        start += image.size
    assert edges and sum(corner for _, corner, _, _ in expected) > (5 if parameters.budget else 20)
    words = payloads([beat for image in images for beat in framed(image)], parameters)
    capture = runner.run(Stimulus({"video": words}, changes, stalls), quiet=20 * parameters.max_width)
    assert shown(capture.outputs["overlay"]) == expected
    assert len(packets(capture)) == len(images)


@pytest.mark.parametrize("stalls", [Stalls(), Stalls(0.3, 0.3, 1), Stalls(0, 0.8, 2)], ids=str)
@builds
def test_pixels_and_corners(parameters: Parameters, stalls: Stalls) -> None:
    least = parameters.algorithm.support
    sizes = [(MAX_WIDTH, MAX_HEIGHT), (MAX_WIDTH, MAX_HEIGHT), (least, least), (least + 1, 40), (31, 17)]
    sizes.append((MAX_WIDTH, least))
    images = [photograph("grass")[k : k + h, 9 : 9 + w] for k, (w, h) in enumerate(sizes)]
    random = np.random.default_rng(0)
    images += [random.integers(0, 256, (MAX_HEIGHT, least + 2), np.uint8) for _ in range(12)]
    run(engine("compiled", PlainVideoDetector, parameters), parameters, images, stalls)


def test_pixels_and_corners_in_amaranths_simulator() -> None:
    """Nothing is compiled: it takes two seconds to tell what a change of the sources does."""
    parameters = Build.profile("paper", buffering="lean", max_width=40, max_height=20, video_out=True)
    random = np.random.default_rng(1)
    images = [random.integers(0, 256, (20, 40), np.uint8) for _ in range(4)]
    run(engine("amaranth", PlainVideoDetector, parameters), parameters, images, Stalls(0, 0.3, 1))


@builds
def test_full_rate_at_the_built_maximum(parameters: Parameters) -> None:
    """Neither input nor output ever waits: the overlay is deep enough."""
    runner = engine("compiled", PlainVideoDetector, parameters)
    images = [photograph(name)[:MAX_HEIGHT, :MAX_WIDTH] for name in ("camera", "brick", "grass")]
    video = video_settings(parameters, MAX_WIDTH, MAX_HEIGHT, lenient(parameters))
    words = payloads([beat for image in images for beat in framed(image)], parameters)
    capture = runner.run(
        Stimulus({"video": words}, [(0, video.fixed(parameters))]), quiet=20 * parameters.max_width
    )
    clocks = capture.input_clocks["video"]
    assert clocks[-1] - clocks[0] + 1 == len(clocks)
    assert len(capture.outputs["overlay"]) == len(words)


@pytest.mark.parametrize("stalls", [Stalls(), Stalls(0.3, 0.5, 3)], ids=str)
@builds
def test_malformed_video_comes_out_cut_and_then_exact(parameters: Parameters, stalls: Stalls) -> None:
    runner = engine("compiled", PlainVideoDetector, parameters)
    random = np.random.default_rng(4)
    width, height = 27, 24
    frames = random_video(random, 100, width, height)
    video = video_settings(parameters, width, height, lenient(parameters))
    beats = [beat for _, frame in frames.frames for beat in frame]
    stimulus = Stimulus({"video": payloads(beats, parameters)}, [(0, video.fixed(parameters))], stalls)
    capture = runner.run(stimulus, quiet=2000)
    got = shown(capture.outputs["overlay"])
    starts = [k for k, (_, _, sof, _) in enumerate(got) if sof] + [len(got)]
    seen = [tuple(got[a:b]) for a, b in pairwise(starts)]
    # every well-formed frame but one that was cut by a faulty beginning of the next comes out whole
    whole = [tuple(beats_of(image, parameters, video.settings)) for image, _ in frames.frames]
    sent = [frame == framed(image) for image, frame in frames.frames]
    assert all(frame in seen for frame, well in zip(whole[:-1], sent[:-1], strict=True) if well)
    # and of the others a beginning, with no pixel of another frame in it
    assert all(len(part) <= width * height for part in seen)


def test_memory() -> None:
    lean, banked = (Overlay(Build.profile("paper", buffering=b, video_out=True)) for b in ("lean", "banked"))
    assert (lean.depth, banked.depth) == (7 * 1920 + 128, 9 * 1920 + 128)
    assert lean.memory_bits == lean.depth * 9
    smoothed = {"pixel_filter": "twice", "texture": "none", "video_out": True}
    lean, banked = (Overlay(Build.profile("paper", buffering=b, **smoothed)) for b in ("lean", "banked"))
    assert (lean.depth, banked.depth) == (6 * 1920 + 128, 10 * 1920 + 128)
