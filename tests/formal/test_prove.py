# amaranth: UnusedElaboratable=no
"""The prover itself: its verdicts on a counter whose every state is known."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import pytest
from amaranth.asserts import AnySeq
from amaranth.hdl import Assert, Assume, Cover, Elaboratable, Module, Signal

from flow.formal import prove
from flow.yowasp import ToolNotFoundError


class Counter(Elaboratable):
    """Counts from 0 to 4 and again from 0 while enabled; ``check`` adds properties of the count."""

    def __init__(self, check: Any) -> None:
        self._check = check

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        count = Signal(4)
        with m.If(AnySeq(1)):
            m.d.sync += count.eq(count + 1)
            with m.If(count == 4):
                m.d.sync += count.eq(0)
        m.d.comb += self._check(count)
        return m


class Inside(Elaboratable):
    """The counter as a submodule, whose properties must be named as well."""

    def __init__(self, check: Any) -> None:
        self._check = check

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.counter = Counter(self._check)
        m.d.comb += Assert(1, "always")
        return m


def test_what_holds_is_proven() -> None:
    outcome = prove(Counter(lambda count: Assert(count < 5, "few")), mode="induction", depth=1)
    assert outcome.passed and not outcome.failed and outcome.phase is None and outcome.seconds > 0
    assert str(outcome).startswith("passed: induction, depth 1")


@pytest.mark.parametrize("checker", [Counter, Inside])
def test_a_failure_names_its_clock_its_message_and_its_line(checker: Any, tmp_path: Path) -> None:
    waves = tmp_path / "waves.vcd"
    check = lambda count: [Assert(count < 9, "never wrong"), Assert(count < 3, "below three")]  # noqa: E731
    outcome = prove(checker(check), depth=8, trace=waves)
    assert not outcome.passed and outcome.phase == "base" and outcome.step == 3
    assert [failed.message for failed in outcome.failed] == ["below three"]
    assert Path(outcome.failed[0].source.partition(":")[0]).name == Path(__file__).name
    assert str(outcome).startswith("failed in clock 3: below three (")
    assert "$enddefinitions" in waves.read_text()


def test_a_failure_that_is_too_far_away_is_none() -> None:
    checker = Counter(lambda count: Assert(count < 3, "below three"))
    assert prove(checker, depth=3).passed
    # but an induction does not pass over it
    outcome = prove(checker, mode="induction", depth=3)
    assert not outcome.passed and outcome.phase == "step" and outcome.step is None


def test_an_induction_that_does_not_close_is_not_a_proof() -> None:
    """The count never is 9, but nothing keeps it from coming from 8."""
    outcome = prove(Counter(lambda count: Assert(count != 9, "not nine")), mode="induction", depth=2)
    assert not outcome.passed and outcome.phase == "step"
    assert str(outcome).startswith("failed in the step: not nine")


def test_covers() -> None:
    check = lambda count: [Cover(count == 2, "two"), Cover(count == 7, "seven")]  # noqa: E731
    outcome = prove(Counter(check), mode="cover", depth=12)
    assert not outcome.passed
    assert {found.message: clock for found, clock in outcome.reached.items()} == {"two": 2}
    assert [missed.message for missed in outcome.unreached] == ["seven"]
    assert prove(Counter(lambda count: Cover(count == 2, "two")), mode="cover", depth=3).passed


def test_assumptions_that_contradict_each_other_reach_no_cover() -> None:
    """So a proof that holds because nothing can happen is noticed by its cover."""
    check = lambda count: [Assume(count == 1), Assert(count == 7, "false"), Cover(1, "anything")]  # noqa: E731
    assert prove(Counter(check), mode="bmc", depth=3).passed
    assert not prove(Counter(check), mode="cover", depth=3).passed


def test_asserts_can_be_left_out() -> None:
    check = lambda count: [Assert(count < 9, "few"), Assert(count < 3, "help: few")]  # noqa: E731
    assert prove(Counter(check), depth=6, ignoring=lambda message: message.startswith("help")).passed
    assert not prove(Counter(check), depth=6).passed


def test_there_must_be_something_to_prove() -> None:
    with pytest.raises(ValueError, match="no Assert in the component"):
        prove(Counter(lambda count: Cover(count == 2, "two")), depth=3)
    with pytest.raises(ValueError, match="no Cover in the component"):
        prove(Counter(lambda count: Assert(count < 5, "few")), mode="cover", depth=3)


def test_a_solver_is_found_beside_python_and_missing_ones_are_named(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    checker = Counter(lambda count: Assert(count < 5, "few"))
    monkeypatch.setenv("PATH", "")
    assert prove(checker, depth=2).passed
    with pytest.raises(ToolNotFoundError, match=r"no_such_solver is not installed: .*cornerstream\[formal\]"):
        prove(checker, depth=2, solver="no_such_solver")
    monkeypatch.setattr(sys, "executable", str(tmp_path / "python"))
    with pytest.raises(ToolNotFoundError, match=r"yosys-smtbmc is not installed: .*cornerstream\[formal\]"):
        prove(checker, depth=2)
