"""Runs a compiled simulation: the Python side of ``harness.h``, shared by all compiled engines."""

from __future__ import annotations

import ctypes
import os
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from ctypes import POINTER, c_char_p, c_int, c_int64, c_uint8, c_uint64, c_void_p
from pathlib import Path
from typing import Any

import numpy as np

from sim.compiler import CompilationError, find_compiler
from sim.engine import QUIET, VCD_CLOCKS, Progress, broken_rule, hang
from sim.ports import LevelPort, Ports, StreamPort
from sim.stimulus import Capture, Plan, Stimulus, prepare, shaped
from sim.waves import View, find_in, whole, write_save_file

BATCH = 200_000
"""Clocks per call into the library: Ctrl-C and progress reports wait for its end."""
WAVE_BATCH = 2_000
"""The same where waves are written, which is some hundred times slower."""
_RUNNING, _FINISHED, _HANG, _WITHDRAWN, _CHANGED = range(5)


class _InputSpec(ctypes.Structure):
    _fields_ = [
        ("payloads", POINTER(c_uint64)),
        ("count", c_int64),
        ("stalls", POINTER(c_uint8)),
        ("period", c_int64),
        ("accepted", POINTER(c_int64)),
    ]


class _OutputSpec(ctypes.Structure):
    _fields_ = [("stalls", POINTER(c_uint8)), ("period", c_int64)]


class _LevelChange(ctypes.Structure):
    _fields_ = [("beat", c_int64), ("port", c_int64), ("value", c_uint64)]


class _Spec(ctypes.Structure):
    _fields_ = [
        ("inputs", POINTER(_InputSpec)),
        ("outputs", POINTER(_OutputSpec)),
        ("changes", POINTER(_LevelChange)),
        ("change_count", c_int64),
        ("reset_after", c_int64),
        ("quiet", c_int64),
        ("max_clocks", c_int64),
        ("waves", c_char_p),
        ("wave_clocks", c_int64),
    ]


def _pointer(array: np.ndarray, kind: Any) -> Any:
    return array.ctypes.data_as(POINTER(kind))


def load(path: Path) -> ctypes.CDLL:
    """The library with the types of its functions declared.

    ``CompilationError`` if it cannot be loaded; it is deleted then.
    """
    try:
        library = ctypes.CDLL(str(path))
    except OSError as error:
        # a C compiler does not link the C++ library; a full disk cuts files short
        path.unlink(missing_ok=True)
        raise CompilationError(
            f"the simulator cannot be loaded, and was deleted: {error}; is {find_compiler().label!r} for C++?"
        ) from error
    for name, result, arguments in (
        ("sim_open", c_void_p, [POINTER(_Spec)]),
        ("sim_close", None, [c_void_p]),
        ("sim_run", c_int, [c_void_p, c_int64]),
        ("sim_clock", c_int64, [c_void_p]),
        ("sim_remaining", c_int64, [c_void_p]),
        ("sim_delivered", c_int64, [c_void_p, c_int64]),
        ("sim_copy", None, [c_void_p, c_int64, POINTER(c_uint64), POINTER(c_int64)]),
        ("sim_finish_waves", c_int, [c_void_p]),
        ("sim_broken", c_int64, [c_void_p, POINTER(c_uint64)]),
    ):
        function = getattr(library, name)
        function.restype = result
        function.argtypes = arguments
    return library


