"""Video as it arrives at the edge of the core, well-formed or not, and what becomes of it.

A pixel travels with its framing: start of frame and end of line (AMD UG934). The detector behind
the edge only ever sees whole frames of the size that was set, from the first pixel to the last.
This is the specification of how any stream of framed pixels becomes such frames, of what is
reported about the rest, and of the packets that come out.

============================  ====================================================================
what comes in                 what becomes of it
============================  ====================================================================
start of frame before the     The frame is cut: it is closed without its remaining corners, and
end of the frame              flagged. The new one begins at once.
pixels after a frame's last   They are dropped, up to the next start of frame.
end of line too early         The frame is cut, and what follows is dropped up to the next start of
                              frame: no corner could have its support in whole rows before as many
                              further rows have come.
end of line too late          The surplus is dropped, up to the end of line; the frame goes on.
============================  ====================================================================

With several pixels per clock a beat holds as many places for pixels, *lanes*, and a line is a whole
number of beats; lanes may be empty. The lanes of a line's last beat that the width leaves over are
not looked at, except that pixels in them make the line too long. An empty lane anywhere else, also
in the middle of a line, makes it too short. All that is dropped is counted in beats.

A cut frame leaves nothing behind: the next frame's reference, and the corners that its T1 is
adapted to, are those of the last *complete* frame.

A frame's time is the clock in which the input took its first pixel, whatever became of the frame.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from enum import IntFlag
from itertools import chain

import numpy as np

from golden.checks import check_integer, check_type
from golden.corners import ByValue
from golden.detector import StreamModel, pixel_dtype
from golden.output_constructor import NO_LIMIT, FrameEnd, Records, encode_frame_end, encode_frame_time
from golden.parameters import Parameters
from golden.preprocessing import Image
from golden.settings import Settings

Lanes = tuple[int | None, ...]
"""The pixels of a beat, the first of them first; None where there is none."""
VideoBeat = tuple[int | Lanes, bool, bool]
"""Pixel or lanes; start of frame, with its first pixel; end of line, with its last."""


class Event(IntFlag):
    """What can happen to a stream of video; the bits of the status register."""

    FRAME_DONE = 1 << 0
    """A complete frame's end has been delivered."""
    FRAME_CUT = 1 << 1
    """The end of a cut frame has been delivered."""
    SOF_EARLY = 1 << 2
    """A frame began before the one before it was complete; that one is cut."""
    SOF_LATE = 1 << 3
    """Pixels came after a frame's last and before the next start of frame; they were dropped."""
    SOF_MISSING = 1 << 4
    """A whole frame's pixels came without a start of frame; they were dropped."""
    EOL_EARLY = 1 << 5
    """A line was too short; its frame is cut."""
    EOL_LATE = 1 << 6
    """A line was too long; the surplus was dropped."""
    EOL_MISSING = 1 << 7
    """A whole further line's pixels came without an end of line; they were dropped."""
    RECORDS_DROPPED = 1 << 8
    """A frame had more corners than cells, ``Settings.max_corners`` or ``max_records`` allow."""
    SIZE_CHANGED = 1 << 9
    """The frame size was set while a frame was under way; the old size holds for that frame."""
    SIZE_REFUSED = 1 << 10
    """A size of frame or cells out of range, or a part of one, was written; the old one stays."""
    INPUT_IDLE = 1 << 11
    """No pixel has come for too long in the middle of a frame."""
    OUTPUT_STALLED = 1 << 12
    """An output has waited too long to be taken."""


@dataclass(frozen=True)
class VideoSettings:
    """What can be set at run time at the edge of the core; it is latched at each start of frame.

    Parameters
    ----------
    width, height
        Frame size, from ``Algorithm.support`` either way up to the built maximum.
    settings
        Thresholds.
    enabled
        False: frames that start are dropped.
    ignore_eol
        True: lines are told apart by counting pixels, and ends of line mean nothing.
    max_records
        Largest number of corners reported per frame; the others are dropped. It holds at once, not
        from the next frame on.
    send_time
        True: a time record follows each end-of-frame record. It holds at once, too.
    """

    width: int
    height: int
    settings: Settings
    enabled: bool = True
    ignore_eol: bool = False
    max_records: int = NO_LIMIT
    send_time: bool = False

    def check(self, parameters: Parameters) -> None:
        """Raise ``TypeError`` or ``ValueError`` if this detector cannot have these settings."""
        check_type("parameters", parameters, Parameters)
        least = parameters.algorithm.support
        check_integer("width", self.width, least, parameters.max_width)
        check_integer("height", self.height, least, parameters.max_height)
        check_integer("max_records", self.max_records, 0, NO_LIMIT)
        check_type("enabled", self.enabled, bool)
        check_type("ignore_eol", self.ignore_eol, bool)
        check_type("send_time", self.send_time, bool)
        check_type("settings", self.settings, Settings)
        self.settings.check(parameters)

    def fixed(self, parameters: Parameters) -> dict[str, int]:
        """The settings as the hardware takes them: whole numbers by the names of its inputs."""
        return {
            "enable": int(self.enabled),
            "ignore_eol": int(self.ignore_eol),
            "width": self.width,
            "height": self.height,
            "max_records": self.max_records,
            "send_time": int(self.send_time),
            **self.settings.fixed(parameters),
        }


