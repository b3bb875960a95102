# amaranth: UnusedElaboratable=no
"""Structure of the detector: latencies, no multiplier, and builds that are refused."""

from __future__ import annotations

import re
from typing import Any

import pytest
from amaranth.back import rtlil

from golden import Parameters
from hdl.adaptive_threshold import AdaptiveThreshold
from hdl.build import Build
from hdl.centre_rows import CentreRows
from hdl.corner_detection import CornerDetection
from hdl.detector import Detector
from hdl.response_filter import ResponseFilter
from hdl.surface import SurfaceFit
from hdl.texture_filter import TextureFilter
from hdl.thresholds import Thresholds
from hdl.window_stage import WindowStage
from tests.support.detectors import MIXTURES, PAPER, ROBUST


@pytest.mark.parametrize("parameters", [PAPER, ROBUST], ids=["paper", "robust"])
def test_latency_is_the_sum_of_the_blocks(parameters: Parameters) -> None:
    detector = Detector(parameters)
    assert detector.latency == sum(block.latency for block in detector.blocks.values()) + 1


@pytest.mark.parametrize("parameters", MIXTURES.values(), ids=MIXTURES.keys())
def test_what_moves_in_step_is_equally_long(parameters: Parameters) -> None:
    """Nothing waits for a longer way: all of a window's results come in the same clock."""
    late = CentreRows.latency
    assert ResponseFilter.latency == late and AdaptiveThreshold.latency == TextureFilter.latency
    assert TextureFilter.latency == late + CornerDetection.latency == late + SurfaceFit.latency
    stage = WindowStage(parameters)
    assert len({arrival(stage, block) for block in results(stage)}) == 1


def results(stage: WindowStage) -> list[Any]:
    """The blocks whose results meet in the candidate selection."""
    return [stage.corner_detection, stage.surface_fit, *stage.texture_filters.values()]


def arrival(stage: WindowStage, block: Any) -> int:
    """Clocks from a window's last column to the block's result."""
    behind = stage.centre_rows is not None and block.reads == "centres"
    return int(block.latency) + (CentreRows.latency if behind else 0)


@pytest.mark.parametrize("parameters", MIXTURES.values(), ids=MIXTURES.keys())
def test_thresholds_are_there_before_the_first_column(parameters: Parameters) -> None:
    """T1 is compared with a window's middle column, and rows come no faster than they are read."""
    algorithm, windows = parameters.algorithm, WindowStage(parameters)
    row = algorithm.support - 2 * algorithm.pixel_passes
    window = (algorithm.window_size - 1) * row + algorithm.window_size // 2
    assert Thresholds(parameters).clocks < window + windows.response_buffer.latency


def test_the_printed_fit_exists_in_the_golden_model_only() -> None:
    with pytest.raises(ValueError, match=r"fit is 'printed'; allowed in hardware: nine, six"):
        Detector(Build.profile("paper", fit="printed"))


LANES = {"four pixels per clock": ROBUST.changed(pixels_per_clock=4)}


@pytest.mark.parametrize("parameters", (MIXTURES | LANES).values(), ids=MIXTURES | LANES)
def test_no_multiplier_is_asked_for(parameters: Parameters) -> None:
    """Products are adders: no synthesis tool can infer an embedded multiplier."""
    cells = set(re.findall(r"cell (\$\w+)", rtlil.convert(Detector(parameters), name="top")))
    assert "$add" in cells
    assert not cells & {"$mul", "$div", "$mod", "$divfloor", "$modfloor", "$pow", "$macc"}