def _stream(index: int, kind: str, port: StreamPort, member: Callable[[str], str | None]) -> str:
    into = kind == "Input"
    payload, valid, ready = (member(port.flat(field)) for field in ("payload", "valid", "ready"))
    if valid is None:
        raise ValueError(f"the design has no port {port.flat('valid')}")
    words = "const uint64_t *words" if into else "uint64_t *words"
    # A payload of no bits has no port.
    move = "" if payload is None else f"{'put' if into else 'get'}(dut.{payload}, words);"
    if payload is None and not into:
        move = "words[0] = 0;"
    accepting = "true" if ready is None else f"get_bit(dut.{ready})"
    offer = "" if ready is None else f"put_bit(dut.{ready}, value);"
    if into:
        lines = [
            f"static void valid(Dut &dut, bool value) {{ put_bit(dut.{valid}, value); }}",
            f"static bool ready(Dut &dut) {{ return {accepting}; }}",
        ]
    else:
        lines = [
            f"static constexpr bool always_ready = {'false' if port.has_ready else 'true'};",
            f"static bool valid(Dut &dut) {{ return get_bit(dut.{valid}); }}",
            f"static void ready(Dut &dut, bool value) {{ {offer} }}",
        ]
    lines.insert(0, f"static constexpr int words = {port.words};")
    lines.append(f"static void payload(Dut &dut, {words}) {{ {move} }}")
    return f"struct {kind}{index} {{\n" + "".join(f"    {line}\n" for line in lines) + "};\n"


def describe_streams(ports: Ports, member: Callable[[str], str | None]) -> str:
    """C++ that describes the streams for the harness.

    ``member`` maps a flat port name to a member of ``Dut``.
    """
    text = "".join(_stream(k, "Input", port, member) for k, port in enumerate(ports.inputs))
    text += "".join(_stream(k, "Output", port, member) for k, port in enumerate(ports.outputs))
    for kind, streams in (("Input", ports.inputs), ("Output", ports.outputs)):
        text += f"using {kind}s = std::tuple<{', '.join(f'{kind}{k}' for k in range(len(streams)))}>;\n"
    return text


def describe_levels(levels: tuple[LevelPort, ...], member: Callable[[str], str | None]) -> str:
    """Body of ``Dut::level``; ports that the design does not have are ignored."""
    cases = [
        f"        case {number}: put({name}, &value); break;\n"
        for number, port in enumerate(levels)
        if (name := member(port.name)) is not None
    ]
    return "        switch (port) {\n" + "".join(cases) + "        default: break;\n        }\n"


class NativeRun:
    """One run of a loaded library. Owns every array the library points into."""

    def __init__(self, library: ctypes.CDLL, plan: Plan, vcd: Path | None, vcd_clocks: int) -> None:
        self._library = library
        self._plan = plan
        self._batch = BATCH if vcd is None else WAVE_BATCH
        self.accepted = [np.full(len(beats), -1, np.int64) for beats in plan.beats]
        spec = _Spec(
            inputs=self._inputs(),
            outputs=self._outputs(),
            changes=(_LevelChange * len(plan.changes))(*(_LevelChange(*change) for change in plan.changes)),
            change_count=len(plan.changes),
            reset_after=plan.reset_after,
            quiet=plan.limits.quiet,
            max_clocks=plan.limits.max_clocks,
            waves=None if vcd is None else str(vcd).encode(),
            wave_clocks=vcd_clocks,
        )
        self._vcd = vcd
        # The library copies the structures; the arrays behind them live in self.
        self._simulation = c_void_p(library.sim_open(ctypes.byref(spec)))

    def _inputs(self) -> Any:
        plan = self._plan
        specs = [
            _InputSpec(
                _pointer(beats, c_uint64),
                len(beats),
                _pointer(stalls, c_uint8),
                len(stalls),
                _pointer(taken, c_int64),
            )
            for beats, stalls, taken in zip(plan.beats, plan.source_stalls, self.accepted, strict=True)
        ]
        return (_InputSpec * len(specs))(*specs)

    def _outputs(self) -> Any:
        specs = [_OutputSpec(_pointer(stalls, c_uint8), len(stalls)) for stalls in self._plan.sink_stalls]
        return (_OutputSpec * len(specs))(*specs)

    def run(self, progress: Progress | None) -> None:
        """Run until the end, or an error."""
        total = self._plan.total_beats
        outcome = _RUNNING
        while outcome == _RUNNING:
            outcome = self._library.sim_run(self._simulation, self._batch)
            if progress is not None:
                progress(total - self._library.sim_remaining(self._simulation), total)
        if outcome == _HANG:
            taken = [int(np.count_nonzero(clocks >= 0)) for clocks in self.accepted]
            outputs = range(len(self._plan.ports.outputs))
            raise hang(self._plan, taken, [self._library.sim_delivered(self._simulation, k) for k in outputs])
        if outcome in (_WITHDRAWN, _CHANGED):
            self._raise_broken(withdrawn=outcome == _WITHDRAWN)

    def _raise_broken(self, *, withdrawn: bool) -> None:
        most = max(port.words for port in self._plan.ports.outputs)
        words = np.zeros(2 * most, np.uint64)
        stream = self._library.sim_broken(self._simulation, _pointer(words, c_uint64))
        count = self._plan.ports.outputs[stream].words
        halves = (words[:count], words[count : 2 * count])
        held, seen = (int.from_bytes(half.tobytes(), "little") for half in halves)
        clock = self._library.sim_clock(self._simulation) - 1
        raise broken_rule(self._plan, stream, clock, held, None if withdrawn else seen)

    def capture(self, seconds: float) -> Capture:
        outputs, output_clocks = {}, {}
        for number, port in enumerate(self._plan.ports.outputs):
            count = self._library.sim_delivered(self._simulation, number)
            payloads = np.zeros((count, port.words), np.uint64)
            clocks = np.zeros(count, np.int64)
            where = (_pointer(payloads, c_uint64), _pointer(clocks, c_int64))
            self._library.sim_copy(self._simulation, number, *where)
            outputs[port.name], output_clocks[port.name] = shaped(port, payloads), clocks
        names = (port.name for port in self._plan.ports.inputs)
        inputs = dict(zip(names, self.accepted, strict=True))
        return Capture(outputs, output_clocks, inputs, self._library.sim_clock(self._simulation), seconds)

    def finish_waves(self) -> None:
        """``OSError`` if they could not be written."""
        if number := self._library.sim_finish_waves(self._simulation):
            raise OSError(number, os.strerror(number), str(self._vcd))

    def close(self) -> None:
        self._library.sim_close(self._simulation)


