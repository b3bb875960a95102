"""All engines take the same stimulus to the same beats in the same clocks."""

from __future__ import annotations

import numpy as np
import pytest

from sim import Capture, EngineName, SimulationHang, Stalls, Stimulus, StreamError
from tests.sim.conftest import EngineFor

FAST: tuple[EngineName, ...] = ("amaranth", "compiled")
ALL: tuple[EngineName, ...] = ("amaranth", "compiled", "verilog")
STALLS = [Stalls(), Stalls(0.5, 0.0, 1), Stalls(0.0, 0.6, 2), Stalls(0.3, 0.4, 3)]


def beats(count: int, bits: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).integers(0, 1 << bits, count, dtype=np.uint64)


def assert_same(first: Capture, second: Capture) -> None:
    """Equal in everything that is not time on the wall."""
    assert first.clocks == second.clocks
    for left, right in (
        (first.outputs, second.outputs),
        (first.output_clocks, second.output_clocks),
        (first.input_clocks, second.input_clocks),
    ):
        assert left.keys() == right.keys()
        for name in left:
            np.testing.assert_array_equal(left[name], right[name])


@pytest.mark.parametrize("stalls", STALLS, ids=str)
def test_slice_passes_every_beat_in_the_same_clock(engine_for: EngineFor, stalls: Stalls) -> None:
    values = beats(200, 8)
    stimulus = Stimulus({"i": values}, stalls=stalls)
    runs = [engine_for(kind, "slice").run(stimulus, quiet=20) for kind in ALL]
    for run in runs:
        np.testing.assert_array_equal(run.outputs["o"], (values + 3) % 256)
        assert_same(run, runs[0])


def test_without_stalls_one_beat_moves_per_clock(engine_for: EngineFor) -> None:
    for kind in FAST:
        run = engine_for(kind, "slice").run(Stimulus({"i": beats(50, 8)}), quiet=7)
        np.testing.assert_array_equal(run.input_clocks["i"], np.arange(50))
        np.testing.assert_array_equal(run.output_clocks["o"], np.arange(50) + 1)
        # the last beat leaves in clock 50
        assert run.clocks == 51 + 7


def test_stalls_stall(engine_for: EngineFor) -> None:
    for stalls in (Stalls(inputs=0.5), Stalls(outputs=0.5)):
        run = engine_for("compiled", "slice").run(Stimulus({"i": beats(2000, 8)}, stalls=stalls))
        last = run.output_clocks["o"][-1]
        assert 1.8 < last / 2000 < 2.2


@pytest.mark.parametrize("stalls", STALLS, ids=str)
def test_payloads_wider_than_a_word(engine_for: EngineFor, stalls: Stalls) -> None:
    values = np.stack([beats(60, 63, 1), beats(60, 63, 2), beats(60, 2, 3)], axis=1)
    values[:5, 0] = np.uint64(2**64 - 1)  # carries into the next word
    stimulus = Stimulus({"i": values}, [(0, {"offset": 1})], stalls)
    runs = [engine_for(kind, "wide slice").run(stimulus, quiet=20) for kind in ALL]

    def integers(rows: np.ndarray) -> list[int]:
        return [sum(int(word) << 64 * k for k, word in enumerate(row)) for row in rows]

    assert runs[0].outputs["o"].shape == (60, 3)
    assert integers(runs[0].outputs["o"]) == [(value + 1) % (1 << 130) for value in integers(values)]
    for run in runs[1:]:
        assert_same(run, runs[0])


@pytest.mark.parametrize("stalls", STALLS, ids=str)
def test_two_input_streams(engine_for: EngineFor, stalls: Stalls) -> None:
    a, b = beats(100, 8, 1), beats(100, 8, 2)
    runs = [
        engine_for(kind, "adder").run(Stimulus({"a": a, "b": b}, stalls=stalls), quiet=20) for kind in FAST
    ]
    np.testing.assert_array_equal(
        runs[0].outputs["o"], (a + b) | (np.arange(100, dtype=np.uint64) << np.uint64(9))
    )
    np.testing.assert_array_equal(runs[0].input_clocks["a"], runs[0].input_clocks["b"])
    assert_same(runs[0], runs[1])


