# amaranth: UnusedElaboratable=no
"""Frame control: rows and frames from a bare stream of pixels, and settings per frame."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.sim import Simulator
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.parameters import Parameters
from hdl.build import Build
from hdl.frame_control import FrameControl
from sim.engine import EngineName
from sim.stimulus import Capture, Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, Size, check_block, noise, raster

# settings of 4-bit pixels fit the one word in which plain inputs are set
ODD = Build.profile("paper", pixel_bits=4, max_width=37, max_height=21)
POWERS = Build.profile("paper", pixel_bits=4, max_width=32, max_height=16)
SETTINGS_BITS = 16 + 20 + 1 + 8 + 8 + 1

Levels = list[tuple[int, dict[str, int]]]


def clamped(size: Size, parameters: Parameters) -> Size:
    height, width = size
    least = parameters.algorithm.support
    return min(max(height, least), parameters.max_height), min(max(width, least), parameters.max_width)


def check(
    asked: list[Size],
    parameters: Parameters = ODD,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    *,
    meddle: bool = False,
) -> Capture:
    """Frames of the nearest allowed size; ``meddle``: inputs change after the first pixel."""
    rng = np.random.default_rng(len(asked))
    frames = noise([clamped(size, parameters) for size in asked], parameters.pixel_max)
    latched = rng.integers(0, 1 << SETTINGS_BITS, len(asked)).tolist()
    levels: Levels = []
    start = 0
    for (height, width), frame, word in zip(asked, frames, latched, strict=True):
        levels.append((start, {"width": width, "height": height, "next_settings": word}))
        if meddle:
            levels.append((start + 1, {"width": 17, "height": 18, "next_settings": word ^ 0x5555}))
            levels.append((start + frame.size - 1, {"width": 30, "height": 16, "next_settings": word >> 1}))
        start += frame.size
    beats = raster(frames)
    capture = check_block(
        (FrameControl, parameters),
        {"i": beats["data"]},
        {"o": beats, "settings": np.array(latched, np.uint64)},
        name,
        stalls,
        levels=levels,
    )
    if stalls == NO_STALLS:
        firsts = np.cumsum([0, *(frame.size for frame in frames)])[:-1]
        assert np.array_equal(capture.output_clocks["settings"], capture.input_clocks["i"][firsts] + 1)
    return capture


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_frames(name: EngineName, stalls: Stalls) -> None:
    sizes = [(15, 15), (21, 37), (15, 37), (21, 15), (16, 20)]
    check(sizes if name == "compiled" else sizes[:2], name=name, stalls=stalls)


@pytest.mark.parametrize("parameters", [ODD, POWERS], ids=["odd maximum", "powers of two"])
def test_sizes_out_of_range(parameters: Parameters) -> None:
    """From nothing to all ones: the nearest that is allowed."""
    height, width = parameters.max_height, parameters.max_width
    all_ones = (1 << height.bit_length()) - 1, (1 << width.bit_length()) - 1
    asked = [(0, 0), (14, 14), (15, 15), (16, 16), (height - 1, width - 1), (height, width)]
    asked += [(all_ones[0], 0), (0, all_ones[1]), all_ones, (height, 3), (3, width)]
    check(asked, parameters)
    check([(min(height + 1, all_ones[0]), min(width + 1, all_ones[1])), (20, 20)], parameters)


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(0.4, 0.4, 1)], ids=["unstalled", "stalled"])
def test_everything_is_sampled_with_the_first_pixel_only(stalls: Stalls) -> None:
    check([(15, 20), (20, 15), (21, 37), (15, 15)], stalls=stalls, meddle=True)


@given(st.data())
@settings(max_examples=40)
def test_any_sizes_and_stalls(data: st.DataObject) -> None:
    size = st.tuples(st.integers(0, 31), st.integers(0, 63))
    chance = st.sampled_from([0.0, 0.3, 0.9])
    check(
        data.draw(st.lists(size, min_size=1, max_size=5)),
        stalls=data.draw(st.builds(Stalls, chance, chance, st.integers(0, 1000))),
        meddle=data.draw(st.booleans()),
    )


def test_a_first_pixel_waits_until_the_settings_before_are_taken_which_stay_as_they_are() -> None:
    dut = FrameControl(ODD)

    async def bench(ctx: Any) -> None:
        def ask(size: int, constant: int) -> None:
            ctx.set(dut.width, size)
            ctx.set(dut.height, size)
            ctx.set(dut.next_settings.constant, constant)

        ctx.set(dut.o.ready, 1)
        ctx.set(dut.i.valid, 1)
        ask(15, 11)
        taken = 0
        for _ in range(300):
            taken += ctx.get(dut.i.ready)
            await ctx.tick()
            ask(20, 22)
        # the whole first frame, and nothing of the second, whose settings are not sampled yet
        assert taken == 225 and not ctx.get(dut.i.ready)
        assert ctx.get(dut.settings.valid) and ctx.get(dut.settings.payload.constant) == 11
        ctx.set(dut.settings.ready, 1)
        await ctx.tick()
        ctx.set(dut.settings.ready, 0)
        ends = []
        for clock in range(420):
            if ctx.get(dut.o.valid) and ctx.get(dut.o.payload.eol):
                ends.append(clock)
            await ctx.tick()
            ask(17, 33)
        assert ctx.get(dut.settings.valid) and ctx.get(dut.settings.payload.constant) == 22
        assert len(ends) == 20 and set(np.diff(ends)) == {20}

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()


def test_latency() -> None:
    assert FrameControl.latency == 1
