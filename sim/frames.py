# amaranth: UnusedElaboratable=no
"""Drives a detector frame by frame, and compares its records with the golden model's."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden import Settings, check_image, decode, decode_frame_end
from golden.output_constructor import END_OF_FRAME, FLAG_SHIFT, Flag
from hdl.build import Build
from hdl.detector import Detector
from sim.beats import beat_count, beats
from sim.engine import VCD_CLOCKS, Engine, Progress
from sim.stimulus import Capture, Clocks, Stalls, Stimulus, Words, default_max_clocks

Frame = tuple[NDArray[Any], Settings]
"""An image and what to process it with."""


@dataclass(frozen=True)
class FrameRun:
    """One frame of a simulation.

    Parameters
    ----------
    records
        The 64-bit words of the frame, the end-of-frame record included, shape (n,).
    clocks
        From this frame's first beat to the next one's; for the last frame, to its last beat, which
        is included. Without stalls and waiting this is the number of beats: of pixels, where
        ``pixels_per_clock`` is 1.
    first_pixel, last_pixel
        Clocks in which the beats of these were accepted.
    end_of_frame
        Clock in which the end-of-frame record was taken.
    """

    records: Words
    clocks: int
    first_pixel: int
    last_pixel: int
    end_of_frame: int


@dataclass(frozen=True)
class SimulationResult:
    """All frames of a simulation.

    Parameters
    ----------
    frames
        Frames that have ended, in order.
    leftover
        Records after the last end of a frame, or with an end that belongs to no frame of pixels:
        always a mismatch.
    clocks, seconds
        Length of the whole run.
    """

    frames: list[FrameRun]
    leftover: Words
    clocks: int
    seconds: float

    @property
    def clocks_per_second(self) -> float:
        return self.clocks / self.seconds if self.seconds > 0 else 0.0


@dataclass(frozen=True)
class Mismatch:
    """One record that is not as expected; None stands for no record. ``str()`` describes it."""

    frame: int
    index: int
    expected: int | None
    got: int | None

    def __str__(self) -> str:
        return (
            f"frame {self.frame}, record {self.index}: "
            f"expected {describe_record(self.expected)}, got {describe_record(self.got)}"
        )


def describe_record(word: int | None) -> str:
    """A record in words."""
    if word is None:
        return "nothing"
    if Flag(word >> FLAG_SHIFT) & END_OF_FRAME == END_OF_FRAME:
        end = decode_frame_end(word)
        cut = ", cut short" if end.cut else ""
        return f"end of frame {end.frame} ({end.records} records, largest D {end.maximum}{cut})"
    corners = decode(np.array([word], np.uint64))
    flags = Flag(int(corners.flags[0]))
    names = f" {flags.name}" if flags else ""
    return f"({corners.x[0]:.4f}, {corners.y[0]:.4f}) D={corners.response[0]}{names}"


def _levels(frame: Frame, build: Build) -> dict[str, int]:
    image, settings = frame
    return {"width": image.shape[1], "height": image.shape[0], **settings.fixed(build)}


def frame_stimulus(frames: Sequence[Frame], build: Build, stalls: Stalls) -> Stimulus:
    """Beats of all frames back to back; each frame's settings arrive with its first one.

    What the last beat of a row holds beyond the width comes from the seed of the stalls, and is
    different for each frame.

    Raises
    ------
    ValueError, TypeError
        There is no frame, or an image or settings do not fit ``build``.
    """
    if not frames:
        raise ValueError("there are 0 frames; allowed: from 1")
    for image, settings in frames:
        check_image(image, build)
        settings.check(build)
    given = [
        beats(image, build, np.random.default_rng([stalls.seed, number]))
        for number, (image, _) in enumerate(frames)
    ]
    starts = np.cumsum([0] + [len(each) for each in given])
    levels = [(int(start), _levels(frame, build)) for start, frame in zip(starts, frames, strict=False)]
    return Stimulus({"i": np.concatenate(given)}, levels, stalls)


def split_frames(capture: Capture, sizes: Sequence[int]) -> SimulationResult:
    """Sort what came out of a detector into frames of ``sizes`` beats each."""
    words, last = capture.outputs["o"].T
    accepted: Clocks = capture.input_clocks["i"]
    ends = np.flatnonzero(last)[: len(sizes)]
    starts = np.concatenate([[0], ends + 1]).astype(int)
    first = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
    frames = []
    for k, end in enumerate(ends):
        first_pixel, last_pixel = int(accepted[first[k]]), int(accepted[first[k + 1] - 1])
        until = int(accepted[first[k + 1]]) if k + 1 < len(sizes) else last_pixel + 1
        frames.append(
            FrameRun(
                records=words[starts[k] : end + 1].copy(),
                clocks=until - first_pixel,
                first_pixel=first_pixel,
                last_pixel=last_pixel,
                end_of_frame=int(capture.output_clocks["o"][end]),
            )
        )
    return SimulationResult(frames, words[starts[-1] :].copy(), capture.clocks, capture.seconds)


def simulate_frames(
    engine: Engine,
    frames: Sequence[Frame],
    build: Build,
    *,
    stalls: Stalls | None = None,
    progress: Progress | None = None,
    vcd: str | Path | None = None,
    vcd_clocks: int = VCD_CLOCKS,
    max_clocks: int | None = None,
) -> SimulationResult:
    """Stream frames back to back through a detector.

    Parameters
    ----------
    engine
        Made from a ``hdl.detector.Detector`` with the same ``build``.
    frames
        Images, shape (height, width), and their settings.
    build
        What the detector was built with.
    stalls, progress, vcd, vcd_clocks, max_clocks
        See :meth:`sim.engine.Engine.run`; progress counts beats.

    Raises
    ------
    sim.engine.SimulationHang, sim.engine.StreamError
        See :meth:`sim.engine.Engine.run`.
    ValueError, TypeError
        There is no frame, or an image or settings do not fit ``build``.
    """
    stalls = stalls or Stalls()
    stimulus = frame_stimulus(frames, build, stalls)
    quiet = Detector(build).longest_silence(max(image.shape[1] for image, _ in frames))
    if max_clocks is None:
        # several pixels may all be corners, which are refined one after the other
        max_clocks = default_max_clocks(sum(image.size for image, _ in frames), stalls, quiet)
    capture = engine.run(stimulus, progress, vcd, vcd_clocks=vcd_clocks, quiet=quiet, max_clocks=max_clocks)
    return split_frames(capture, [beat_count(image.shape, build) for image, _ in frames])


def _compare_words(frame: int, expected: Words, got: Words) -> list[Mismatch]:
    common = min(len(expected), len(got))
    different = np.flatnonzero(expected[:common] != got[:common])
    mismatches = [Mismatch(frame, int(k), int(expected[k]), int(got[k])) for k in different]
    mismatches += [Mismatch(frame, k, int(expected[k]), None) for k in range(common, len(expected))]
    mismatches += [Mismatch(frame, k, None, int(got[k])) for k in range(common, len(got))]
    return mismatches


def compare(result: SimulationResult, expected: Sequence[NDArray[np.uint64]]) -> list[Mismatch]:
    """All records that differ, by frame and position; empty if the simulation is right.

    Parameters
    ----------
    expected
        Per frame, the words of ``golden.StreamModel.process(...).records``, end-of-frame record
        included.
    """
    nothing = np.zeros(0, np.uint64)
    got = [frame.records for frame in result.frames]
    if len(result.leftover):
        got.append(result.leftover)
    count = max(len(expected), len(got))
    pairs = zip(
        [*expected, *[nothing] * (count - len(expected))],
        [*got, *[nothing] * (count - len(got))],
        strict=True,
    )
    return [
        mismatch for frame, (want, have) in enumerate(pairs) for mismatch in _compare_words(frame, want, have)
    ]


def summarize(mismatches: Sequence[Mismatch], limit: int = 5) -> str:
    """A line of counts and lines for the first ``limit`` mismatches; empty if there are none."""
    if not mismatches:
        return ""
    missing = sum(mismatch.got is None for mismatch in mismatches)
    surplus = sum(mismatch.expected is None for mismatch in mismatches)
    wrong = len(mismatches) - missing - surplus
    lines = [f"{len(mismatches)} mismatches: {wrong} wrong, {missing} missing, {surplus} surplus"]
    lines += [str(mismatch) for mismatch in mismatches[:limit]]
    if len(mismatches) > limit:
        lines.append(f"and {len(mismatches) - limit} more")
    return "\n".join(lines)
