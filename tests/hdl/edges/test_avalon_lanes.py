# amaranth: UnusedElaboratable=no
"""Avalon edges with several pixels per clock: lines of any width, among other packets or cut."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from golden import Settings
from golden.preprocessing import Image
from golden.video import Lanes, VideoModel, VideoSettings
from hdl.build import Build
from sim import Stalls, Stimulus
from tests.hdl.edges.components import PlainAvalonCore, packets
from tests.support.beats import in_words
from tests.support.blocks import NO_STALLS, engine
from tests.support.builds import each
from tests.support.malformed import Beats
from tests.support.photographs import photograph

HEIGHT = 24
BUILDS = {
    f"{profile}-{lanes}": Build.profile(
        profile,
        pixels_per_clock=lanes,
        buffering="lean",
        max_width=16 * lanes + lanes // 2,
        max_height=HEIGHT,
        autostart=True,
    )
    for profile, lanes in (("robust", 2), ("paper", 4), ("robust", 8))
}
builds = each("build", BUILDS, quick=("robust-2",))
STALLS = pytest.mark.parametrize("stalls", [Stalls(), Stalls(0.4, 0.4, 1)], ids=["flowing", "both stall"])


def images(build: Build) -> list[Image]:
    """As wide as can be: half of a line's last beat is left over."""
    return [
        photograph(name)[50 : 50 + HEIGHT, 80 : 80 + build.max_width]
        for name in ("brick", "grass", "text", "coins")
    ]


def frame(build: Build, image: Image, random: np.random.Generator, empty: int | None = None) -> Beats:
    """What a frame's packet holds: places left over at the ends of lines have anything in them.

    Those of the last line, or ``empty`` of them, are empty.
    """
    lanes, (height, width) = build.pixels_per_clock, image.shape
    left = -width % lanes
    rows = np.concatenate([image, random.integers(0, 256, (height, left), np.uint8)], axis=1)
    beats: Beats = [(tuple(beat), k == 0, False) for k, beat in enumerate(rows.reshape(-1, lanes).tolist())]
    there = lanes - (left if empty is None else empty)
    pixels, sof, eol = beats[-1]
    assert isinstance(pixels, tuple)
    beats[-1] = ((*pixels[:there], *[None] * (lanes - there)), sof, eol)
    return beats


def packet(build: Build, beats: list[Lanes], random: np.random.Generator) -> list[int]:
    """Payloads of a packet: its first symbol is in the highest bits, and its end has ``empty``."""
    lanes, last = build.pixels_per_clock, len(beats) - 1
    words = []
    for k, pixels in enumerate(beats):
        data = sum((pixel or 0) << 8 * (lanes - 1 - lane) for lane, pixel in enumerate(pixels))
        empty = pixels.count(None) if k == last else int(random.integers(lanes))
        tags = empty | ((k == 0) | (k == last) << 1) << lanes.bit_length() - 1
        words.append(data | tags << 8 * lanes)
    return words


def video_packet(build: Build, beats: Beats, random: np.random.Generator, kind: int = 0) -> list[int]:
    """A frame's packet: its type is told in the first symbol of a beat of its own."""
    head = (kind, *random.integers(0, 256, build.pixels_per_clock - 1).tolist())
    return packet(build, [head, *(pixels for pixels, _, _ in beats)], random)


def run(build: Build, words: list[int], frames: list[Beats], stalls: Stalls = NO_STALLS) -> list[Any]:
    """Compare what comes of these payloads with what the model makes of these frames."""
    model = VideoModel(build, build.pixels_per_clock)
    video = VideoSettings(build.max_width, HEIGHT, Settings.default(build), ignore_eol=True)
    expected = [packet for frame in frames for packet in model.feed(frame, video)]
    stimulus = Stimulus({"video": in_words(words)}, [], stalls)
    capture = engine("compiled", PlainAvalonCore, build).run(stimulus, quiet=2000)
    got = packets(capture)
    assert len(got) == len(expected)
    for one, records in zip(expected, got, strict=True):
        assert one.matches(records)
    starts = capture.outputs["starts"].tolist()
    assert starts == [int(k == 0) for records in got for k in range(len(records))]
    return expected


@STALLS
@builds
def test_frames_among_other_packets(build: Build, stalls: Stalls) -> None:
    random, lanes = np.random.default_rng(1), build.pixels_per_clock
    frames = [frame(build, image, random) for image in images(build)]
    words: list[int] = []
    for number, beats in enumerate(frames):
        # of control, of users, and of a type that only looks like a frame's in another place
        for kind in (0xF, 4, 1):
            words += packet(build, [(kind, *[0] * (lanes - 1)), (0,) * lanes], random)
        words += video_packet(build, beats, random, 0xA0 if number == 2 else 0)
    expected = run(build, words, frames, stalls)
    assert len(expected) == 4 and all(len(each.records) > 1 for each in expected)


@builds
def test_packets_of_another_length(build: Build) -> None:
    """One lacks beats, one a pixel; one has a pixel more, one has more beats."""
    random, lanes = np.random.default_rng(2), build.pixels_per_clock
    first, second, third, fourth = images(build)
    left = -build.max_width % lanes
    lacking = min(left + 1, lanes - 1)
    frames = [
        frame(build, first, random)[:30],
        frame(build, second, random),
        frame(build, third, random, empty=left - 1),
        [*frame(build, fourth, random), *[((9,) * lanes, False, False)] * 5],
        frame(build, first, random, empty=lacking),
        frame(build, second, random),
    ]
    words = [word for beats in frames for word in video_packet(build, beats, random)]
    expected = run(build, words, frames)
    # where a line's last beat has one pixel only, it cannot be taken for a shorter one
    assert [each.cut for each in expected] == [True, False, False, False, lacking > left, False]


@builds
def test_a_beat_per_clock(build: Build) -> None:
    random = np.random.default_rng(3)
    frames = [frame(build, image, random) for image in images(build)]
    words = [word for beats in frames for word in video_packet(build, beats, random)]
    stimulus = Stimulus({"video": in_words(words)}, [], Stalls())
    clocks = engine("compiled", PlainAvalonCore, build).run(stimulus, quiet=2000).input_clocks["video"]
    assert clocks[-1] - clocks[0] + 1 == len(words) == 4 * (build.beats * HEIGHT + 1)
