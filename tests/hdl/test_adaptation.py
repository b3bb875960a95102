# amaranth: UnusedElaboratable=no
"""Adaptation: T1 from the histogram of any frames, back to back and with pauses."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.sim import Simulator
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.adaptation import COUNT_MAX, adapted_threshold, bin_edges, bins, histogram, smoothed
from golden.parameters import Parameters
from hdl.adaptation import Adaptation
from hdl.build import Build
from tests.support.blocks import Array

PARAMETERS = [
    Build.profile("paper", budget=True),
    Build.profile("paper", budget=True, gradient="signed"),
    Build.profile("paper", budget=True, pixel_bits=4),
    Build.profile("paper", budget=True, gradient="signed", pixel_bits=10),
]
IDS = ["8 bits", "8 bits signed", "4 bits", "10 bits signed"]
Frame = tuple[Array, int]
"""Responses in their order, and the target."""
Adapted = tuple[int, bool]


def expected(frames: list[Frame], parameters: Parameters, smoothing: int = 0) -> list[Adapted]:
    results: list[Adapted] = []
    before, known = 0, False
    for responses, target in frames:
        now = adapted_threshold(histogram(responses, parameters), target, parameters) if target else 0
        before, known = smoothed(before, now, smoothing) if known and target else now, target > 0
        results.append((before, known))
    return results


def simulate(
    frames: list[Frame],
    parameters: Parameters,
    *,
    history: Adapted = (0, False),
    seed: int | None = None,
    smoothing: int = 0,
) -> list[Adapted]:
    """What is known after reset, and after each frame.

    Corners come two clocks apart, the last one together with the frame's end and the next frame's
    first as soon as the block is not busy; with a ``seed`` all of that a random time later.
    """
    dut = Adaptation(parameters)
    rng = np.random.default_rng(seed)
    results: list[Adapted] = []

    async def wait(ctx: Any) -> None:
        if seed is not None:
            for _ in range(int(rng.integers(4))):
                await ctx.tick()

    async def settle(ctx: Any) -> None:
        clocks = 0
        while ctx.get(dut.busy):
            clocks += 1
            await ctx.tick()
        assert clocks == dut.clocks
        adapted = ctx.get(dut.adapted)
        results.append((adapted.t1, bool(adapted.known)))
        await wait(ctx)

    async def bench(ctx: Any) -> None:
        ctx.set(dut.history, {"t1": history[0], "known": history[1]})
        await settle(ctx)
        for responses, target in frames:
            for number, response in enumerate(responses.tolist()):
                last = number == len(responses) - 1 and (seed is None or bool(rng.integers(2)))
                ctx.set(dut.corner, 1)
                ctx.set(dut.strength, response)
                ctx.set(dut.last, last)
                ctx.set(dut.aim, {"corners": 0, "smoothing": 0})
                await ctx.tick()
                ctx.set(dut.corner, 0)
                ctx.set(dut.last, 0)
                if last:
                    break
                await ctx.tick()
                await wait(ctx)
            else:
                ctx.set(dut.last, 1)
                await ctx.tick()
                ctx.set(dut.last, 0)
            ctx.set(dut.aim, {"corners": target, "smoothing": smoothing})
            await settle(ctx)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return results


def check(frames: list[Frame], parameters: Parameters, seed: int | None = None, smoothing: int = 0) -> None:
    got = simulate(frames, parameters, seed=seed, smoothing=smoothing)
    want = expected(frames, parameters, smoothing)
    assert got[0] == (0, False)
    assert [known for _, known in got[1:]] == [known for _, known in want]
    known = [k for k, (_, known) in enumerate(want) if known]
    assert [got[1 + k] for k in known] == [want[k] for k in known]


@pytest.mark.parametrize("parameters", PARAMETERS, ids=IDS)
def test_every_edge(parameters: Parameters) -> None:
    """The smallest and the largest D of every bin, every one of them the one that is wanted."""
    edges = np.array(bin_edges(parameters))
    responses = np.unique(np.concatenate([edges[:-1], edges[1:] - 1]))[1:]
    frames = [(responses, target) for target in (1, 2, 3, len(responses) - 1, len(responses))]
    frames += [(np.repeat(edges[k], 8), target) for k in (1, 5, -2) for target in (1, 7, 8, 9)]
    check(frames, parameters)


@pytest.mark.parametrize("parameters", PARAMETERS, ids=IDS)
@pytest.mark.parametrize("seed", [None, 1])
def test_noise(parameters: Parameters, seed: int | None) -> None:
    """Responses of every size, so that bins repeat at once and later.

    Some frames have no corner, some no target.
    """
    rng = np.random.default_rng(7)
    frames: list[Frame] = []
    for target in (0, 5, 100, 0, 300, 1, 65535, 40):
        count = int(rng.integers(0, 400))
        responses = np.exp2(rng.random(count) * parameters.response_bits).astype(np.int64)
        frames.append((np.minimum(responses, parameters.response_max), target))
        frames.append((np.zeros(0, np.int64), 10))
    check(frames, parameters, seed)


@given(st.data())
@settings(max_examples=25)
def test_any_frames(data: st.DataObject) -> None:
    parameters = data.draw(st.sampled_from(PARAMETERS))
    responses = st.lists(st.integers(1, parameters.response_max), max_size=12)
    few = st.lists(st.sampled_from([1, 100, 101, parameters.response_max]), max_size=30)
    frame = st.tuples(st.one_of(responses, few).map(np.array), st.integers(0, 20))
    frames = data.draw(st.lists(frame, min_size=1, max_size=4))
    seed, smoothing = data.draw(st.one_of(st.none(), st.integers(0, 99))), data.draw(st.integers(0, 3))
    check(frames, parameters, seed, smoothing)


@pytest.mark.parametrize("smoothing", [1, 2, 3])
def test_smoothing(smoothing: int) -> None:
    """Two scenes in turn; a first frame is taken unsmoothed, also after one without a target."""
    p = PARAMETERS[1]
    bright, dark = np.array([p.response_max, 90_000, 500]), np.array([700, 300, 8])
    frames = [(scene, target) for target in (2, 0, 2) for scene in (dark, bright, bright, dark, dark)]
    check(frames, p, smoothing=smoothing)
    levels = [t1 for t1, _ in expected(frames[:3], p, smoothing)]
    assert (
        levels[0] == expected([(dark, 2)], p)[0][0] < levels[1] < levels[2] < expected([(bright, 2)], p)[0][0]
    )


def test_what_history_says_holds_after_reset() -> None:
    frames = [(np.array([1000, 2000, 3000]), 2), (np.array([7]), 0)]
    got = simulate(frames, PARAMETERS[0], history=(4321, True))
    assert got[0] == (4321, True) and got[1] == expected(frames, PARAMETERS[0])[0] and not got[2][1]


@pytest.mark.verify
def test_a_bin_that_is_full_stays_full() -> None:
    parameters = PARAMETERS[0]
    responses = np.repeat(5000, COUNT_MAX + 3)
    assert histogram(responses, parameters).max() == COUNT_MAX
    check([(responses, COUNT_MAX), (responses[:10], 5)], parameters)


def test_clocks() -> None:
    """Short enough for the least frame: see the detector's test of its rate."""
    assert [bins(parameters) for parameters in PARAMETERS] == [48, 48, 16, 48]
    assert Adaptation(PARAMETERS[0]).clocks == 64