@pytest.mark.parametrize("stalls", STALLS[::3], ids=str)
def test_memories(engine_for: EngineFor, stalls: Stalls) -> None:
    values = beats(150, 12)
    runs = [
        engine_for(kind, "line delay").run(Stimulus({"i": values}, stalls=stalls), quiet=20) for kind in ALL
    ]
    for run in runs:
        # five beats of initial contents come first
        np.testing.assert_array_equal(run.outputs["o"], np.concatenate([np.arange(5), values])[:150])
        assert_same(run, runs[0])


def test_streams_that_are_always_ready_and_no_clock(engine_for: EngineFor) -> None:
    values = beats(50, 8)
    stimulus = Stimulus({"i": values}, stalls=Stalls(0.3, 0.3, 1))
    runs = [engine_for(kind, "inverter").run(stimulus, quiet=5) for kind in FAST]
    np.testing.assert_array_equal(runs[0].outputs["o"], 255 - values)
    assert_same(runs[0], runs[1])


def test_no_input_streams(engine_for: EngineFor) -> None:
    runs = [
        engine_for(kind, "generator").run(Stimulus({}, stalls=Stalls(0, 0.5, 4)), quiet=30) for kind in FAST
    ]
    np.testing.assert_array_equal(runs[0].outputs["o"], np.arange(9, 0, -1))
    assert_same(runs[0], runs[1])


@pytest.mark.parametrize("stalls", STALLS[::3], ids=str)
def test_levels_change_with_the_beat_they_belong_to(engine_for: EngineFor, stalls: Stalls) -> None:
    values = np.zeros(30, np.uint64)
    changes = [(20, {"offset": 30}), (0, {"offset": 10}), (10, {"offset": 20})]
    runs = [
        engine_for(kind, "slice").run(Stimulus({"i": values}, changes, stalls), quiet=20) for kind in FAST
    ]
    np.testing.assert_array_equal(runs[0].outputs["o"], np.repeat([10, 20, 30], 10))
    assert_same(runs[0], runs[1])


@pytest.mark.parametrize("stalls", STALLS, ids=str)
@pytest.mark.parametrize("after", [0, 1, 17, 40])
def test_reset_in_the_middle(engine_for: EngineFor, stalls: Stalls, after: int) -> None:
    values = beats(40, 4)
    stimulus = Stimulus({"i": values}, stalls=stalls, reset_after=after)
    runs = [engine_for(kind, "numberer").run(stimulus, quiet=20) for kind in FAST]
    numbers = np.concatenate([np.arange(after), np.arange(40 - after)]).astype(np.uint64)
    np.testing.assert_array_equal(runs[0].outputs["o"], values | (numbers << np.uint64(4)))
    assert_same(runs[0], runs[1])
    assert (runs[0].input_clocks["i"] >= 0).all()


def test_reset_loses_what_another_source_offers(engine_for: EngineFor) -> None:
    stimulus = Stimulus(
        {"a": beats(60, 8, 1), "b": beats(60, 8, 2)}, stalls=Stalls(0.7, 0, 5), reset_after=20
    )
    runs = [engine_for(kind, "adder").run(stimulus, quiet=20, max_clocks=2000) for kind in FAST]
    assert_same(runs[0], runs[1])


@pytest.mark.parametrize("kind", FAST)
def test_engines_start_anew_with_every_run(engine_for: EngineFor, kind: EngineName) -> None:
    engine = engine_for(kind, "numberer")
    stimulus = Stimulus({"i": beats(20, 4)})
    assert_same(engine.run(stimulus, quiet=5), engine.run(stimulus, quiet=5))


