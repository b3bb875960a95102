# amaranth: UnusedElaboratable=no
"""The whole detector against the golden model: every record, every clock."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from flow.verilog import emit_verilog
from golden import Parameters, Settings, StreamModel, decode_frame_end
from golden.algorithm import RESPONSE_FILTER_REACH
from hdl.build import Build
from hdl.detector import Detector
from hdl.subpixel import Subpixel
from sim.engines import make_engine
from sim.frames import (
    Frame,
    frame_stimulus,
    simulate_frames,
    split_frames,
)
from sim.stimulus import Stalls, Stimulus
from tests.support.builds import each
from tests.support.detectors import (
    MIXTURES,
    PAPER,
    ROBUST,
    both_kinds,
    check,
    engine,
    everything,
    noise,
    run,
    run_with_reset,
)
from tests.support.filters import lenient
from tests.support.photographs import PHOTOGRAPHS, photograph
from tests.support.strategies import any_frames, any_stalls

mixtures = each(
    "parameters",
    MIXTURES,
    # every value of a field is among them
    quick=(
        "paper",
        "robust",
        "paper lean, six samples, single pixels",
        "smoothed pixels, windows of 3x3",
        "10-bit pixels",
        "4-bit pixels",
        "gradient step with budget, suppression",
    ),
)
STALLS = {
    "none": Stalls(),
    "input": Stalls(inputs=0.5, seed=1),
    "output": Stalls(outputs=0.5, seed=2),
    "both": Stalls(inputs=0.3, outputs=0.3, seed=3),
    "starved": Stalls(inputs=0.9, seed=4),
    "clogged": Stalls(outputs=0.97, seed=5),
}


sizes = pytest.mark.parametrize("size", [(0, 0), (0, 64), (64, 0), (33, 47)])
FULL_RATE = 15
"""Least side of frames that never wait, and one more each time that pixels are smoothed.

