# amaranth: UnusedElaboratable=no
"""Thresholds: T1 and T2 of every frame, and who waits for whom."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Value
from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from golden import thresholds as golden
from golden.formats import CELL_SETTINGS
from golden.parameters import Parameters
from golden.settings import Settings
from hdl.build import Build
from hdl.thresholds import Thresholds, settings_layout
from sim.engine import EngineName, SimulationHang
from sim.stimulus import Capture, Stalls, Stimulus
from tests.support.blocks import (
    ENGINES,
    NO_STALLS,
    RUN_IDS,
    RUNS,
    Array,
    Size,
    Words,
    assert_timing,
    completing,
    engine,
    noise,
    pack,
    pack_samples,
    packed,
    raster,
    run_block,
)
from tests.support.strategies import sigmas

PARAMETERS = Build.profile("paper")
PIXELS = Build.profile("paper", patches="pixels", pixel_bits=10)
MEAN = Build.profile("paper", texture="mean", gradient="signed")
NONE = Build.profile("paper", texture="none")
BUDGET = Build.profile("paper", budget=True)
CELLS = Build.profile("paper", max_per_cell=16)
FULL = PARAMETERS.response_max
LARGEST = 7 * FULL // 9

Frame = tuple[Array, Settings]


def pack_settings(parameters: Parameters, settings: list[Settings]) -> Words:
    fixed = [each.fixed(parameters) for each in settings]
    return pack(
        settings_layout(parameters), {name: np.array([each[name] for each in fixed]) for name in fixed[0]}
    )


def budget_fields(parameters: Parameters, settings: list[Settings]) -> dict[str, Any]:
    if not parameters.budget:
        return {}
    aim = {
        "corners": [each.wanted_corners for each in settings],
        "rank": [each.target_corners == 0 for each in settings],
        "smoothing": [each.smoothing for each in settings],
    }
    return {
        "max_corners": np.array([each.max_corners for each in settings]),
        "aim": {name: np.array(values) for name, values in aim.items()},
    }


def cell_fields(parameters: Parameters, settings: list[Settings]) -> dict[str, Any]:
    if not parameters.max_per_cell:
        return {}
    return {"cells": {name: np.array([getattr(each, name) for each in settings]) for name in CELL_SETTINGS}}


def limits(
    frames: list[Frame], parameters: Parameters, adapted: int | None = None
) -> list[golden.Thresholds]:
    """Frames whose largest response is always :data:`LARGEST`."""
    previous: int | None = None
    result = []
    for _, settings in frames:
        # what is adapted is known of a frame before, or there is nothing
        reference = golden.choose_reference(settings, previous if adapted is None else LARGEST, adapted)
        if adapted is not None and previous is None and not settings.by_rank:
            reference = golden.choose_reference(settings, None)
        result.append(golden.thresholds(settings, reference, parameters, adapted))
        previous = LARGEST
    return result


def check(
    frames: list[Frame],
    parameters: Parameters = PARAMETERS,
    name: EngineName = "compiled",
    stalls: Stalls = NO_STALLS,
    adapted: int | None = None,
) -> Capture:
    beats = packed((Thresholds, parameters), {"i": raster([responses for responses, _ in frames])})["i"]
    expected = limits(frames, parameters, adapted)
    known = 0 if adapted is None else adapted | 1 << parameters.response_bits
    fields = {
        "t1": np.array([limit.t1 for limit in expected]),
        # without a texture filter there is none
        "t2": np.array([limit.t2 * (parameters.algorithm.texture != "none") for limit in expected]),
        "report_rejected": np.array([settings.rejected_too for _, settings in frames]),
        **budget_fields(parameters, [settings for _, settings in frames]),
        **cell_fields(parameters, [settings for _, settings in frames]),
    }
    # a frame waits for the thresholds before: who waits for whom, the tests assert themselves
    return run_block(
        (Thresholds, parameters),
        {"i": beats, "settings": pack_settings(parameters, [settings for _, settings in frames])},
        {"o": beats, "thresholds": fields},
        name,
        stalls,
        levels=[(0, {"largest": LARGEST, **({"adapted": known} if parameters.budget else {})})],
    )


def some_frames(sizes: list[Size], largest: int = FULL, seed: int = 0) -> list[Frame]:
    """Settings of every kind in turn."""
    kinds = [
        Settings(sigma1=0.1, sigma2=0.2, constant=FULL),
        Settings(sigma1=0.999, sigma2=15.99, report_rejected=True),
        Settings(sigma1=0.3, sigma2=8, reference="constant", constant=777, floor=1),
        Settings(sigma1=0, sigma2=0, floor=FULL),
        Settings(sigma1=0.01, sigma2=1.5, floor=40000, constant=50000),
    ]
    return [(responses, kinds[k % len(kinds)]) for k, responses in enumerate(noise(sizes, largest, seed))]


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_frames(name: EngineName, stalls: Stalls) -> None:
    sizes = [(9, 9), (12, 20), (1, 5), (1, 1), (9, 30), (2, 2), (1, 1), (10, 10)]
    capture = check(some_frames(sizes if name == "compiled" else sizes[:5]), name=name, stalls=stalls)
    if stalls == NO_STALLS:
        assert (capture.output_clocks["o"] == capture.input_clocks["i"]).all()


@pytest.mark.parametrize("name", ENGINES)
def test_frames_of_detector_size_never_wait(name: EngineName) -> None:
    """9x9 responses, of a 15x15 frame, are the least there can be."""
    capture = check(some_frames([(9, 9)] * 8), name=name)
    assert_timing(capture, Thresholds.latency)
    first = completing([(9, 9)] * 8, 1)[::81]
    taken = capture.output_clocks["thresholds"] - capture.input_clocks["i"][first]
    assert (taken == Thresholds(PARAMETERS).clocks).all()


@pytest.mark.parametrize("parameters", [PARAMETERS, PIXELS], ids=["regions", "pixels, 10 bits"])
def test_extremes(parameters: Parameters) -> None:
    """The largest sigmas times the largest D; and D = 0 with the least floor."""
    largest = Settings(sigma1=0.99999, sigma2=15.99999, constant=parameters.response_max, floor=1)
    full, empty = np.full((5, 6), parameters.response_max), np.zeros((5, 6), np.int64)
    frames = [(full, largest), (full, largest), (empty, largest), (full, largest), (empty, largest)]
    frames += [(full, replace(largest, reference="constant", constant=1, sigma1=0, sigma2=0))]
    check(frames, parameters)


@pytest.mark.parametrize("name", ENGINES)
def test_cells(name: EngineName) -> None:
    """They come with the thresholds; where they choose, rejected corners are not reported."""
    kinds = [
        Settings(cell_width=8 + 60 * k, cell_height=128 - 30 * k, per_cell=most, report_rejected=rejected)
        for k, (most, rejected) in enumerate([(0, True), (1, True), (16, False)])
    ]
    frames = list(zip(noise([(9, 9)] * 3, FULL), kinds, strict=True))
    check(frames, CELLS, name)


@pytest.mark.parametrize("name", ENGINES)
@pytest.mark.parametrize("adapted", [None, 0, 3, 700, FULL])
def test_adapted(adapted: int | None, name: EngineName) -> None:
    """T1 with a target, at least sigma1 · floor, and T2 as usual; Dref with a rank."""
    settings = Settings(sigma1=0.01, floor=500)
    kinds = [
        replace(settings, target_corners=target, max_corners=most, sigma1=sigma1, reference_rank=rank)
        for target, most, sigma1, rank in (
            *((0, 7, 0.01, 0), (0, 0, 0.2, 32), (1, 0, 0.01, 0), (0, 3, 0.5, 65535)),
            *((65535, 65535, 0.5, 5), (300, 1, 0.0, 0), (0, 0, 0.9, 1)),
        )
    ]
    kinds += [
        replace(kinds[1], reference="constant", constant=999, smoothing=3),
        replace(kinds[0], smoothing=1),
    ]
    sizes = [(3, 12)] * len(kinds)
    frames = [(responses, kind) for responses, kind in zip(noise(sizes, FULL), kinds, strict=True)]
    capture = check(frames, BUDGET, name, adapted=adapted)
    first = completing(sizes, 1)[::36]
    taken = capture.output_clocks["thresholds"] - capture.input_clocks["i"][first]
    assert (taken == Thresholds(BUDGET).clocks).all()


def test_a_frame_waits_until_it_is_adapted() -> None:
    frames = [(responses, Settings()) for responses in noise([(2, 5)], FULL)]
    inputs = {
        "i": pack_samples(
            Thresholds(BUDGET).i.payload.shape(), raster([responses for responses, _ in frames])
        ),
        "settings": pack_settings(BUDGET, [settings for _, settings in frames]),
    }
    with pytest.raises(SimulationHang, match="i 0 of 10 in"):
        engine("compiled", Thresholds, BUDGET).run(Stimulus(inputs, [(0, {"adapting": 1})]), max_clocks=200)


@pytest.mark.parametrize("name", ENGINES)
def test_by_hand(name: EngineName) -> None:
    """Constant, since it is the first; then the largest; then the floor; then the constant."""
    some = np.array([[3, 7, 1000]])
    quarter = Settings(sigma1=0.25, sigma2=0.5, constant=400, floor=10)
    frames = [
        (some, quarter),
        (some, quarter),
        (some, replace(quarter, floor=60_000)),
        (some, replace(quarter, reference="constant")),
        (some, replace(quarter, reference="constant", floor=500)),
    ]
    # T2 is in ninths
    assert LARGEST == 50_575
    by_hand = [(100, 1800), (12_643, 227_587), (15_000, 270_000), (100, 1800), (125, 2250)]
    assert limits(frames, PARAMETERS) == by_hand
    check(frames, name=name)


@given(st.data())
@hypothesis_settings(max_examples=60)
def test_any_frames(data: st.DataObject) -> None:
    response = st.integers(1, FULL)
    settings = st.builds(
        Settings,
        sigma1=sigmas(0.99999),
        sigma2=sigmas(15.99999),
        reference=st.sampled_from(["previous", "constant"]),
        constant=response,
        floor=response,
        report_rejected=st.booleans(),
    )
    size = st.tuples(st.integers(1, 6), st.integers(1, 30))
    drawn = data.draw(st.lists(st.tuples(size, settings), min_size=1, max_size=6))
    largest = data.draw(st.sampled_from([0, 1, 1000, FULL]))
    responses = noise([size for size, _ in drawn], largest, len(drawn))
    chance = st.sampled_from([0.0, 0.3, 0.9, 0.99])
    stalls = data.draw(st.builds(Stalls, chance, chance, st.integers(0, 1000)))
    check([(frame, each) for frame, (_, each) in zip(responses, drawn, strict=True)], stalls=stalls)


def test_the_next_frame_waits_until_the_thresholds_are_taken() -> None:
    """Thresholds of the first frame are not taken: it passes, the second waits, none is lost."""
    dut = Thresholds(PARAMETERS)
    frames = some_frames([(3, 12), (3, 12)])
    beats = pack_samples(dut.i.payload.shape(), raster([responses for responses, _ in frames])).tolist()
    packed = pack_settings(PARAMETERS, [settings for _, settings in frames])
    settings = [int.from_bytes(row.tobytes(), "little") for row in packed]
    waits_until = 500
    passed: list[tuple[int, int]] = []
    taken: list[golden.Thresholds] = []

    async def bench(ctx: Any) -> None:
        ctx.set(dut.o.ready, 1)
        ctx.set(dut.largest, LARGEST)
        left = {dut.i: list(beats), dut.settings: list(settings)}
        for clock in range(700):
            for port, values in left.items():
                ctx.set(port.valid, bool(values))
                if values:
                    ctx.set(Value.cast(port.payload), values[0])
            ctx.set(dut.thresholds.ready, clock >= waits_until)
            if 100 < clock < waits_until:
                assert len(passed) == 36 and not ctx.get(dut.i.ready) and not ctx.get(dut.o.valid)
            if ctx.get(dut.o.valid):
                passed.append((clock, ctx.get(Value.cast(dut.o.payload))))
            if clock >= waits_until and ctx.get(dut.thresholds.valid):
                limit = ctx.get(dut.thresholds.payload)
                taken.append(golden.Thresholds(limit.t1, limit.t2))
            for port, values in left.items():
                if values and ctx.get(port.ready):
                    values.pop(0)
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert [beat for _, beat in passed] == beats
    assert [clock for clock, _ in passed[36:]] == list(range(waits_until + 2, waits_until + 38))
    assert taken == limits(frames, PARAMETERS)


@pytest.mark.parametrize("name", ENGINES)
def test_weight_of_the_local_level(name: EngineName) -> None:
    """With an adaptive threshold T2 is sigma2 in eighths, at most 15, for any responses."""
    sigmas = (0, 0.1249, 0.125, 0.5, 1.874, 1.875, 1.999, 2, 3.5, 4, 8, 15.99)
    frames = noise([(1, 30)] * len(sigmas), MEAN.response_max, 3)
    given = [(frame, Settings(sigma1=0.1, sigma2=s)) for frame, s in zip(frames, sigmas, strict=True)]
    assert [limit.t2 for limit in limits(given, MEAN)] == [0, 0, 1, 4, 14, 15, 15, 15, 15, 15, 15, 15]
    check(given, MEAN, name)


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_frames_with_an_adaptive_threshold(name: EngineName, stalls: Stalls) -> None:
    sizes = [(9, 9), (12, 20), (1, 5), (1, 1), (9, 30)]
    check(some_frames(sizes, MEAN.response_max), MEAN, name, stalls)


@pytest.mark.parametrize("stalls", [NO_STALLS, Stalls(inputs=0.3, outputs=0.4, seed=13)], ids=str)
def test_without_a_texture_filter_there_is_t1_alone(stalls: Stalls) -> None:
    """It is there four clocks sooner: sigma1 has four bits less than sigma2."""
    sizes = [(3, 30), (1, 40), (2, 50), (4, 30), (2, 33)]
    check(some_frames(sizes, NONE.response_max), NONE, stalls=stalls)
    assert Thresholds(NONE).clocks == Thresholds(PARAMETERS).clocks - 4 == 19
