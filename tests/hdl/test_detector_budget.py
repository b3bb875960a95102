# amaranth: UnusedElaboratable=no
# amaranth: UnusedElaboratable=no
"""The whole detector with a budget: limit and target, back to back, changed, and after resets."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from golden import Parameters, Settings, StreamModel
from hdl.build import Build
from hdl.detector import Detector
from sim.frames import Frame, frame_stimulus
from sim.stimulus import Stalls, Stimulus
from tests.support.builds import each
from tests.support.detectors import MIXTURES, SMALL, engine, noise, run
from tests.support.filters import lenient, selective

BUDGETS = {name: parameters for name, parameters in MIXTURES.items() if parameters.budget}
# the longest way from the last response to the last window
BUDGETS["robust banked"] = Build.profile("robust", **SMALL, buffering="banked", budget=True)
budgets = each("parameters", BUDGETS, quick=("gradient step with budget, suppression",))
# gradient steps of many corners do make frames wait
NO_STEPS = {
    name: parameters for name, parameters in BUDGETS.items() if parameters.algorithm.fit != "gradient"
}
no_steps = each("parameters", NO_STEPS, quick=("nine samples with budget, suppression",))


@no_steps
@pytest.mark.parametrize("size", [(15, 15), (15, 64), (33, 47)])
def test_adaptation_never_makes_a_frame_wait(parameters: Parameters, size: tuple[int, int]) -> None:
    """The smallest frames without a pause: T1 is there before the next frame needs it."""
    # the settings of smaller frames wait for each other where pixels are smoothed
    least = max(15 + parameters.algorithm.pixel_passes, parameters.algorithm.support)
    height, width = (max(side, least) for side in size)
    aimed = Settings.default(parameters, sigma2=lenient(parameters), target_corners=2)
    result = run(parameters, [(noise(height, width, seed, parameters), aimed) for seed in range(8)])
    assert [frame.clocks for frame in result.frames] == [height * width] * 8


@budgets
def test_targets_and_limits_change_from_frame_to_frame(parameters: Parameters) -> None:
    """Each pair of values after each other; black frames and ones full of corners in between.

    Without a target there is a rank in every second frame; and all moves at once, or by and by.
    """
    frames: list[Frame] = []
    some = selective(parameters)
    for seed, (target, most) in enumerate(product((0, 3, 200), (0, 1, 5, 65535))):
        for image in (noise(40, 50, seed, parameters), np.zeros((20, 30), np.uint8)):
            budget = {"target_corners": target, "max_corners": most, "smoothing": seed % 4}
            budget["reference_rank"] = 8 * (seed % 3)
            frames.append((image, Settings.default(parameters, sigma1=0.001, sigma2=some, **budget)))
            frames.append((image, Settings.default(parameters, sigma2=some, target_corners=3)))
    for stalls in (Stalls(), Stalls(0.2, 0.6, 7)):
        run(parameters, frames, stalls)


def test_max_corners_bounds_what_a_dense_frame_costs() -> None:
    """What is left out is never refined: a grid too fine for that holds the input up no more."""
    parameters = Build.profile("paper", max_width=512, max_height=64, budget=True)
    y, x = np.mgrid[:64, :512]
    dots = (((x % 5 == 0) & (y % 5 == 0)) * 255).astype(np.uint8)
    wide_open = {"sigma1": 0, "sigma2": 15.9, "report_rejected": True}
    free = run(parameters, [(dots, Settings(**wide_open))])
    limited = run(parameters, [(dots, Settings(**wide_open, max_corners=16))])
    assert limited.frames[0].clocks == dots.size < free.frames[0].clocks
    assert len(limited.frames[0].records) == 17


@budgets
def test_a_reset_leaves_nothing_in_the_histogram(parameters: Parameters) -> None:
    """Many corners of a broken frame in bins that the next frames fill again."""
    aimed = Settings.default(parameters, sigma2=lenient(parameters), target_corners=5)
    frames: list[Frame] = [(noise(30, 40, seed, parameters), aimed) for seed in range(4)]
    for cut in (900, 1100, 1199):
        plain = frame_stimulus(frames, parameters, Stalls())
        start = plain.beats["i"][:1200][:cut]
        levels = [(0, plain.levels[0][1]), *((beat + cut, values) for beat, values in plain.levels)]
        stimulus = Stimulus({"i": np.concatenate([start, plain.beats["i"]])}, levels, reset_after=cut)
        quiet = Detector(parameters).longest_silence(40)
        words = engine(parameters).run(stimulus, quiet=quiet).outputs["o"][:, 0]
        model = StreamModel(parameters)
        expected = np.concatenate([model.process(*frame).records for frame in frames])
        assert np.array_equal(words[len(words) - len(expected) :], expected)
