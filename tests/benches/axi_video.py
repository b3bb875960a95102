"""The core's optional video output: pixels as they went in, with flags at corners.

Corners are computed here from the golden model's blocks, not from its records: those are refined,
and tell the whole pixel no more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from golden.frame import Frame, History
from golden.video import Packet, VideoModel, VideoSettings
from hdl.build import Build
from tests.benches.common import Sink
from tests.support.accepted import accepted
from tests.support.malformed import Beats

_SOF, _CORNER = 1, 2


@dataclass(frozen=True)
class Shown:
    """A frame at the output: beats ``(pixels, TUSER, TLAST, TKEEP)``.

    A cut frame has some number of the first beats.
    """

    beats: NDArray[np.object_]
    cut: bool

    def matches(self, beats: NDArray[np.object_]) -> bool:
        if not self.cut:
            return np.array_equal(beats, self.beats)
        return np.array_equal(beats, self.beats[: len(beats)])


class VideoExpectation:
    """Follows the golden model, and knows what is shown of each of its frames.

    Members
    -------
    pieces
        Cut frames of which something was shown, by the last check.
    """

    def __init__(self, parameters: Build) -> None:
        self._parameters = parameters
        self.pieces = 0
        self.reset()

    def reset(self) -> None:
        self.expected: list[Shown] = []
        self._history = History()
        self._begun: VideoSettings | None = None

    def interrupt(self, begun: int | None = None) -> None:
        """After a soft reset earlier frames may be incomplete; the next frame is the first."""
        before = [replace(shown, cut=True) for shown in self.expected[:begun]]
        self.reset()
        self.expected = before

    def feed(self, model: VideoModel, beats: Beats, video: VideoSettings) -> list[Packet]:
        """Feeds the model; its packets."""
        if not model.active:
            self._begun = None
        packets = model.feed(beats, video)
        for packet in packets if self._parameters.video_out else ():
            self.expected.append(self._shown(packet, self._begun or video))
            self._begun = None
        if model.active and self._begun is None:
            self._begun = video
        return packets

    def _shown(self, packet: Packet, video: VideoSettings) -> Shown:
        pixels = packet.pixels.reshape(-1)
        image = np.zeros(video.width * video.height, pixels.dtype)
        image[: len(pixels)] = pixels
        image = image.reshape(video.height, video.width)
        frame, settings = Frame(image, self._parameters, video.settings), video.settings
        _, limits = frame.thresholds(self._history)
        if not packet.cut:
            self._history = frame.next_history(limits, self._history)
        marked = accepted(image, limits, self._parameters)
        if settings.max_corners and not settings.per_cell:
            marked &= marked.cumsum().reshape(marked.shape) <= settings.max_corners
        lanes, bits = self._parameters.pixels_per_clock, self._parameters.pixel_bits
        beats = in_beats(image, lanes) @ (1 << np.arange(lanes, dtype=object) * bits)
        corners = in_beats(marked, lanes) @ (1 << np.arange(lanes))
        per_row = -(-video.width // lanes)
        place = np.arange(per_row * video.height)
        last = place % per_row == per_row - 1
        kept = np.where(last, video.width - (per_row - 1) * lanes, lanes) * bits
        keep = (1 << -(-kept // 8)) - 1 if lanes > 1 else np.zeros_like(kept)
        user = _SOF * (place == 0) + _CORNER * corners
        # what came of a cut frame are whole beats
        rows, rest = divmod(len(pixels), video.width)
        return Shown(
            np.stack([beats, user, last, keep], axis=1)[: rows * per_row + -(-rest // lanes)], packet.cut
        )

    def check(self, sink: Sink) -> None:
        """AssertionError unless all that is expected has come, and nothing else."""
        frames = received(sink, self._parameters)
        self.pieces = len(frames) - sum(not shown.cut for shown in self.expected)
        for k, shown in enumerate(self.expected):
            if shown.cut and not (frames and shown.matches(frames[0])):
                # cut before anything of it was shown
                continue
            assert frames, f"video out: frame {k} of {len(self.expected)} is missing"
            frame = frames.pop(0)
            assert shown.matches(frame), (
                f"video out: frame {k} of {len(self.expected)}: {_differ(frame, shown)}"
            )
        assert not frames, f"video out: {len(frames)} frames too many"
        self.expected.clear()


def in_beats(image: NDArray[np.generic], lanes: int) -> NDArray[np.int64]:
    """(beats, lanes): the values of an image, with 0 where a line's last beat has none."""
    padded = np.pad(image, ((0, 0), (0, -image.shape[1] % lanes)))
    return padded.reshape(-1, lanes).astype(np.int64)


def received(sink: Sink, parameters: Build) -> list[NDArray[np.object_]]:
    """Beats that have come out, frame by frame, each up to the next start of frame.

    Pixels that are not there are 0.
    """
    several, bits = parameters.pixels_per_clock > 1, parameters.pixel_bits
    beats: list[tuple[int, int, bool, int]] = []
    for line in sink.packets():
        last = len(line.data) - 1
        for k, (pixels, user) in enumerate(zip(line.data, line.user, strict=True)):
            keep = line.keep[k] if several else 0
            there = keep.bit_length() * 8 // bits * bits
            beats.append((pixels & (1 << there) - 1 if several else pixels, user, k == last, keep))
    everything = np.array(beats, object).reshape(-1, 4)
    starts = np.flatnonzero(everything[:, 1].astype(int) & _SOF)
    assert not len(beats) or (len(starts) and starts[0] == 0), "video out: pixels without a start of frame"
    return np.split(everything, starts[1:]) if len(beats) else []


def _differ(frame: NDArray[np.int64], shown: Shown) -> str:
    common = min(len(frame), len(shown.beats))
    places = np.flatnonzero((frame[:common] != shown.beats[:common]).any(axis=1))
    if not len(places):
        return f"{len(frame)} beats instead of {len(shown.beats)}"
    first = places[0]
    return f"{len(places)} beats differ, first {first}: {frame[first]} instead of {shown.beats[first]}"
