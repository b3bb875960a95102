# amaranth: UnusedElaboratable=no
"""Square root: exact for every radicand in real size, by all its registers and memories.

After k result bits, of the radicand's first 2k bits N, root q and remainder r:

    q² <= N < (q + 1)²        r = N - q² where r >= 0, else N - (q + 1)²

The proof of the hardware carries the excess e along, which the next two bits d of the radicand and
the next bit b of the root make e' = 4e + d - b·(4q + 1), so that all it has to say is linear, as
solvers like it: 0 <= e <= 2q. That e is N - q² is proven apart, over all integers. The digits on
their way through the delay lines are followed in these: nothing is assumed of them.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import pytest
import z3  # type: ignore[import-untyped]
from amaranth.hdl import Assert, C, Cat, Cover, Elaboratable, Module, Mux, Signal, Value

import hdl.square_root
from hdl.build import Build
from tests.formal.claims import Case, Claim, Fault, cases
from tests.formal.design import Probes, probes_of, stored, variant
from tests.formal.properties import free, invariant

ROOT_BITS = Build.profile("paper").root_bits


class Known(NamedTuple):
    """The proof's state beside a stage: is there a radicand, which one, and its root so far."""

    there: Value
    radicand: Value
    root: Value
    excess: Value


class StagesChecker(Elaboratable):
    """Any clock may be enabled, and reset may come in any; only input since then counts."""

    def __init__(self, design: Any, per_stage: int) -> None:
        self._design = design
        self._bits = getattr(design, "ROOT_BITS", ROOT_BITS)
        self._per_stage = per_stage

    def elaborate(self, platform: Any) -> Module:
        m, bits = Module(), self._bits
        m.submodules.dut = dut = self._design.SquareRoot(bits, self._per_stage)
        lines = [probes_of(line) if line.memory_bits else None for line in dut._lines]
        inside = probes_of(dut)
        free(m, dut)
        known = [Known(C(1), dut.radicand, C(0, 0), C(0, 0))]
        for stage in range(dut.latency):
            first = stage * self._per_stage
            signs = [inside[f"step_{k}"][-1] for k in range(first, min(first + self._per_stage, bits))]
            known.append(self._next(m, dut.enable, known[-1], signs))
            done = first + len(signs)
            with m.If(known[-1].there):
                if done < bits:
                    self._registers(m, inside, known[-1], done)
        self._digits(m, dut, inside, lines, [now.radicand for now in known], [now.there for now in known])

        end = known[-1]
        with m.If(end.there):
            m.d.comb += [
                Assert(dut.root == end.root, "the root is not made of its bits"),
                # as unsigned numbers, so that below zero is too much as well
                Assert(end.excess <= (end.root << 1), "the root is too large or too small"),
            ]
        m.d.comb += [
            Cover(end.there & (dut.root == (1 << bits) - 1) & ~dut.enable, "the largest root waits"),
            Cover(end.there & (dut.root == 0), "a root of nothing"),
            Cover(end.there & known[-2].there & (end.root == 1) & (known[-2].radicand == 0), "two at a time"),
        ]
        return m

    def _next(self, m: Module, enable: Value, before: Known, signs: list[Value]) -> Known:
        """A stage later, a bit of the root is 1 where the hardware's sign of the remainder is 0."""
        root, excess = before.root, before.excess
        for sign in signs:
            low = 2 * (self._bits - 1 - len(root))
            # two bits more than the largest, for the sign
            grown = Signal(len(root) + 5)
            brought = Cat(before.radicand[low : low + 2], excess)
            m.d.comb += grown.eq(brought - Mux(sign, 0, Cat(C(1, 2), root)))
            excess, root = grown, Cat(~sign, root)
        there, values = Signal(), (before.radicand, root, excess)
        after = [Signal(len(value), reset_less=True) for value in values]
        with m.If(enable):
            m.d.sync += [there.eq(before.there), *(k.eq(v) for k, v in zip(after, values, strict=True))]
        return Known(there, *after)

    def _registers(self, m: Module, inside: Probes, now: Known, done: int) -> None:
        """What a stage's registers hold after so many bits."""
        remainder, kept = inside[f"remainder_{done - 1}"].as_signed(), inside[f"root_{done - 1}"]
        root, excess, negative = now.root, now.excess, remainder < 0
        name = f"after {done} bits"
        invariant(m, excess <= (root << 1), f"{name} the root is too large or too small")
        invariant(
            m, remainder == Mux(negative, excess - (root << 1) - 1, excess), f"{name} the remainder differs"
        )
        invariant(m, negative == ~root[0], f"{name} the newest bit is not the sign")
        invariant(
            m, Cat(C(0, 1), kept) == Mux(negative, root, ~root)[:done], f"{name} the root is kept otherwise"
        )

    def _digits(
        self,
        m: Module,
        dut: Any,
        inside: Probes,
        lines: list[Probes | None],
        radicands: list[Value],
        there: list[Value],
    ) -> None:
        """Each digit of a radicand, in every clock of its way to its stage, is that radicand's."""
        held: list[list[tuple[int, int]]] = [[] for _ in lines]
        for k, (singles, *rounds) in enumerate(dut._waits):
            low, age = 2 * (self._bits - 1 - k), 0
            for ring, number in enumerate(rounds):
                for _ in range(number):
                    held[ring].append((low, age))
                    age += dut._lines[ring].latency
            for n in range(singles):
                age += 1
                with m.If(there[age]):
                    digit = radicands[age][low : low + 2]
                    invariant(m, inside[f"digit_{k}_{n}"] == digit, f"digit {k} differs after {age} clocks")
        for line, part, places in zip(dut._lines, lines, held, strict=True):
            if part is None:
                continue
            for later, word in enumerate(_words(m, line, part), start=1):
                for position, (low, age) in enumerate(places):
                    with m.If(there[age + later]):
                        digit = radicands[age + later][low : low + 2]
                        waiting = word[2 * position : 2 * position + 2]
                        invariant(m, waiting == digit, f"a digit differs in a delay line of {line.latency}")


