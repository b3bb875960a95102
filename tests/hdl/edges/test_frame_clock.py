"""Frame clock: the counter, and times that wait with their frames."""

from __future__ import annotations

import random
from collections import deque
from typing import Any

import pytest
from amaranth.hdl import ResetInserter, Signal

import hdl.edges.frame_clock
from hdl.edges.frame_clock import FrameClock
from tests.hdl.edges.bench import simulate

ACTIONS = ("arrives", "begins", "drops", "ends", "forget")


def run(dut: FrameClock, steps: list[tuple[str, ...]]) -> list[int]:
    """The time after each of these clocks, in which that happens."""
    times = []

    async def bench(context: Any) -> None:
        for clock, step in enumerate(steps):
            assert context.get(dut.now) == clock
            for name in ACTIONS:
                context.set(getattr(dut, name), name in step)
            await context.tick()
            times.append(context.get(dut.time))

    simulate(dut, bench)
    return times


def test_times_by_hand() -> None:
    steps: list[tuple[str, ...]] = [
        (),
        ("arrives",),  # 1
        (),
        ("begins", "arrives"),  # 3: the second waits already when the first begins
        (),
        ("begins",),
        ("ends",),  # the first
        (),
        ("arrives",),  # 8
        ("drops",),
        ("arrives",),  # 10
        ("begins",),
        ("ends",),  # the second
        ("ends",),  # the third, without the one that was dropped
        (),
    ]
    assert run(FrameClock(4), steps) == [0] * 6 + [1] * 6 + [3] + [10] * 2


def test_what_is_forgotten_never_ends() -> None:
    """Two of three frames are forgotten, while one start of frame waits at the input."""
    steps: list[tuple[str, ...]] = [
        (),
        ("arrives",),
        ("begins", "arrives"),
        ("begins", "arrives"),
        ("begins",),
    ]
    after: list[tuple[str, ...]] = [("forget",), ("begins",), (), ("ends",), ()]
    assert run(FrameClock(8), [*steps, ("arrives", "ends"), *after]) == [0] * 5 + [1] * 4 + [5, 5]
    # the first ends in the very clock
    together: list[tuple[str, ...]] = [("arrives",), ("ends", "forget"), ("begins",), ("ends",)]
    assert run(FrameClock(8), [*steps, *together]) == [0] * 6 + [1, 1, 5]


@pytest.mark.parametrize("most", [3, 4, 7, 50])
def test_any_order_against_a_queue(most: int) -> None:
    """As full as allowed, and around the memory many times."""
    random_ = random.Random(most)
    waiting: deque[int] = deque()
    begun: deque[int] = deque()
    steps: list[tuple[str, ...]] = [()]
    expected = [0]
    time = full = 0
    for clock in range(1, 4000):
        step = []
        # in turn it fills and it drains
        often, seldom = (0.6, 0.05) if clock % 400 < 200 else (0.1, 0.4)
        room = len(waiting) + len(begun) < most and len(waiting) < 2
        if begun and random_.random() < seldom:
            step.append("ends")
            time = begun.popleft()
        # one that is dropped has none behind it here
        if waiting and random_.random() < 0.6:
            dropped = len(waiting) == 1 and random_.random() < 0.2
            step.append("drops" if dropped else "begins")
            first = waiting.popleft()
            if not dropped:
                begun.append(first)
        elif random_.random() < 0.005:
            step.append("forget")
            begun.clear()
        if room and random_.random() < often and "drops" not in step:
            step.append("arrives")
            waiting.append(clock)
        full += len(waiting) + len(begun) == most
        steps.append(tuple(step))
        expected.append(time)
    assert full > 10
    assert run(FrameClock(most), steps) == expected


def test_the_halves_count_as_one(monkeypatch: pytest.MonkeyPatch) -> None:
    """A counter that is short enough to see each carry."""
    monkeypatch.setattr(hdl.edges.frame_clock, "TIME_BITS", 8)
    assert run(FrameClock(3), [()] * 256) == [0] * 256


def test_a_reset_takes_the_time_back() -> None:
    """What the memory holds survives a reset, but is not shown."""
    dut = FrameClock(3)
    reset = Signal()

    async def bench(context: Any) -> None:
        for name in ((), "arrives", "begins", "ends", ()):
            for each in ACTIONS:
                context.set(getattr(dut, each), each == name)
            await context.tick()
        assert context.get(dut.time) == 1
        context.set(reset, 1)
        await context.tick()
        context.set(reset, 0)
        for now in range(3):
            assert context.get(dut.now) == now
            await context.tick()
            assert now == 0 or context.get(dut.time) == 0

    simulate(ResetInserter(reset)(dut), bench)
