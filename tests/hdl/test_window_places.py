# amaranth: UnusedElaboratable=no
"""Places of windows that are being read: each is there from its take until the next one's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Value
from amaranth.sim import Simulator

from hdl.build import Build
from hdl.window_places import PLACES, WindowPlaces

BUILD = Build.profile("robust", pixels_per_clock=4)
INTERVAL = 3
"""Clocks from one window to the next, at least."""


@pytest.mark.parametrize("dense", [True, False], ids=["dense", "sparse"])
@pytest.mark.parametrize("late", [2, 6, INTERVAL * (PLACES - 1)])
def test_places_in_turn(late: int, dense: bool) -> None:
    """Windows whose centres come so many clocks after their requests, up to as many as fit."""
    random = np.random.default_rng(late)
    gaps = np.full(60, INTERVAL) if dense else random.integers(INTERVAL, 3 * INTERVAL, 60)
    puts = np.cumsum(gaps).tolist()
    places = random.integers(0, 1 << 20, len(puts)).tolist()
    given = dict(zip(puts, places, strict=True))
    taken = {clock + late: place for clock, place in given.items()}
    dut = WindowPlaces(BUILD, PLACES)
    seen: list[int] = []
    expected: list[int] = []

    async def bench(context: Any) -> None:
        current = None
        for clock in range(puts[-1] + late + INTERVAL):
            context.set(dut.put, clock in given)
            # what is beside a request is none
            context.set(Value.cast(dut.given), given.get(clock, (1 << 20) - 1))
            context.set(dut.take, clock in taken)
            await context.tick()
            current = taken.get(clock, current)
            if current is not None:
                seen.append(context.get(Value.cast(dut.place)))
                expected.append(current)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(bench)
    simulator.run()
    assert len(set(expected)) == len(set(places)) > 50
    assert seen == expected


def test_more_under_way_than_it_is_for() -> None:
    with pytest.raises(ValueError, match=f"under_way is 9; allowed: whole numbers up to {PLACES}"):
        WindowPlaces(BUILD, PLACES + 1)
