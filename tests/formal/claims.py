"""A claim about a block: its proof, its cover, and the faults that it catches."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from types import ModuleType
from typing import Any

import pytest

from flow.formal import Mode, Outcome, prove
from tests.formal.design import variant
from tests.formal.properties import INVARIANT

RECORD = "formal"
"""Name under which a test leaves its :class:`Record`, which the table at the end is made of."""

_METHODS = {"induction": "induction", "bmc": "bounded model checking"}


@dataclass(frozen=True)
class Fault:
    """A wrong version of the design: one text is changed, and an Assert must fail in a true run.

    What is asserted only to help the induction does not count: the fault breaks what is claimed.

    Parameters
    ----------
    old, new
        Text that occurs once in the module, and what takes its place.
    breaks
        Part of the message of an Assert that fails.
    within
        Clocks from power-up in which it does.
    """

    old: str
    new: str
    breaks: str
    within: int


@dataclass(frozen=True, kw_only=True)
class Claim:
    """Parameters: what is claimed, and how it is proven.

    ``check`` makes a checker, an elaboratable with Asserts and Covers, out of the module ``design``
    or a faulty variant of it. ``covered`` is the number of clocks in which all Covers are reached.
    Where these, or faults, lie too many clocks away for a solver, ``small`` is the design with a
    smaller constant: the claim is proven for it as well, and they are looked for in it. Where
    ``long_proof``, `make test` proves only that, and what it takes long to prove is for
    `make verify`; where ``long``, all of the claim is.
    """

    says: str
    design: ModuleType
    check: Callable[[Any], Any]
    mode: Mode = "induction"
    depth: int
    covered: int
    faults: tuple[Fault, ...]
    small: ModuleType | None = None
    long: bool = False
    long_proof: bool = False


@dataclass(frozen=True)
class Record:
    """A line of the table: what was done for a claim, and what came out."""

    says: str
    did: str
    seconds: float
    order: int


@dataclass(frozen=True)
class Case:
    """One test of a claim; called with pytest's ``record_property``."""

    claim: Claim
    fault: Fault | None = None
    cover: bool = False
    only_small: bool = False

    @property
    def name(self) -> str:
        proof = "small proof" if self.only_small else "proof"
        return self.fault.breaks if self.fault else "cover" if self.cover else proof

    def __call__(self, record_property: Callable[[str, object], None]) -> None:
        did, outcome = self._run()
        record = Record(self.claim.says, did, outcome.seconds, order=2 * bool(self.fault) + self.cover)
        record_property(RECORD, asdict(record))

    def _beside_the_fault(self, message: str) -> bool:
        """All but the one it must break, so that a solver cannot choose which one it breaks."""
        assert self.fault
        return message.startswith(INVARIANT) or self.fault.breaks not in message

    def _run(self) -> tuple[str, Outcome]:
        claim, small = self.claim, self.claim.small or self.claim.design
        if self.fault:
            design = variant(small, {self.fault.old: self.fault.new})
            outcome = prove(claim.check(design), depth=self.fault.within, ignoring=self._beside_the_fault)
            assert not outcome.passed, "the fault is not noticed"
            return f"a fault is caught in clock {outcome.step}: {outcome.failed[0].message}", outcome
        if self.cover:
            outcome = prove(claim.check(small), mode="cover", depth=claim.covered)
            assert outcome.passed, str(outcome)
            return (
                f"{len(outcome.reached)} covers reached in {max(outcome.reached.values()) + 1} clocks",
                outcome,
            )
        if claim.small:
            outcome = prove(claim.check(small), mode=claim.mode, depth=claim.depth)
            assert outcome.passed, str(outcome)
        if not self.only_small:
            outcome = prove(claim.check(claim.design), mode=claim.mode, depth=claim.depth)
            assert outcome.passed, str(outcome)
        size = ", with a smaller constant" if self.only_small else ""
        return f"proven by {_METHODS[claim.mode]}, depth {claim.depth}{size}", outcome


def cases(*claims: Claim) -> list[Any]:
    """Parameters of a test ``def test(case, record_property): case(record_property)``."""
    found = []
    for claim in claims:
        assert claim.faults, f"a proof that cannot fail says nothing: {claim.says}"
        assert claim.small or not claim.long_proof, f"there is nothing small to prove: {claim.says}"
        every = [Case(claim), Case(claim, cover=True), *(Case(claim, fault) for fault in claim.faults)]
        if claim.long_proof and not claim.long:
            every.append(Case(claim, only_small=True))
        for case in every:
            long = claim.long or (claim.long_proof and case == Case(claim))
            marks = [pytest.mark.verify] if long else []
            found.append(pytest.param(case, id=f"{claim.says}-{case.name}", marks=marks))
    return found
