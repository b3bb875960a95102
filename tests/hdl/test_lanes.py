# amaranth: UnusedElaboratable=no
"""Blocks from pixels to responses with several pixels per clock, each against the golden model.

Lanes that hold nothing complete, and those beyond the width, go in as noise and are not compared.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view

from golden.convolution import smooth
from golden.pixel_filter import pixel_filter
from golden.preprocessing import gradients, products
from golden.response import response
from hdl.build import Build
from hdl.convolution import Convolution
from hdl.pixel_filter import PixelFilter
from hdl.preprocessing import Preprocessing
from hdl.response import Response
from sim.stimulus import Stalls
from tests.support.beats import LANES_IN_TURN, in_beats
from tests.support.blocks import NO_STALLS, Array, check_block, noise, pack, tags

STALLS = pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.3, 0.4, 13)], ids=["unstalled", "both-stall"])
PROFILES = pytest.mark.parametrize("profile", ["paper", "robust"])
LANE = pytest.mark.parametrize("lanes", LANES_IN_TURN)


def size_members(lanes: int) -> tuple[str, ...]:
    return ("gx", "gy") if lanes > 1 else ("gx", "gy", "difference")


def build(profile: str, lanes: int) -> Build:
    return Build.profile(profile, pixels_per_clock=lanes)


def images(lanes: int) -> list[Array]:
    """Every remainder of the width, narrow ones too, back to back."""
    return noise([(9 + k % 4, 25 + k) for k in range(lanes + 1)], 255, dtype=np.uint8)


def fields(frames: list[Array], members: tuple[str, ...], rows: int) -> dict[str, Any]:
    """Beats of (height, beats, ...) frames, or columns of so many rows of them."""
    if rows:
        frames = [np.moveaxis(sliding_window_view(frame, rows, axis=0), -1, 2) for frame in frames]
    values = np.concatenate([frame.reshape(-1, *frame.shape[2:]) for frame in frames])
    data = {name: values[..., k] for k, name in enumerate(members)} if members else values
    return {"data": data, **tags([(len(frame), frame.shape[1]) for frame in frames])}


def check(
    block: tuple[Any, ...],
    given: list[Array],
    expected: list[Array],
    stalls: Stalls,
    *,
    lost: tuple[int, int],
    rows: tuple[int, int],
    members: tuple[tuple[str, ...], tuple[str, ...]] = ((), ()),
) -> None:
    """Frames through a block; pairs are of its input and of its output.

    ``lost``: columns of a row that completed nothing; ``rows``: of columns, 0 where there are none.
    """
    lanes = block[1].pixels_per_clock
    inputs, _ = in_beats(given, lanes, lost=lost[0], largest=15)
    outputs, counting = in_beats(expected, lanes, lost=lost[1], largest=0)
    make, *arguments = block
    shape = make(*arguments).o.payload.shape()
    marks = fields([np.where(counts, -1, 0) for counts in counting], members[1], rows[1])
    ends = {name: -np.ones_like(marks[name]) for name in ("eol", "eof")}
    check_block(
        block,
        {"i": fields(inputs, members[0], rows[0])},
        {"o": pack(shape, fields(outputs, members[1], rows[1]))},
        stalls=stalls,
        window=lost[1] // lanes - lost[0] // lanes + 1,
        counting={"o": pack(shape, marks | ends)},
    )


@STALLS
@pytest.mark.parametrize("passes", [0, 1])
@LANE
def test_pixel_filter(lanes: int, passes: int, stalls: Stalls) -> None:
    frames = images(lanes)
    smoothed = [pixel_filter(frame.astype(np.uint16), 1).astype(np.int64) for frame in frames]
    block = PixelFilter, build("paper", lanes), 2 * passes
    check(block, frames, smoothed, stalls, lost=(2 * passes, 2 * passes + 2), rows=(3, 0))


def sizes(image: Array, parameters: Build) -> Array:
    """Sizes with one pixel per clock, otherwise numbers of these sizes."""
    algorithm = parameters.algorithm
    gx, gy = (values.astype(np.int64) for values in gradients(image, algorithm.derivative))
    apart = (algorithm.gradient == "absolute") & ((gx < 0) != (gy < 0))
    if parameters.pixels_per_clock > 1:
        return np.stack([gx, gy], axis=-1)
    return np.abs(np.stack([gx, gy, np.where(apart, gx + gy, gx - gy)], axis=-1))


@STALLS
@PROFILES
@LANE
def test_preprocessing(lanes: int, profile: str, stalls: Stalls) -> None:
    parameters = build(profile, lanes)
    frames = images(lanes)
    expected = [sizes(frame, parameters) for frame in frames]
    lost = 2 * parameters.algorithm.pixel_passes
    check(
        (Preprocessing, parameters),
        frames,
        expected,
        stalls,
        lost=(lost, lost + 2),
        rows=(7, 5),
        members=((), size_members(lanes)),
    )


def tensors(image: Array, parameters: Build) -> Array:
    algorithm = parameters.algorithm
    return smoothed(*gradients(image, algorithm.derivative), parameters)


def smoothed(gx: Array, gy: Array, parameters: Build) -> Array:
    channels = products(gx, gy, parameters.algorithm.gradient)
    return np.stack([smooth(channel) for channel in channels], axis=-1)


@STALLS
@PROFILES
@LANE
def test_convolution(lanes: int, profile: str, stalls: Stalls) -> None:
    parameters = build(profile, lanes)
    frames = images(lanes)
    lost = 2 * parameters.algorithm.response_margin
    check(
        (Convolution, parameters),
        [sizes(frame, parameters) for frame in frames],
        [tensors(frame, parameters) for frame in frames],
        stalls,
        lost=(lost - 4, lost),
        rows=(5, 0),
        members=(size_members(lanes), ("a", "b", "c")),
    )


@LANE
def test_convolution_halves(lanes: int) -> None:
    """C is 4 times a product over 64: of 8 one half, of 24 1.5; and around both, of either sign."""
    parameters = build("robust", lanes)
    centres = [7, 8, 9, 23, 24, 25, -7, -8, -9, -23, -24, -25, 0]
    gx = np.zeros((5, 5 * len(centres)), np.int64)
    gx[2, 2::5] = centres
    gy = (gx != 0).astype(np.int64)
    numbers = np.stack([gx, gy], axis=-1) if lanes > 1 else np.abs(np.stack([gx, gy, gx - gy], axis=-1))
    expected = smoothed(gx, gy, parameters)
    assert expected[0, ::5, 2].tolist() == [0, 1, 1, 1, 2, 2, 0, -1, -1, -1, -2, -2, 0]
    lost = 2 * parameters.algorithm.response_margin
    check(
        (Convolution, parameters),
        [numbers],
        [expected],
        NO_STALLS,
        lost=(lost - 4, lost),
        rows=(5, 0),
        members=(size_members(lanes), ("a", "b", "c")),
    )


@STALLS
@PROFILES
@LANE
def test_response(lanes: int, profile: str, stalls: Stalls) -> None:
    parameters = build(profile, lanes)
    given = [tensors(frame, parameters) for frame in images(lanes)]
    expected = [response(*np.moveaxis(frame, -1, 0), parameters)[..., None] for frame in given]
    lost = 2 * parameters.algorithm.response_margin
    check(
        (Response, parameters),
        given,
        expected,
        stalls,
        lost=(lost, lost),
        rows=(0, 0),
        members=(("a", "b", "c"), ("response",)),
    )
