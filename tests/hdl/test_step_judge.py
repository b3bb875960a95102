# amaranth: UnusedElaboratable=no
"""What follows from a surface's peak and two solutions, against the golden model."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden import normal_equations
from golden.subpixel import Offset, gradient_steps
from hdl.build import Build
from hdl.step_judge import StepJudge
from hdl.subpixel import offset_layout
from sim.engine import EngineName
from sim.stimulus import Stalls
from tests.support.blocks import NO_STALLS, RUN_IDS, RUNS, Array, run_block

BUILD = Build.profile("paper", fit="gradient", max_width=64, max_height=64)
OFFSET = offset_layout("gradient")
SOLUTIONS = ("surface", "first", "second")
CENTRES = data.StructLayout({"first_x": 3, "first_y": 3, "second_x": 3, "second_y": 3})


class Rounds(wiring.Component):
    """The judge, which is given three solutions of each candidate, and its own steps back."""

    def __init__(self) -> None:
        fields = dict.fromkeys(SOLUTIONS, OFFSET)
        super().__init__(
            {
                "i": In(stream.Signature(data.StructLayout({**fields, "centres": CENTRES}))),
                "o": Out(stream.Signature(OFFSET)),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.judge = judge = StepJudge(BUILD)
        step, number = Signal(judge.step.payload.shape()), Signal(range(3))
        given, centres = self.i.payload, self.i.payload.centres
        under_way = judge.under_way.payload
        m.d.comb += [
            judge.solution.valid.eq(self.i.valid),
            judge.by_gradients.eq(number != 0),
            judge.surface.valid.eq(number == 0),
            judge.under_way.valid.eq(number != 0),
            under_way.step.eq(step),
            self.i.ready.eq(judge.solution.ready & (number == 2)),
        ]
        for k, name in enumerate(SOLUTIONS):
            with m.If(number == k):
                m.d.comb += judge.solution.payload.eq(given[name])
                if k:
                    m.d.comb += [
                        under_way.centre_x.eq(centres[f"{name}_x"].as_signed()),
                        under_way.centre_y.eq(centres[f"{name}_y"].as_signed()),
                    ]
        with m.If(judge.solution.ready & self.i.valid):
            m.d.sync += number.eq(number + 1)
            with m.If(number == 2):
                m.d.sync += number.eq(0)
        with m.If(judge.step.valid):
            m.d.sync += step.eq(judge.step.payload)
        wiring.connect(m, judge.o, wiring.flipped(self.o))
        return m


def solutions(count: int, seed: int) -> dict[str, Offset]:
    """Random ones; those of steps are often near the place before, and now and then at a limit."""
    rng = np.random.default_rng(seed)

    def some(largest: int) -> tuple[Array, Array]:
        spread = rng.integers(1, largest, count, endpoint=True)
        x, y = (np.round(rng.uniform(-1, 1, count) * spread).astype(np.int64) for _ in range(2))
        return x, y

    def offset(place: tuple[Array, Array], none: float) -> Offset:
        x, y = (np.clip(axis, -512, 512) for axis in place)
        not_maximum = rng.random(count) < none
        x, y = (np.where(not_maximum, 0, axis) for axis in (x, y))
        return Offset(x, y, np.maximum(np.abs(x), np.abs(y)) == 512, not_maximum)

    surface, first, way = some(90), some(600), some(400)
    second = first[0] + way[0], first[1] + way[1]
    return {"surface": offset(surface, 0.2), "first": offset(first, 0.1), "second": offset(second, 0.1)}


def centre(place: Array) -> Array:
    return normal_equations.centre(normal_equations.window_place(place))


@pytest.mark.parametrize(("name", "stalls"), RUNS, ids=RUN_IDS)
def test_against_the_golden_model(name: EngineName, stalls: Stalls) -> None:
    count = 3000 if name == "compiled" else 40
    given = solutions(count, 3)
    answers = iter((given["first"], given["second"]))
    expected = gradient_steps(
        given["surface"], np.zeros((count, 15, 15), np.uint8), lambda values: next(answers)
    )
    surface, first = given["surface"], given["first"]
    starts = {f"first_{axis}": centre(np.clip(getattr(surface, f"d{axis}"), -64, 64)) for axis in "xy"}
    places = {
        f"second_{axis}": centre(128 * starts[f"first_{axis}"] + getattr(first, f"d{axis}")) for axis in "xy"
    }
    fields = {name: vars(offset) for name, offset in given.items()}
    run_block(
        (Rounds,),
        {"i": {**fields, "centres": {**starts, **places}}},
        {"o": vars(expected)},
        name,
        stalls,
        clocks=3 * StepJudge.clocks,
    )
    if name == "compiled" and stalls == NO_STALLS:
        trusted = ~(expected.clamped | expected.not_maximum)
        leads = expected.clamped & (np.maximum(np.abs(expected.dx), np.abs(expected.dy)) > 64)
        kinds = (trusted, leads, expected.clamped & ~leads, expected.not_maximum)
        assert min(kind.sum() for kind in kinds) > 50
