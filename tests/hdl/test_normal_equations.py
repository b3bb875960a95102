# amaranth: UnusedElaboratable=no
"""Normal equations of one window after the other, for every pixel width."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from golden.formats import MAX_PIXEL_BITS, MIN_PIXEL_BITS
from golden.normal_equations import (
    FARTHEST,
    PIXEL_SIZE,
    PLACE_BITS,
    STEP_SIZE,
    centre,
    normal_equations,
)
from hdl.build import Build
from hdl.normal_equations import PASSES, PAUSE, ROWS, NormalEquations, first_complete, pass_beats
from hdl.step_layouts import columns_read
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, Array, extremes, run_block

STEP = Build.profile("paper", fit="gradient")

BUILDS = {lanes: STEP.changed(pixels_per_clock=lanes) for lanes in (1, 2, 4)}


def beats_of(build: Build) -> int:
    """Of a window, with its pause."""
    return PASSES * pass_beats(build) + PAUSE


def places(count: int, seed: int = 0) -> tuple[Array, Array]:
    """Of windows, with all the fractions there are and both ends among the first ones."""
    rng = np.random.default_rng(seed)
    x, y = (rng.integers(-FARTHEST, FARTHEST, count, endpoint=True) for _ in range(2))
    x[:32], y[:32] = np.arange(-16, 16)[: len(x)], np.resize([-FARTHEST, 0, 7, 8, -8, FARTHEST], len(y[:32]))
    return x, y


def swept(pixels: Array, x_place: Array, y_place: Array, build: Build) -> dict[str, Any]:
    """Beats of (n, 15, 15) pixels as they come to the block, with a pause behind each window."""
    rows, lanes, in_pass = ROWS + 2, columns_read(build), pass_beats(build)
    count, beats = len(pixels), beats_of(build)
    # below the last pass there is a row that does not matter, before a pass there may be columns
    wide = np.pad(pixels, ((0, 0), (0, 1), (8, 0)), mode="reflect")
    columns = np.zeros((count, beats, rows, lanes), np.int64)
    tags = {
        name: np.zeros((count, beats), np.int64) for name in ("complete", "left", "right", "top", "bottom")
    }
    weights = {"x": x_place, "y": y_place}
    first_column = 8 + PIXEL_SIZE // 2 + STEP_SIZE // 2 + 2 - in_pass * lanes
    first_row = PIXEL_SIZE // 2 - STEP_SIZE // 2 - 1
    for number in range(PASSES):
        for beat in range(in_pass):
            at = number * in_pass + beat
            for k in range(rows):
                for lane in range(lanes):
                    columns[:, at, k, lane] = wide[
                        np.arange(count),
                        first_row + ROWS * number + k + centre(y_place),
                        first_column + lanes * beat + lane + centre(x_place),
                    ]
            complete = beat >= first_complete(build)
            for name, here in (
                ("complete", complete),
                ("left", beat == first_complete(build)),
                ("right", beat == in_pass - 1),
                ("top", complete and number == 0),
                ("bottom", complete and number == PASSES - 1),
            ):
                tags[name][:, at] = here
    fractions = {name: np.repeat((w + 8) % (1 << PLACE_BITS), beats) for name, w in weights.items()}
    # what is not the window's first gradients has any weights
    first = (tags["left"] & tags["top"]).reshape(-1) == 1
    noise = np.random.default_rng(count).integers(0, 16, len(first))
    fractions = {name: np.where(first, w, noise) for name, w in fractions.items()}
    given = columns.reshape(-1, rows, lanes) if lanes > 1 else columns.reshape(-1, rows)
    return {"pixels": given, **{k: v.reshape(-1) for k, v in tags.items()}, **fractions}


def check(
    pixels: Array,
    parameters: Build = STEP,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    seed: int = 0,
) -> Any:
    x, y = places(len(pixels), seed)
    expected = normal_equations(pixels, x, y)._asdict()
    return run_block(
        (NormalEquations, parameters),
        {"i": swept(pixels, x, y, parameters)},
        {"o": expected},
        name,
        stalls,
        clocks=2,
    )


def windows(count: int, top: int, seed: int) -> Array:
    rng = np.random.default_rng(seed)
    return rng.integers(0, top, (count, PIXEL_SIZE, PIXEL_SIZE), np.uint16, endpoint=True)


@pytest.mark.parametrize("lanes", BUILDS)
@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_sums(name: EngineName, stalls: Stalls, lanes: int) -> None:
    count, build = 60 if name == "compiled" else 6, BUILDS[lanes]
    capture = check(windows(count, 255, 0), build, name, stalls)
    if stalls == NO_STALLS:
        last = np.arange(count) * beats_of(build) + PASSES * pass_beats(build) - 1
        late = capture.output_clocks["o"] - capture.input_clocks["i"][last]
        assert (late == NormalEquations(build).latency).all()


@pytest.mark.parametrize(
    ("pixel_bits", "lanes"),
    [
        *((bits, 1) for bits in range(MIN_PIXEL_BITS, MAX_PIXEL_BITS + 1)),
        *((bits, lanes) for bits in (MIN_PIXEL_BITS, MAX_PIXEL_BITS) for lanes in (2, 4)),
    ],
)
def test_extremes(pixel_bits: int, lanes: int) -> None:
    """Black and white of all pixel widths, and gradients all of one size and sign."""
    parameters = BUILDS[lanes].changed(pixel_bits=pixel_bits)
    top = parameters.pixel_max
    frames = extremes((PIXEL_SIZE, PIXEL_SIZE), top, dtype=np.uint16)
    y, x = np.mgrid[:PIXEL_SIZE, :PIXEL_SIZE]
    for slope in (x + y, x - y, x, y):
        frames += [np.where(slope % 4 < 2, top, 0).astype(np.uint16)]
        frames += [np.where(slope % 4 < 2, 0, top).astype(np.uint16)]
    check(np.concatenate([np.stack(frames), windows(60, top, 1)]), parameters)