@dataclass(frozen=True, eq=False)
class Packet(ByValue):
    """The records of one frame.

    Parameters
    ----------
    records
        (n,) uint64. A complete frame has all its records here, with the end-of-frame record. A cut
        frame has those of the corners whose support had come when it was cut, and no end: the
        hardware delivers some number of the first of them, and then an end-of-frame record. A time
        record is not among them.
    frame, cut
        As in the end-of-frame record.
    found
        Number of corners of a complete frame, with those that either limit left out; 0 if it was
        cut.
    pixels
        The pixels of the frame that came: (height, width) of a complete frame, (n,) of a cut one.
    begun
        Number of beats since reset before its first pixel. The clock in which the input takes that
        one is the frame's time.
    timed
        A time record follows.
    """

    records: Records
    frame: int
    cut: bool
    found: int
    pixels: Image = field(repr=False)
    begun: int
    timed: bool

    def matches(self, words: Records, clock: int | None = None) -> bool:
        """May the hardware deliver these words for this frame, which began in that clock?

        Only a packet that is ``timed`` depends on the clock.
        """
        if self.timed:
            if not len(words) or clock is None or int(words[-1]) != encode_frame_time(clock):
                return False
            words = words[:-1]
        if not self.cut:
            return np.array_equal(words, self.records)
        count = len(words) - 1
        end = encode_frame_end(FrameEnd(count, self.frame, 0, cut=True))
        return (
            0 <= count <= len(self.records)
            and int(words[-1]) == end
            and np.array_equal(words[:-1], self.records[:count])
        )


