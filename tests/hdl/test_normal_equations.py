# amaranth: UnusedElaboratable=no
"""Normal equations behind preprocessing against the golden model, for every pixel width."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from golden.formats import MAX_PIXEL_BITS, MIN_PIXEL_BITS
from golden.normal_equations import LARGEST, PIXEL_SIZE, largest, normal_equations
from golden.subpixel import derivative_bits
from hdl.build import Build
from hdl.fits import derivatives_layout
from hdl.gradient_step import GradientStep
from hdl.normal_equations import NormalEquations
from sim.engine import EngineName
from sim.stimulus import Stalls, Stimulus
from tests.support.blocks import (
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    check_block,
    columns,
    engine,
    extremes,
    noise,
    packed,
    same,
)
from tests.support.photographs import photograph

STEP = Build.profile("paper", fit="gradient")
SIZES = [(9, 9), (16, 17), (9, 30), (24, 10), (10, 9)]


def streams(frames: list[Array]) -> tuple[dict[str, Any], dict[str, Any]]:
    windows = [
        sliding_window_view(frame, (PIXEL_SIZE, PIXEL_SIZE)).reshape(-1, PIXEL_SIZE, PIXEL_SIZE)
        for frame in frames
    ]
    expected = normal_equations(np.concatenate(windows))
    given = columns(frames, PIXEL_SIZE)
    given["data"] = {"pixel": given["data"]}
    return {"i": given}, {"o": expected._asdict()}


def check(
    frames: list[Array],
    parameters: Build = STEP,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
) -> None:
    check_block((GradientStep, parameters), *streams(frames), name, stalls, window=PIXEL_SIZE)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_sums(name: EngineName, stalls: Stalls) -> None:
    shapes = SIZES if name == "compiled" else [*SIZES[:1], (11, 12)]
    check(noise(shapes, 255, dtype=np.uint8), name=name, stalls=stalls)


@pytest.mark.parametrize("pixel_bits", range(MIN_PIXEL_BITS, MAX_PIXEL_BITS + 1))
def test_extremes(pixel_bits: int) -> None:
    """Black and white of all pixel widths, and gradients all of one size and sign."""
    parameters = replace(STEP, pixel_bits=pixel_bits)
    top = parameters.pixel_max
    frames = extremes((12, 14), top, dtype=np.uint16)
    y, x = np.mgrid[:12, :14]
    for slope in (x + y, x - y, x, y):
        frames += [np.where(slope % 4 < 2, top, 0).astype(np.uint16)]
        frames += [np.where(slope % 4 < 2, 0, top).astype(np.uint16)]
    frames += noise([(60, 70)], top, 1, dtype=np.uint16)
    check(frames, parameters)


def test_reset_in_mid_window_leaves_nothing_of_what_was_before() -> None:
    """The block's only memory of earlier columns that outlives a frame."""
    frames = noise([(20, 21), (14, 15)], 255, 5, dtype=np.uint8)
    block = GradientStep, STEP
    before, after = (packed(block, streams([frame])[0])["i"] for frame in frames)
    expected = packed(block, streams(frames[1:])[1])["o"]
    for cut in (1, 30, 100):
        pixels = np.concatenate([before[:cut], after])
        stimulus = Stimulus({"i": pixels}, [], NO_STALLS, reset_after=cut)
        words = engine("compiled", *block).run(stimulus, quiet=200).outputs["o"]
        same("o", words[len(words) - len(expected) :], expected)


def test_photograph() -> None:
    frames = [photograph("camera")[100:220, 180:340], photograph("brick")[:80, :90]]
    check(frames, stalls=Stalls(inputs=0.2, outputs=0.2, seed=3))


def test_formats_hold_what_the_formulas_can_give() -> None:
    """Gradients that point away from, or to, the lines u = ±v reach the bound of x and y."""
    u, v = np.meshgrid(np.arange(-3, 4), np.arange(-3, 4))
    assert int((np.abs(u) + np.abs(v)).sum()) == LARGEST
    assert largest(STEP).bit_length() == derivative_bits(STEP)
    widths = {name: field.width for name, field in derivatives_layout(STEP)}
    assert widths["x"] == widths["y"] == derivative_bits(STEP) + 1
    assert widths["xx"] == widths["yy"] == widths["xy"] == (49 * 255**2).bit_length() + 1


def test_latency() -> None:
    """Look-up 2, down the column 3, C 1, what enters and leaves 1, changes 1, sums 1, moments 1."""
    assert NormalEquations.latency == 10
