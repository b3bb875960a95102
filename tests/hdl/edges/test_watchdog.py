"""Watchdog: fires when a wait has lasted for the limit, however that came to be."""

from __future__ import annotations

from typing import Any

import pytest

from hdl.edges.register_map import TIMEOUT_BITS
from hdl.edges.watchdog import Watchdog
from tests.hdl.edges.bench import simulate

LATE = 1
"""Clocks by which it tells of what was before."""


def fires(waits: list[int], limits: list[int], bits: int = TIMEOUT_BITS) -> list[int]:
    """The clocks in which it fires; it waits in those with a 1."""
    dut = Watchdog(bits)
    found: list[int] = []

    async def bench(context: Any) -> None:
        for clock, (waiting, limit) in enumerate(zip(waits, limits, strict=True)):
            context.set(dut.waiting, waiting)
            context.set(dut.limit, limit)
            if context.get(dut.expired):
                found.append(clock - LATE)
            await context.tick()

    simulate(dut, bench)
    return found


@pytest.mark.parametrize("limit", [1, 2, 5])
@pytest.mark.parametrize("over", [0, 1, 9])
def test_a_wait_of_the_limit_fires_once_and_a_shorter_one_never(limit: int, over: int) -> None:
    waits = [0, *[1] * (limit - 1), 0, 0, *[1] * (limit + over), 0, 0, 0]
    # in the first clock after so many
    assert fires(waits, [limit] * len(waits)) == [limit + 2 + limit]


def test_no_limit_never_fires() -> None:
    assert fires([1] * 40, [0] * 40) == []


@pytest.mark.parametrize("before", [0, 100, (1 << TIMEOUT_BITS) - 1])
def test_a_limit_that_is_lowered_below_the_wait_fires_at_once(before: int) -> None:
    assert fires([1] * 60, [before] * 30 + [10] * 30) == [30]
    assert fires([1] * 60, [before] * 30 + [40] * 30) == [40]


def test_a_wait_longer_than_can_be_counted_is_not_forgotten() -> None:
    assert fires([1] * 60, [0] * 50 + [7] * 10, bits=3) == [50]