@pytest.mark.parametrize("kind", FAST)
@pytest.mark.parametrize("change", [0, 1])
def test_broken_stream_rules_are_found(engine_for: EngineFor, kind: EngineName, change: int) -> None:
    stimulus = Stimulus(
        {"i": np.arange(1, 100, dtype=np.uint64)}, [(0, {"change": change})], Stalls(0, 0.5, 1)
    )
    with pytest.raises(StreamError) as caught:
        engine_for(kind, "impatient").run(stimulus)
    pauses = stimulus.stalls.patterns(engine_for(kind, "impatient").ports)[1][0]
    # a beat is offered from clock 1 on; the first one to meet a pause is found missing or changed
    # one clock later
    clock = 1 + int(np.flatnonzero(pauses[1:])[0]) + 1
    held = (clock - 1) << 60
    what = f"changed the payload from {held:#x} to {held + 1:#x}" if change else "withdrew valid"
    assert str(caught.value) == f"stream o {what} at clock {clock} before the beat {held:#x} was taken"
    # the engine is none the worse for it
    good = Stimulus({"i": np.arange(5, dtype=np.uint64)}, [(0, {"change": change})])
    assert engine_for(kind, "impatient").run(good, quiet=5).outputs["o"].shape == (5, 2)


@pytest.mark.parametrize("kind", FAST)
def test_a_design_that_hangs(engine_for: EngineFor, kind: EngineName) -> None:
    with pytest.raises(SimulationHang, match=r"after 300 clocks; beats: i 3 of 10 in, o 2 out$"):
        engine_for(kind, "stuck").run(Stimulus({"i": beats(10, 8)}), max_clocks=300)


@pytest.mark.parametrize("kind", FAST)
def test_progress_counts_beats(engine_for: EngineFor, kind: EngineName) -> None:
    reports: list[tuple[int, int]] = []
    count = 3000 if kind == "amaranth" else 500_000
    stimulus = Stimulus({"i": beats(count, 8)})
    engine_for(kind, "slice").run(stimulus, lambda done, total: reports.append((done, total)), quiet=5)
    done = [report[0] for report in reports]
    assert len(reports) > 2 and done == sorted(done)
    assert reports[-1] == (count, count)


@pytest.mark.parametrize(
    ("stimulus", "message"),
    [
        (Stimulus({"x": beats(3, 8)}), r"input stream 'x' is not there; allowed: i"),
        (Stimulus({"i": beats(3, 8) + 256}), r"beats of i exceed 8 bits"),
        (Stimulus({"i": np.zeros(3)}), r"beats of i are float64; allowed: whole numbers"),  # type: ignore[dict-item]
        (Stimulus({"i": np.zeros((3, 2), np.uint64)}), r"shape \(3, 2\); allowed: \(n,\)"),
        (Stimulus({"i": beats(3, 8)}, [(0, {"offset": 256})]), r"offset is 256; allowed: 0 to 255"),
        (
            Stimulus({"i": beats(3, 8)}, [(0, {"gain": 1})]),
            r"plain input 'gain' is not there; allowed: offset",
        ),
        (Stimulus({"i": beats(3, 8)}, [(-1, {"offset": 1})]), r"beat -1; allowed: from 0"),
        (Stimulus({"i": beats(3, 8)}, reset_after=4), r"reset_after is 4; allowed: 0 to 3"),
    ],
)
def test_stimuli_that_do_not_fit(engine_for: EngineFor, stimulus: Stimulus, message: str) -> None:
    for kind in FAST:
        with pytest.raises(ValueError, match=message):
            engine_for(kind, "slice").run(stimulus)


@pytest.mark.parametrize("chance", [-0.1, 1.0])
def test_stall_probabilities_out_of_range(chance: float) -> None:
    with pytest.raises(ValueError, match="stall probability of inputs"):
        Stalls(inputs=chance)
    with pytest.raises(ValueError, match="stall probability of outputs"):
        Stalls(outputs=chance)