class VideoModel:
    """The detector with its edges, fed beat by beat.

    Parameters
    ----------
    parameters
        The detector; ``TypeError`` if it is none.
    pixels_per_clock
        Lanes of a beat.

    Attributes
    ----------
    events
        What has happened since reset, except for what depends on time or on writes of registers:
        ``SIZE_CHANGED`` and all events after it.
    dropped_records
        Number of corners since reset that cells, ``max_corners`` or ``max_records`` left out.
    """

    def __init__(self, parameters: Parameters, pixels_per_clock: int = 1) -> None:
        check_type("parameters", parameters, Parameters)
        self.parameters = parameters
        self._lanes = pixels_per_clock
        self._stream = StreamModel(parameters)
        self.reset()

    def reset(self) -> None:
        """Return to the state after power-on."""
        self.events = Event(0)
        self.dropped_records = 0
        self._stream.reset()
        self._now: VideoSettings | None = None
        self._beats = self._begun = 0
        self._pixels: list[int] = []
        self._x = 0
        # is a line's surplus being dropped; has a complete frame gone before; beats dropped since
        self._surplus = self._after = False
        self._dropped = 0

    @property
    def active(self) -> bool:
        """Is a frame under way?"""
        return self._now is not None

    @property
    def adapted(self) -> int | None:
        """The D that the last complete frame's target or rank asks for; None if it had neither."""
        return self._stream.history.adapted

    def feed(self, beats: Iterable[VideoBeat], video: VideoSettings) -> list[Packet]:
        """Packets of the frames that end with these beats.

        Parameters
        ----------
        beats
            ``(pixel, start of frame, end of line)`` each; a tuple of pixels with several per clock.
        video
            Settings while these beats come.

        Raises
        ------
        TypeError, ValueError
            This detector cannot have such settings, or cannot take one of the pixels; no beat has
            been taken.
        """
        check_type("video", video, VideoSettings)
        video.check(self.parameters)
        lanes = [(given if isinstance(given, tuple) else (given,), sof, eol) for given, sof, eol in beats]
        for pixels, _, _ in lanes:
            check_integer("number of pixels in a beat", len(pixels), self._lanes, self._lanes)
        together = chain.from_iterable(pixels for pixels, _, _ in lanes)
        self._check_pixels([pixel for pixel in together if pixel is not None])
        packets = []
        for beat in lanes:
            packets += self._feed(*beat, video)
            self._beats += 1
        return [replace(packet, timed=video.send_time) for packet in packets]

    def _check_pixels(self, pixels: list[int]) -> None:
        largest = self.parameters.pixel_max
        together = np.array(pixels)
        if together.dtype.kind in "iu" and together.min() >= 0 and together.max() <= largest:
            return
        # one by one, only to name the one that is wrong
        for pixel in pixels:
            check_integer("pixel", pixel, 0, largest)

    def _feed(self, pixels: Lanes, sof: bool, eol: bool, video: VideoSettings) -> list[Packet]:
        packets = []
        if self._now is not None and sof:
            self.events |= Event.SOF_EARLY
            packets.append(self._cut(self._now))
        if self._now is not None:
            return packets + self._inside(pixels, eol, self._now)
        if not sof or not video.enabled:
            self._between(eol, video)
            return packets
        self._now, self._begun = video, self._beats
        self._pixels, self._x = [], 0
        self._surplus = self._after = False
        return packets + self._inside(pixels, eol, video)

    def _inside(self, pixels: Lanes, eol: bool, now: VideoSettings) -> list[Packet]:
        if self._surplus:
            self._beyond_line(eol, now)
            return []
        last = self._x == self._beats_of(now) - 1
        counting = self._lanes_left(now) if last else self._lanes
        inside = [pixel for pixel in pixels[:counting] if pixel is not None]
        if len(inside) < counting or (eol and not last and not now.ignore_eol):
            self.events |= Event.EOL_EARLY
            return [self._cut(now)]
        self._pixels += inside
        self._x = 0 if last else self._x + 1
        beyond = any(pixel is not None for pixel in pixels[counting:])
        if last and (beyond or not eol) and not now.ignore_eol:
            self.events |= Event.EOL_LATE
            self._surplus = not eol
        if len(self._pixels) < now.width * now.height:
            return []
        self._after, self._dropped = True, 0
        return [self._complete(now)]

    def _beats_of(self, now: VideoSettings) -> int:
        """Beats of a line."""
        return -(-now.width // self._lanes)

    def _lanes_left(self, now: VideoSettings) -> int:
        """Lanes of a line's last beat that count."""
        return (now.width - 1) % self._lanes + 1

    def _between(self, eol: bool, video: VideoSettings) -> None:
        if not video.enabled:
            self._dropped = 0
            self._surplus = self._after = False
            return
        if self._surplus:
            self._beyond_line(eol, video)
            return
        if self._after:
            self.events |= Event.SOF_LATE
        self._dropped += 1
        if self._dropped == self._beats_of(video) * video.height:
            self.events |= Event.SOF_MISSING
            self._dropped = 0

    def _beyond_line(self, eol: bool, now: VideoSettings) -> None:
        """A beat after the last of its line."""
        self._x += 1
        if eol:
            self._surplus, self._x = False, 0
        elif self._x == self._beats_of(now):
            self.events |= Event.EOL_MISSING
            self._x = 0

    def _complete(self, now: VideoSettings) -> Packet:
        image, frame = self._image(now), self._stream.frame
        result = self._stream.process(image, now.settings, max_records=now.max_records)
        dropped = result.found - len(result.corners)
        self.dropped_records += dropped
        if dropped:
            self.events |= Event.RECORDS_DROPPED
        self.events |= Event.FRAME_DONE
        self._now = None
        return Packet(result.records, frame, False, result.found, image, self._begun, now.send_time)

    def _cut(self, now: VideoSettings) -> Packet:
        frame = self._stream.frame
        records = self._stream.cut(self._image(now), now.settings, pixels=len(self._pixels))
        self.events |= Event.FRAME_CUT
        self._now = None
        self._after, self._dropped, self._surplus = False, 0, False
        pixels = np.array(self._pixels, pixel_dtype(self.parameters))
        return Packet(records[: now.max_records], frame, True, 0, pixels, self._begun, now.send_time)

    def _image(self, now: VideoSettings) -> Image:
        """The frame, black where no pixel has come."""
        image = np.zeros(now.width * now.height, pixel_dtype(self.parameters))
        image[: len(self._pixels)] = self._pixels
        return image.reshape(now.height, now.width)


def framed(image: Image, *, sof: bool = True, eol: bool = True) -> list[tuple[int, bool, bool]]:
    """The beats ``(pixel, start of frame, end of line)`` of a well-formed frame, a pixel in each.

    ``sof`` or ``eol`` False: its start of frame or its ends of line are missing.
    """
    width = image.shape[1]
    return [
        (int(pixel), sof and k == 0, eol and k % width == width - 1) for k, pixel in enumerate(image.ravel())
    ]