def _words(m: Module, line: Any, inside: Probes) -> list[Value]:
    """What is inside a delay line, first the newest."""
    place, depth = inside["place"], line._depth
    invariant(m, place < depth, "a place is outside of the ring")
    words = []
    for later in range(1, depth + 1):
        behind = Signal(range(depth))
        m.d.comb += behind.eq(Mux(place < later, place + depth - later, place - later))
        words.append(Cat(stored(m, ring, behind) for ring in inside["rings"]))
    return [*words, Cat(inside["read_out"]), inside["delayed_1"]]


class WholeChecker(Elaboratable):
    """All result bits between two registers, and nothing known of how they come about."""

    def __init__(self, design: Any, root_bits: int) -> None:
        self._design = design
        self._bits = root_bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.dut = dut = self._design.SquareRoot(self._bits, self._bits)
        free(m, dut)
        there, radicand = Signal(), Signal(2 * self._bits)
        with m.If(dut.enable):
            m.d.sync += [there.eq(1), radicand.eq(dut.radicand)]
        with m.If(there):
            m.d.comb += [
                Assert(dut.root * dut.root <= radicand, "the root is too large"),
                Assert((dut.root + 1) * (dut.root + 1) > radicand, "the root is too small"),
            ]
        m.d.comb += Cover(there & (dut.root == (1 << self._bits) - 1), "the largest root")
        return m


WRONG_SIGN = "Cat(C(3, 2), operand, ~remainder[-1])", "Cat(C(3, 2), operand, remainder[-1])"
WRONG_INVERSION = "operand ^ (before[-1] ^ remainder[-1])", "operand ^ (before[-1])"
WRONG_LAST = "operand ^ (~remainder[-1])", "operand ^ (remainder[-1])"
LATE_DIGITS = "for n in range(singles):", "for n in range(singles + (k == 1)):"


def _stages(per_stage: int) -> Claim:
    short = {"RINGS = (4, 5)": "RINGS = (4, 5)\nROOT_BITS = 7"}
    clocks = -(-7 // per_stage) + 3
    return Claim(
        says=f"SquareRoot of {2 * ROOT_BITS} bits, {per_stage} result bits per stage: exact, stage by stage",
        design=hdl.square_root,
        small=variant(hdl.square_root, short),
        check=lambda design: StagesChecker(design, per_stage),
        depth=1,
        covered=clocks,
        faults=(
            Fault(*WRONG_SIGN, "the root is too", clocks),
            Fault(*WRONG_INVERSION, "the root is", clocks),
            Fault(*WRONG_LAST, "the root is not made of its bits", clocks),
            Fault(*LATE_DIGITS, "the root is", clocks),
        ),
        long=per_stage > 1,
        long_proof=True,
    )


def _whole(root_bits: int, long: bool) -> Claim:
    return Claim(
        says=f"SquareRoot of {2 * root_bits} bits in one clock: exact, as a whole",
        design=hdl.square_root,
        check=lambda design: WholeChecker(design, root_bits),
        depth=1,
        covered=2,
        faults=(Fault(*WRONG_SIGN, "the root is too", 2), Fault(*WRONG_LAST, "the root is too", 2)),
        long=long,
    )


CLAIMS = (_stages(1), _stages(3), _whole(8, long=False), _whole(12, long=True))


@pytest.mark.parametrize("case", cases(*CLAIMS))
def test_square_root(case: Case, record_property: Callable[[str, object], None]) -> None:
    case(record_property)


@pytest.mark.parametrize("last", [1, 0], ids=["as it is", "with a fault"])
def test_the_excess_that_is_carried_along_is_what_the_radicand_has_beyond_the_square(last: int) -> None:
    """By induction over bits: it is 0 at first, and N - q² is followed by 4N + d - (2q + b)²."""
    number, root, excess, digit, bit = z3.Ints("number root excess digit bit")
    grown = 4 * excess + digit - bit * (4 * root + last)
    new_number, new_root = 4 * number + digit, 2 * root + bit
    solver = z3.Solver()
    solver.add(excess == number - root * root, z3.Or(bit == 0, bit == 1))
    solver.add(grown != new_number - new_root * new_root)
    assert solver.check() == (z3.unsat if last else z3.sat)
