"""The frame driver and the comparison: with a detector made of paper, and with the real one."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from golden import Parameters, Settings, StreamModel
from hdl.build import Build
from hdl.detector import Detector
from sim import (
    Capture,
    EngineName,
    SimulationResult,
    Stalls,
    Stimulus,
    compare,
    describe_record,
    frame_stimulus,
    make_engine,
    simulate_frames,
    summarize,
)
from sim.ports import Ports

SMALL = Build.profile("paper", max_width=64, max_height=64)
Words = np.ndarray


def images(*sizes: tuple[int, int]) -> list[np.ndarray]:
    """Random blocks: every image has corners."""
    random = np.random.default_rng(1)
    return [
        np.kron(random.integers(0, 256, (9, 9)), np.ones((7, 7)))[:height, :width].astype(np.uint8)
        for height, width in sizes
    ]


class Paper:
    """Engine with given records, one per clock, that takes a pixel per clock."""

    name = "paper"
    ports = Ports((), (), ())

    def __init__(self, words: list[tuple[int, int]]) -> None:
        self._words = np.array(words, np.uint64).reshape(-1, 2)
        self.quiet = 0

    def run(self, stimulus: Stimulus, *_: Any, quiet: int = 0, **__: Any) -> Capture:
        self.quiet = quiet
        count, pixels = len(self._words), len(stimulus.beats["i"])
        # 5 clocks pass before each pixel with an odd number
        accepted = np.arange(pixels) + 5 * ((np.arange(pixels) + 1) // 2)
        return Capture(
            {"o": self._words}, {"o": 100 + np.arange(count)}, {"i": accepted}, clocks=10_000, seconds=0.5
        )


def test_pixels_and_settings_of_a_frame_travel_together() -> None:
    first, second = images((15, 20), (17, 16))
    settings = Settings.default(SMALL), replace(Settings.default(SMALL), reference="constant", constant=77)
    stimulus = frame_stimulus(list(zip((first, second), settings, strict=True)), SMALL, Stalls())
    np.testing.assert_array_equal(stimulus.beats["i"], np.concatenate([first.ravel(), second.ravel()]))
    (beat0, levels0), (beat1, levels1) = stimulus.levels
    assert (beat0, levels0["width"], levels0["height"], levels0["use_constant"]) == (0, 20, 15, 0)
    assert (beat1, levels1["width"], levels1["height"], levels1["use_constant"]) == (300, 16, 17, 1)
    assert levels1["constant"] == 77 and levels1["sigma1"] == settings[1].sigma1_fixed


@pytest.mark.parametrize(
    ("frames", "error", "message"),
    [
        ([], ValueError, "there are 0 frames"),
        ([(np.zeros((14, 20), np.uint8), Settings.default(SMALL))], ValueError, "14"),
        ([(np.zeros((20, 65), np.uint8), Settings.default(SMALL))], ValueError, "65"),
        ([(np.zeros((20, 20), np.float32), Settings.default(SMALL))], TypeError, "float32"),
    ],
)
def test_frames_that_do_not_fit(frames: list[Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        frame_stimulus(frames, SMALL, Stalls())


def test_results_are_split_into_frames() -> None:
    frames = [(image, Settings.default(SMALL)) for image in images((15, 15), (15, 16))]
    engine = Paper([(10, 0), (11, 1), (12, 1), (13, 0)])
    result = simulate_frames(engine, frames, SMALL)
    assert [frame.records.tolist() for frame in result.frames] == [[10, 11], [12]]
    assert result.leftover.tolist() == [13]
    assert [frame.end_of_frame for frame in result.frames] == [101, 102]
    assert result.frames[0].first_pixel == 0
    # pixel 225 has an odd number: 113 pauses lie before it
    assert result.frames[0].clocks == 225 + 5 * 113
    assert result.frames[1].last_pixel == 464 + 5 * 232
    assert result.frames[1].clocks == result.frames[1].last_pixel - result.frames[1].first_pixel + 1
    assert result.clocks_per_second == 20_000
    assert engine.quiet > 3 * 16


def result_of(*frames: list[int], leftover: tuple[int, ...] = ()) -> SimulationResult:
    words = [(word, int(k == len(frame) - 1)) for frame in frames for k, word in enumerate(frame)]
    words += [(word, 0) for word in leftover]
    stimulus = [(image, Settings.default(SMALL)) for image in images(*[(15, 15)] * max(1, len(frames)))]
    return simulate_frames(Paper(words), stimulus, SMALL)


def expected(*frames: list[int]) -> list[Words]:
    return [np.array(frame, np.uint64) for frame in frames]


def test_equal_records_do_not_mismatch() -> None:
    assert compare(result_of([1, 2, 3], [4]), expected([1, 2, 3], [4])) == []
    assert summarize([]) == ""


def test_every_difference_is_found_and_counted() -> None:
    mismatches = compare(result_of([1, 9, 3], [4, 5]), expected([1, 2, 3], [4], [6]))
    where = [(mismatch.frame, mismatch.index, mismatch.expected, mismatch.got) for mismatch in mismatches]
    assert where == [(0, 1, 2, 9), (1, 1, None, 5), (2, 0, 6, None)]
    lines = summarize(mismatches, limit=2).splitlines()
    assert lines[0] == "3 mismatches: 1 wrong, 1 missing, 1 surplus"
    assert lines[1:] == [str(mismatches[0]), str(mismatches[1]), "and 1 more"]


def test_records_without_a_frame_are_surplus() -> None:
    mismatches = compare(result_of([1], leftover=(2, 3)), expected([1]))
    assert [(mismatch.frame, mismatch.got) for mismatch in mismatches] == [(1, 2), (1, 3)]


def test_descriptions() -> None:
    corner = (5 << 61) | (1234 << 40) | (129 << 20) | 64
    assert describe_record(corner) == "(0.5000, 1.0078) D=1234 CLAMPED|TEXTURED"
    assert (
        describe_record((3 << 61) | (99 << 40) | (7 << 24) | 3) == "end of frame 7 (3 records, largest D 99)"
    )
    assert describe_record(7 << 61) == "end of frame 0 (0 records, largest D 0, cut short)"
    assert describe_record(None) == "nothing"
    mismatch = compare(result_of([1 << 40]), expected([2 << 40]))[0]
    assert str(mismatch) == "frame 0, record 0: expected (0.0000, 0.0000) D=2, got (0.0000, 0.0000) D=1"


@pytest.mark.parametrize("kind", ["amaranth", "compiled"])
def test_the_detector_against_the_golden_model(kind: EngineName) -> None:
    parameters: Parameters = Build.profile("robust", max_width=32, max_height=24)
    settings = replace(Settings.default(parameters), report_rejected=True)
    frames = [(image, settings) for image in images((15, 15), (20, 30), (24, 16))]
    model = StreamModel(parameters)
    want = [model.process(*frame).records for frame in frames]
    engine = make_engine(kind, Detector(parameters))
    for stalls in (Stalls(), Stalls(0.2, 0.5, 1)):
        result = simulate_frames(engine, frames, parameters, stalls=stalls)
        assert summarize(compare(result, want)) == ""
        if stalls == Stalls():
            assert [frame.clocks for frame in result.frames] == [225, 600, 384]
