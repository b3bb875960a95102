"""Random video, well-formed and not, one frame at a time: for test benches of the core's edges."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from golden.preprocessing import Image
from golden.video import Lanes, VideoBeat, framed

Beats = list[VideoBeat]
"""(pixel, start of frame, end of line), or with the pixels of a beat in place of one."""

Given = Sequence[VideoBeat]

Random = np.random.Generator


def whole(beats: Given, width: int, random: Random) -> Beats:
    return list(beats)


def early_sof(beats: Given, width: int, random: Random) -> Beats:
    """Ends anywhere; whatever comes next begins with its start of frame."""
    return list(beats[: int(random.integers(8, len(beats)))])


def late_sof(beats: Given, width: int, random: Random) -> Beats:
    """Goes on for some pixels or lines, with ends of line or not."""
    surplus = int(random.choice([1, 2, width - 1, width, 3 * width, len(beats) - 1]))
    ends = bool(random.integers(2))
    first = beats[0][0]
    return [*beats, *((first, False, ends and k % width == width - 1) for k in range(surplus))]


def missing_sof(beats: Given, width: int, random: Random) -> Beats:
    return [(pixel, False, eol) for pixel, _, eol in beats]


def short_line(beats: Given, width: int, random: Random) -> Beats:
    row = int(random.integers(len(beats) // width))
    gone = int(random.integers(1, width))
    end = row * width + width
    before = beats[: end - gone]
    pixel, sof, _ = before[-1]
    return [*before[:-1], (pixel, sof, True), *beats[end:]]


def long_line(beats: Given, width: int, random: Random) -> Beats:
    end = (int(random.integers(len(beats) // width)) + 1) * width
    surplus = int(random.choice([1, 2, width - 1, width, 2 * width + 1]))
    pixel, sof, _ = beats[end - 1]
    extra = [(beats[0][0], False, k == surplus - 1) for k in range(surplus)]
    return [*beats[: end - 1], (pixel, sof, False), *extra, *beats[end:]]


def lost_eol(beats: Given, width: int, random: Random) -> Beats:
    """One line runs into the next."""
    end = (int(random.integers(len(beats) // width)) + 1) * width
    pixel, sof, _ = beats[end - 1]
    return [*beats[: end - 1], (pixel, sof, False), *beats[end:]]


def no_eol(beats: Given, width: int, random: Random) -> Beats:
    return [(pixel, sof, False) for pixel, sof, _ in beats]


def sof_always(beats: Given, width: int, random: Random) -> Beats:
    """Start of frame held for a few pixels of the first line."""
    held = int(random.integers(2, min(6, width)))
    return [(pixel, sof or k < held, eol) for k, (pixel, sof, eol) in enumerate(beats)]


def noise_marks(beats: Given, width: int, random: Random) -> Beats:
    """Starts of frame and ends of line anywhere."""
    sofs, eols = random.random(len(beats)) < 0.003, random.random(len(beats)) < 0.02
    return [(pixel, bool(s), bool(e)) for (pixel, _, _), s, e in zip(beats, sofs, eols, strict=True)]


Fault = Callable[[Given, int, Random], Beats]
"""Of a frame's beats, with so many in a line."""
FAULTS: dict[str, Fault] = {
    fault.__name__: fault
    for fault in (
        early_sof,
        late_sof,
        missing_sof,
        short_line,
        long_line,
        lost_eol,
        no_eol,
        sof_always,
        noise_marks,
    )
}


def packed(beats: Given, lanes: int) -> Beats:
    """Several pixels to a beat; a start of frame begins one, and an end of line ends one."""
    if lanes == 1:
        return list(beats)
    groups: list[list[VideoBeat]] = []
    for pixel, sof, eol in beats:
        full = not groups or len(groups[-1]) == lanes or groups[-1][-1][2]
        if full or sof:
            groups.append([])
        groups[-1].append((pixel, sof, eol))
    return [
        (
            (*(pixel for pixels, _, _ in group for pixel in places(pixels)), *[None] * (lanes - len(group))),
            group[0][1],
            group[-1][2],
        )
        for group in groups
    ]


def places(pixels: int | Lanes) -> Lanes:
    """The places of a beat."""
    return pixels if isinstance(pixels, tuple) else (pixels,)


def by_beats(fault: Fault, image: Image, lanes: int, random: Random) -> Beats:
    """A frame with a fault that moves whole beats."""
    return fault(packed(framed(image), lanes), -(-image.shape[1] // lanes), random)


def by_pixels(fault: Fault, image: Image, lanes: int, random: Random) -> Beats:
    """A frame with a fault that moves pixels, which can be less than a beat."""
    return packed(fault(framed(image), image.shape[1], random), lanes)


def hollow(beats: Given, random: Random, most: int = 1) -> Beats:
    """Some of the beats lack some of their pixels, or have more than they should."""
    beats = list(beats)
    for _ in range(int(random.integers(1, most + 1))):
        place = int(random.integers(len(beats)))
        pixels, sof, eol = beats[place]
        kept = random.integers(2, size=len(places(pixels)))
        beats[place] = (tuple(9 if k else None for k in kept), sof, eol)
    return beats


@dataclass
class Video:
    """Frames to send, and a count of what was tried."""

    frames: list[tuple[Image, Beats]] = field(default_factory=list)
    tried: Counter[str] = field(default_factory=Counter)

    def add(self, image: Image, fault: Fault, random: Random, lanes: int = 1) -> None:
        """One more frame; with several pixels per clock its fault moves beats, or pixels."""
        mar = by_pixels if lanes > 1 and random.integers(2) else by_beats
        self.frames.append((image, mar(fault, image, lanes, random)))
        self.tried["well-formed" if fault is whole else fault.__name__.replace("_", " ")] += 1


def texture(random: Random, width: int, height: int) -> Image:
    """An image with corners: blocks, some noise, or the darkest there is."""
    kind = random.integers(4)
    if kind == 0:
        return np.full((height, width), random.integers(256), np.uint8)
    if kind == 1:
        return random.integers(0, 256, (height, width), dtype=np.uint8)
    side = int(random.integers(3, 9))
    blocks = random.integers(0, 256, (height // side + 1, width // side + 1), dtype=np.uint8)
    return np.kron(blocks, np.ones((side, side), np.uint8))[:height, :width]


def random_video(
    random: Random, frames: int, width: int, height: int, *, malformed: float = 0.5, lanes: int = 1
) -> Video:
    """Frames of one size, some of them malformed."""
    video = Video()
    names = list(FAULTS)
    while len(video.frames) < frames:
        fault = whole
        if video.frames and random.random() < malformed:
            fault = FAULTS[names[int(random.integers(len(names)))]]
        video.add(texture(random, width, height), fault, random, lanes)
    return video