The settings of a smaller frame would come before those of the frame before it are taken.
"""
FULL_RATE_OF_STEPS = 51
"""Least width of frames without corners that never wait for gradient steps."""


def at_least(size: tuple[int, int], parameters: Parameters) -> tuple[int, int]:
    """The nearest size that this detector takes."""
    height, width = (max(side, parameters.algorithm.support) for side in size)
    return height, width


def noisy(parameters: Parameters, sizes: list[tuple[int, int]], seed: int = 0) -> list[Frame]:
    """Frames of noise of these (height, width), each from the next seed; with both flags."""
    each = both_kinds(parameters)
    return [(noise(*size, seed + k, parameters), each) for k, size in enumerate(sizes)]


@mixtures
def test_of_these_corners_some_are_accepted_and_some_rejected(parameters: Parameters) -> None:
    """What all comparisons below rest on, with any filter."""
    corners = StreamModel(parameters).process(noise(60, 60, 0, parameters), both_kinds(parameters)).corners
    filtered = parameters.algorithm.texture != "none"
    fewest = 20 if parameters.algorithm.suppression == 1 else 10
    assert len(corners) > fewest and 0 < corners.accepted.sum() <= len(corners) - filtered


@pytest.mark.parametrize("name", PHOTOGRAPHS)
@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_photographs(parameters: Parameters, name: str) -> None:
    image = photograph(name)
    detect_all = Settings(report_rejected=True)
    result = run(parameters, [(image, detect_all), (image, Settings()), (image, both_kinds(parameters))])
    assert [frame.clocks for frame in result.frames] == [image.size] * 3
    detector = Detector(parameters)
    at_once, last_candidate = detector.frame_latency(image.shape[1]), detector.refinement_latency
    for frame in result.frames:
        assert at_once <= frame.end_of_frame - frame.last_pixel <= at_once + last_candidate


@pytest.mark.parametrize("stalls", STALLS.values(), ids=STALLS.keys())
@each(
    "parameters",
    {"banked": PAPER, "lean": ROBUST, "paper lean": Build.profile("paper", buffering="lean")},
    # those that photographs are tried on anyway, one of each buffering
    quick=("banked", "lean"),
)
def test_photograph_under_stalls(parameters: Build, stalls: Stalls, camera: NDArray[np.uint8]) -> None:
    image = camera[100:300, 150:450]
    run(parameters, [(image, Settings()), (image, both_kinds(parameters))], stalls)


@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_the_widest_and_the_highest_frames(parameters: Parameters) -> None:
    """Every place of the buffers, and every number of a row and a column, in both orders."""
    brick = np.tile(photograph("brick"), (3, 4))
    sizes = [(32, 1920), (1080, 32), (1080, 32), (32, 1920)]
    frames = [(brick[:height, :width], both_kinds(parameters)) for height, width in sizes]
    result = run(parameters, frames)
    assert all(len(frame.records) > 20 for frame in result.frames)
    assert [result.frames[k].clocks for k in (0, 2)] == [32 * 1920, 1080 * 32]


@pytest.mark.verify
@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_full_hd_at_the_built_maximum(parameters: Parameters) -> None:
    image = np.tile(photograph("brick"), (3, 4))[:1080, :1920]
    result = run(parameters, [(image, Settings()), (image, Settings())])
    assert [frame.clocks for frame in result.frames] == [1920 * 1080] * 2


@mixtures
@given(data=st.data())
@settings(max_examples=60, suppress_health_check=[HealthCheck.too_slow])
def test_any_images_sizes_and_stalls(parameters: Parameters, data: st.DataObject) -> None:
    run(parameters, data.draw(any_frames(parameters)), data.draw(any_stalls()))


@mixtures
def test_extremes(parameters: Parameters) -> None:
    """Checkerboards of every small period, flat frames at both ends, noise: the widths hold."""
    full = parameters.pixel_max
    y, x = np.mgrid[:40, :50]
    dtype = np.uint8 if parameters.pixel_bits <= 8 else np.uint16
    frames = [((((x // n) + (y // n)) % 2) * full).astype(dtype) for n in range(1, 8)]
    frames += [((x // n + 0 * y) % 2 * full).astype(dtype) for n in (1, 2, 3)]
    frames += [np.full((20, 30), full, dtype), np.zeros((30, 20), dtype), noise(50, 60, 1, parameters)]
    frames += [(noise(50, 60, 2, parameters) > full // 2).astype(dtype) * dtype(full)]
    wide_open = Settings(
        sigma1=0,
        sigma2=lenient(parameters),
        reference="constant",
        constant=parameters.response_max,
        floor=1,
    )
    run(parameters, [(frame, wide_open) for frame in frames])


@mixtures
@sizes
def test_one_pixel_per_clock(parameters: Parameters, size: tuple[int, int]) -> None:
    """Back-to-back frames of one size never wait, be it noise with every corner reported.

    Gradient steps take longer than corners of noise come: there it is faint noise without corners.
    """
    by_steps = parameters.algorithm.fit == "gradient"
    least = FULL_RATE + parameters.algorithm.pixel_passes
    narrowest = FULL_RATE_OF_STEPS if by_steps else least
    size = at_least((max(size[0], least), max(size[1], narrowest)), parameters)
    chosen = Settings.default(parameters, sigma1=0, sigma2=lenient(parameters))
    if by_steps:
        chosen = replace(chosen, floor=parameters.response_max, sigma1=0.5)
    shift = parameters.pixel_bits - 1 if by_steps else 0
    frames = [noise(*size, seed, parameters) >> shift for seed in range(5)]
    result = run(parameters, [(frame, chosen) for frame in frames])
    assert all(len(frame.records) == 1 for frame in result.frames) or not by_steps
    assert [frame.clocks for frame in result.frames] == [size[0] * size[1]] * 5


@mixtures
def test_black_and_white_noise_does_not_wait(parameters: Parameters) -> None:
    """Denser than natural images: one corner in about 31 pixels, or in 50 to 70 if smoothed.

    Gradient steps do wait then: how long, test_detector_steps asks.
    """
    frames = [
        ((noise(64, 64, seed, parameters) > parameters.pixel_max // 2) * parameters.pixel_max).astype(
            noise(1, 1, 0, parameters).dtype
        )
        for seed in range(3)
    ]
    result = run(parameters, [(frame, everything(parameters)) for frame in frames])
    if parameters.algorithm.fit != "gradient":
        assert [frame.clocks for frame in result.frames] == [64 * 64] * 3
    if parameters.algorithm.suppression == 1:
        algorithm = parameters.algorithm
        smoothings = algorithm.pixel_passes + RESPONSE_FILTER_REACH[algorithm.response_filter]
        sparsest = (40, 50, 70, 70)[smoothings]
        assert all(len(frame.records) > 50 * 50 / sparsest for frame in result.frames)


def test_a_fine_grid_makes_the_input_wait_and_loses_nothing() -> None:
    """A dot every five pixels: corners come faster than they are refined, row by row."""
    parameters = MIXTURES["paper"]
    y, x = np.mgrid[:64, :64]
    dots = (((x % 5 == 0) & (y % 5 == 0)) * 255).astype(np.uint8)
    wide_open = Settings(sigma1=0, sigma2=15.9, report_rejected=True)
    result = run(parameters, [(dots, wide_open)] * 2)
    interval = Subpixel(parameters).interval
    for frame in result.frames:
        assert len(frame.records) > 80
        assert frame.clocks <= 64 * 64 + interval * len(frame.records)
    wide = np.tile(dots, (1, 8))
    result = run(parameters, [(wide, wide_open)])
    assert wide.size < result.frames[0].clocks < 2 * wide.size
    patient = Build.profile("paper", max_width=512, max_height=64, queue_depth=128)
    result = run(patient, [(wide, wide_open)])
    assert result.frames[0].clocks == wide.size


@mixtures
@sizes
def test_latency_without_corners(parameters: Parameters, size: tuple[int, int]) -> None:
    size = at_least(size, parameters)
    flat = np.zeros(size, np.uint8 if parameters.pixel_bits <= 8 else np.uint16)
    result = run(parameters, [(flat, Settings.default(parameters))] * 3)
    latency = Detector(parameters).frame_latency(size[1])
    assert [frame.end_of_frame - frame.last_pixel for frame in result.frames] == [latency] * 3


@pytest.mark.parametrize("parameters", [MIXTURES["paper"], MIXTURES["robust"]], ids=["paper", "robust"])
def test_a_change_of_size_costs_at_most_the_push(parameters: Parameters) -> None:
    sizes = [(15, 15), (20, 64), (15, 15), (64, 16), (17, 17), (16, 64), (15, 16)]
    result = run(parameters, noisy(parameters, sizes))
    widths = [width for _, width in sizes]
    for frame, (height, width), before in zip(result.frames, sizes, [15, *widths], strict=False):
        push = 0 if parameters.buffering == "lean" else 2 * max(before, width)
        assert height * width <= frame.clocks <= height * width + push


def test_a_corner_on_the_last_possible_pixel() -> None:
    """Nearest to the end-of-frame record that a corner can come; and one pixel before it."""
    parameters = MIXTURES["robust"]
    found = {0: 0, 1: 0}
    for seed in range(400):
        image = noise(16, 17, seed)
        result = run(parameters, [(image, Settings(sigma1=0, sigma2=0))])
        positions = result.frames[0].records[:-1] & np.uint64((1 << 40) - 1)
        columns = {
            round(float(p & np.uint64(0xFFFFF)) / 128) for p in positions if round(float(p >> 20) / 128) == 8
        }
        for distance in found:
            found[distance] += 9 - distance in columns
    assert all(found.values()), found


@given(cut=st.integers(1, 40 * 30 - 1), seed=st.integers(0, 99), name=st.sampled_from(["paper", "robust"]))
@settings(max_examples=40)
def test_reset_in_mid_frame(cut: int, seed: int, name: str) -> None:
    """After a reset anywhere the next frames are as after power-on: first frame, frame number 0."""
    parameters = MIXTURES[name]
    broken, *frames = noisy(parameters, [(30, 40), (20, 25), (25, 20)], seed)
    before = run_with_reset(parameters, broken, frames, cut, seed)
    # and what came out before the reset is the beginning of the broken frame
    assert np.array_equal(before, StreamModel(parameters).process(*broken).records[: len(before)])


@pytest.mark.parametrize("parameters", [MIXTURES["paper"], MIXTURES["robust"]], ids=["paper", "robust"])
def test_a_frame_leaves_no_trace_but_its_maximum(parameters: Parameters) -> None:
    constant = replace(both_kinds(parameters), reference="constant")
    last: Frame = (noise(30, 30, 0), constant)
    words = []
    for seed, (height, width) in enumerate([(30, 30), (15, 64), (64, 15)]):
        result = run(parameters, [(noise(height, width, seed), constant), last])
        words.append(result.frames[1].records)
    assert all(np.array_equal(words[0], other) for other in words[1:])


def test_settings_and_size_are_sampled_with_the_first_pixel_only() -> None:
    parameters = MIXTURES["robust"]
    frames = noisy(parameters, [(30, 40), (20, 50)], 1)
    plain = frame_stimulus(frames, parameters, Stalls())
    garbage = {
        "width": 17,
        "height": 63,
        "sigma1": 0,
        "sigma2": 1,
        "use_constant": 1,
        "constant": 1,
        "floor": 9,
    }
    levels = sorted([*plain.levels, (1, garbage), (1201, garbage)], key=lambda change: change[0])
    capture = engine(parameters).run(Stimulus(plain.beats, levels))
    check(split_frames(capture, [image.size for image, _ in frames]), parameters, frames)


def test_sizes_out_of_range_are_taken_as_the_nearest_allowed() -> None:
    parameters = MIXTURES["gradient step with budget, suppression"]
    frames = noisy(parameters, [(15, 15), (64, 64)], 1)
    plain = frame_stimulus(frames, parameters, Stalls())
    wrong = [{"width": 3, "height": 0}, {"width": 127, "height": 100}]
    levels = [(beat, {**values, **size}) for (beat, values), size in zip(plain.levels, wrong, strict=True)]
    capture = engine(parameters).run(Stimulus(plain.beats, levels))
    check(split_frames(capture, [image.size for image, _ in frames]), parameters, frames)


def test_end_of_frame_record() -> None:
    parameters = MIXTURES["paper"]
    black = np.zeros((20, 20), np.uint8)
    result = run(parameters, [(black, Settings()), *noisy(parameters, [(40, 40)], 1)])
    empty, full = (decode_frame_end(int(frame.records[-1])) for frame in result.frames)
    assert (empty.records, empty.frame, empty.maximum) == (0, 0, 0)
    assert full.records == len(result.frames[1].records) - 1 > 0
    assert full.frame == 1 and full.maximum > 0


@pytest.mark.parametrize(
    ("name", "options"),
    [("paper", {}), ("robust", {}), ("paper", {"texture": "mean"})],
    ids=["paper", "robust", "adaptive threshold"],
)
def test_small_frames_in_amaranths_simulator(name: str, options: dict[str, str]) -> None:
    """Nothing is compiled: it takes two seconds to tell what a change of the sources does."""
    parameters = Build.profile(name, max_width=32, max_height=32, **options)
    frames = noisy(parameters, [(28, 32), (24, 20)], 1)
    result = simulate_frames(make_engine("amaranth", Detector(parameters)), frames, parameters)
    check(result, parameters, frames)
    assert len(result.frames[0].records) > 3


@pytest.mark.parametrize("name", ["paper", "robust"])
def test_amaranths_simulator_agrees_clock_by_clock(name: str) -> None:
    parameters = MIXTURES[name]
    frames = noisy(parameters, [(15, 18), (18, 15)], 1)
    stimulus = frame_stimulus(frames, parameters, Stalls(0.3, 0.3, 6))
    captures = [
        each.run(stimulus, quiet=300)
        for each in (engine(parameters), make_engine("amaranth", Detector(parameters)))
    ]
    check(split_frames(captures[1], [image.size for image, _ in frames]), parameters, frames)
    assert np.array_equal(captures[0].output_clocks["o"], captures[1].output_clocks["o"])
    assert np.array_equal(captures[0].input_clocks["i"], captures[1].input_clocks["i"])


@pytest.mark.parametrize("name", ["paper", "robust"])
def test_the_emitted_verilog_in_an_independent_simulator(name: str, tmp_path: Path) -> None:
    """Verilator, starting from random contents of everything that is not reset."""
    parameters = Build.profile(name)
    verilog = tmp_path / "cornerstream.v"
    verilog.write_text(emit_verilog(parameters))
    simulator = make_engine("verilog", Detector(parameters), verilog=verilog)
    image = photograph("camera")
    each = both_kinds(parameters)
    frames: list[Frame] = [(image, Settings()), (image, each), (image[:100, :200], each)]
    stimulus = frame_stimulus(frames, parameters, Stalls(0.1, 0.1, 7))
    capture = simulator.run(stimulus, quiet=3000)
    check(split_frames(capture, [image.size for image, _ in frames]), parameters, frames)
    compiled = engine(parameters).run(stimulus, quiet=3000)
    assert np.array_equal(capture.output_clocks["o"], compiled.output_clocks["o"])
