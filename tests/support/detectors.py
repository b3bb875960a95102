# amaranth: UnusedElaboratable=no
"""Builds of the whole detector for its tests, each compiled once, and how they are compared."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from golden import Parameters, Settings, StreamModel
from hdl.build import Build
from hdl.detector import Detector
from sim.engine import Engine
from sim.engines import make_engine
from sim.frames import Frame, SimulationResult, compare, frame_stimulus, simulate_frames, summarize
from sim.stimulus import Stalls, Stimulus
from tests.support.filters import lenient, selective
from tests.support.profiles import ADAPTIVE_OPTIONS as ADAPTIVE

PAPER = Build.profile("paper")
ROBUST = Build.profile("robust")
SMALL = {"max_width": 64, "max_height": 64}
# together these hold every value of every field, next to different values of the others
MIXTURES = {
    # no smaller than for photographs, so that each is compiled once
    "paper": PAPER,
    "robust": ROBUST,
    "paper lean, six samples, single pixels": Build.profile(
        "paper", **SMALL, buffering="lean", fit="six", patches="pixels", sqrt_bits_per_stage=3
    ),
    "robust banked, six samples": Build.profile(
        "robust",
        **SMALL,
        buffering="banked",
        fit="six",
        divider="table",
        texture="patches",
        sqrt_bits_per_stage=2,
    ),
    "paper, gradient step, adaptive threshold": Build.profile(
        "paper", **SMALL, fit="gradient", texture="mean"
    ),
    "Sobel gradients, adaptive threshold, gradient step": Build.profile("robust", **SMALL, **ADAPTIVE),
    "robust but for its response filter": Build.profile("robust", **SMALL, response_filter="none"),
    "smoothed pixels, windows of 3x3": Build.profile(
        "paper",
        **SMALL,
        buffering="lean",
        pixel_filter="binomial",
        gradient="signed",
        ties="first",
        texture="none",
    ),
    "10-bit pixels": Build.profile("robust", **SMALL, pixel_bits=10, fit="gradient", sqrt_bits_per_stage=4),
    "4-bit pixels": Build.profile(
        "paper",
        **SMALL,
        pixel_bits=4,
        pixel_filter="twice",
        derivative="sobel",
        ties="first",
        divider="serial",
        texture="none",
        suppression=2,
        sqrt_bits_per_stage=17,
        max_per_cell=1,
    ),
    "paper with budget": Build.profile("paper", **SMALL, budget=True),
    "nine samples with budget, suppression": Build.profile(
        "robust", **SMALL, budget=True, suppression=4, fit="nine", response_filter="none"
    ),
    "3x3 with budget": Build.profile(
        "paper", **SMALL, pixel_filter="twice", texture="none", response_filter="binomial", budget=True
    ),
    "gradient step with budget, suppression": Build.profile(
        "robust",
        **SMALL,
        **ADAPTIVE,
        budget=True,
        suppression=3,
        response_filter="none",
        max_per_cell=5,
        min_cell_width=13,
    ),
    "banked, gradient step, smoothed twice, no texture filter": Build.profile(
        "robust", **SMALL, buffering="banked", fit="gradient", pixel_filter="twice", texture="none"
    ),
}


STALLS = {
    "none": Stalls(),
    "both": Stalls(inputs=0.3, outputs=0.3, seed=3),
    "starved": Stalls(inputs=0.9, seed=4),
    "clogged": Stalls(outputs=0.97, seed=5),
}


@cache
def engine(parameters: Parameters) -> Engine:
    return make_engine("compiled", Detector(parameters))


def both_kinds(parameters: Parameters) -> Settings:
    """Corners in plenty, of which some are rejected and all reported."""
    return Settings.default(parameters, sigma1=0.002, sigma2=selective(parameters), report_rejected=True)


def everything(parameters: Parameters) -> Settings:
    """The most corners that there can be: all peaks are, and all of them are reported."""
    return Settings.default(parameters, sigma1=0, sigma2=lenient(parameters), report_rejected=True)


def run(parameters: Parameters, frames: list[Frame], stalls: Stalls | None = None) -> SimulationResult:
    """Simulate and compare; every test goes through here."""
    result = simulate_frames(engine(parameters), frames, parameters, stalls=stalls)
    check(result, parameters, frames)
    return result


def run_with_reset(
    parameters: Parameters, broken: Frame, frames: list[Frame], cut: int, seed: int
) -> NDArray[np.uint64]:
    """Simulate, under stalls, so many pixels of a frame, a reset, and frames; compare the latter.

    Returns the records that came before the reset.
    """
    stalls = Stalls(0.2, 0.2, seed)
    start = frame_stimulus([broken], parameters, stalls)
    rest = frame_stimulus(frames, parameters, stalls)
    pixels = np.concatenate([start.beats["i"][:cut], rest.beats["i"]])
    levels = [*start.levels, *((beat + cut, values) for beat, values in rest.levels)]
    quiet = Detector(parameters).longest_silence(max(image.shape[1] for image, _ in frames))
    capture = engine(parameters).run(Stimulus({"i": pixels}, levels, stalls, reset_after=cut), quiet=quiet)
    model = StreamModel(parameters)
    expected = np.concatenate([model.process(*frame).records for frame in frames])
    words = capture.outputs["o"][:, 0]
    assert np.array_equal(words[len(words) - len(expected) :], expected)
    return words[: len(words) - len(expected)]


def check(result: SimulationResult, parameters: Parameters, frames: list[Frame]) -> None:
    model = StreamModel(parameters)
    mismatches = compare(result, [model.process(*frame).records for frame in frames])
    assert not mismatches, summarize(mismatches)


def noise(height: int, width: int, seed: int, parameters: Parameters = PAPER) -> NDArray[np.unsignedinteger]:
    dtype = np.uint8 if parameters.pixel_bits <= 8 else np.uint16
    return np.random.default_rng(seed).integers(
        0, parameters.pixel_max, (height, width), dtype, endpoint=True
    )