def run_native(
    library: ctypes.CDLL, plan: Plan, progress: Progress | None, vcd: Path | None, vcd_clocks: int
) -> Capture:
    """Run a plan to its end."""
    run = NativeRun(library, plan, vcd, vcd_clocks)
    try:
        start = time.perf_counter()
        try:
            run.run(progress)
        finally:
            run.finish_waves()
        return run.capture(time.perf_counter() - start)
    finally:
        run.close()


class NativeEngine(ABC):
    """Base of the engines that compile the design; see :class:`sim.engine.Engine`.

    An engine sets these members, and says how it is built.
    """

    ports: Ports
    name: str
    _views: list[View]
    """What the save files of waves show."""
    _present: set[str]
    """Names of the top module's ports."""

    def __init__(self) -> None:
        self._libraries: dict[bool, ctypes.CDLL] = {}

    @abstractmethod
    def _build(self, *, waves: bool) -> Path:
        """The shared library, built if need be; with or without the ability to write waves."""

    def run(
        self,
        stimulus: Stimulus,
        progress: Progress | None = None,
        vcd: str | Path | None = None,
        *,
        vcd_clocks: int = VCD_CLOCKS,
        quiet: int = QUIET,
        max_clocks: int | None = None,
    ) -> Capture:
        """See :meth:`sim.engine.Engine.run`.

        The library is built, or found in the cache, at the first run.
        """
        has_reset = "rst" in self._present
        plan = prepare(self.ports, stimulus, quiet=quiet, max_clocks=max_clocks, has_reset=has_reset)
        path = None if vcd is None else Path(vcd)
        waves = path is not None
        if waves not in self._libraries:
            self._libraries[waves] = load(self._build(waves=waves))
        library = self._libraries[waves]
        if path is None:
            return run_native(library, plan, progress, None, vcd_clocks)
        try:
            with whole(path) as file:
                return run_native(library, plan, progress, file, vcd_clocks)
        finally:
            if path.is_file():
                write_save_file(path, self._views, find_in(path))
