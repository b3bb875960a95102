"""Runs cocotb test benches against emitted Verilog, so that others' bus models can try the core.

cocotb comes from PyPI, and only its libraries are used: its own runner takes no part. The simulator
is built once for a Verilog text; environment variables say which test module it runs, and with
which parameters.
"""

from __future__ import annotations

import importlib.metadata
import os
import re
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from sim.compiler import build, package_text
from sim.verilator import Verilator, VerilatorNotFoundError, include, verilator_root, verilog_ports

CLOCK_NS = 10
"""Period of the clock of every test bench, which turns simulated time into clocks."""

_INSTALL = "pip install 'cornerstream[test]'"
# cocotb's main program includes a header of this name
_CLASS = "Vtop"
_GENERATORS = ("cocotb_bench.py", "verilator.py")
# cocotb's library looks for vpi_* in the program
_VISIBLE = "#pragma GCC visibility push(default)\n"
# Variables that control cocotb, or the pytest inside it, must come from the test alone, not from
# the user's environment.
_FOREIGN = re.compile(r"(COCOTB|PYTEST|GPI|PYGPI|TOPLEVEL|COVERAGE|PYTHONWARNINGS)")
_TAIL_LINES = 40
_NANOSECONDS = "sim_time_duration"


class CocotbNotFoundError(RuntimeError):
    """Something that cocotb needs is not installed; the message says how to get it."""


class BenchError(RuntimeError):
    """A test bench has no result; the message ends with the last lines of its output."""


@dataclass(frozen=True)
class Result:
    """How one test ended.

    Members
    -------
    name
        Name of the function; a parametrized one is followed by its parameters, ``name/key=value``.
    message
        Empty if passed; otherwise the exception and the last lines of ``output``.
    nanoseconds, seconds
        Simulated and real time.
    output
        Everything the test printed, log included. All of the run is in ``cocotb.log``.
    """

    name: str
    passed: bool
    message: str
    nanoseconds: float
    seconds: float
    output: str

    @property
    def clocks(self) -> int:
        return round(self.nanoseconds / CLOCK_NS)


@dataclass(frozen=True)
class Bench:
    """A built simulator. A test can see only ``ports``, which are those of the module ``top``."""

    executable: Path
    top: str
    ports: frozenset[str]

    def run(
        self,
        module: str,
        *,
        folder: Path,
        tests: Sequence[str] | None = None,
        environment: Mapping[str, str] | None = None,
        seed: int = 0,
        timeout: float = 600,
    ) -> list[Result]:
        """Run the tests of a module, one after the other in one process.

        Parameters
        ----------
        module
            Name for the import: ``tests.benches.bench_stream``, or a file in ``folder``.
        folder
            Where to run, and where ``results.xml`` and ``cocotb.log`` are left.
        tests
            Names of test functions, each with all its parameters or with those named; None for all.
        environment
            Variables for the tests: how parameters get there.
        seed
            Seed of Python's random numbers. Each test is seeded by this and its name.
        timeout
            Real seconds for all tests together.

        Raises
        ------
        CocotbNotFoundError
            Says what to install.
        BenchError
            The module cannot be imported, a test is missing, the simulator crashed or took too
            long. A test that fails is not an error: see :attr:`Result.passed` and :func:`check`.
        """
        folder.mkdir(parents=True, exist_ok=True)
        results, log = folder.resolve() / "results.xml", folder / "cocotb.log"
        results.unlink(missing_ok=True)
        variables = _variables(self.top, module, tests, seed, results) | dict(environment or {})
        with log.open("wb") as output:
            try:
                code = subprocess.run(
                    [str(self.executable)],
                    cwd=folder,
                    env=variables,
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=subprocess.STDOUT,
                    check=False,
                    timeout=timeout,
                ).returncode
            except subprocess.TimeoutExpired:
                code = None
        text = log.read_text(encoding="utf-8", errors="replace")
        if code is None:
            raise BenchError(f"{module} took longer than {timeout:g} s; its last lines:\n{_tail(text)}")
        if code or not results.exists():
            raise BenchError(
                f"{module} came to no results (exit code {code}); its last lines:\n{_tail(text)}"
            )
        return _read(results, text, module, tests)


def build_bench(verilog: str, *, notify: Callable[[str], None], cache: Path | None = None) -> Bench:
    """The simulator for a Verilog text, from the cache or newly built.

    A test can see only the ports of the top module. If everything were visible, Verilator could
    optimize nothing away: simulation would take three times as long, and compilation twice.

    Parameters
    ----------
    verilog
        Its top module is the one that no other instantiates.
    notify, cache
        See :func:`sim.compiler.build`.

    Raises
    ------
    CocotbNotFoundError, CompilerNotFoundError
        Say what to install.
    CompilationError
        Says which tool failed, and why.
    """
    libraries, main = _cocotb_libraries()
    try:
        verilator = Verilator(verilator_root(), notify, cache)
    except VerilatorNotFoundError:
        raise CocotbNotFoundError(f"test benches need Verilator: {_INSTALL}") from None
    top, ports = verilog_ports(verilog)

    def generate(folder: Path) -> list[str]:
        model = verilator.translate(folder, _CLASS, top, "visible.vlt", "--timescale", "1ns/1ns", "--vpi")
        (folder / "main.cc").write_text(model + include(main), encoding="utf-8")
        return ["main.cc", str(verilator.runtime(["verilated_vpi.cpp"], prologue=_VISIBLE))]

    visible = [f'public_flat_rw -module "{top}" -var "{port}"' for port in sorted(ports)]
    versions = verilator.version + importlib.metadata.version("cocotb")
    executable = build(
        {"design.v": verilog, "visible.vlt": "\n".join(["`verilator_config", *visible, ""])},
        generate,
        includes=verilator.includes,
        extra=versions + "".join(map(package_text, _GENERATORS)),
        program=[f"-L{libraries}", f"-Wl,-rpath,{libraries}", "-lcocotbvpi_verilator"],
        notify=notify,
        directory=cache,
    )
    return Bench(executable, top, frozenset(ports))


def check(results: Sequence[Result]) -> None:
    """AssertionError if a test has not passed, with the messages of all such tests."""
    failed = [result for result in results if not result.passed]
    if failed:
        texts = "\n\n".join(f"{result.name}: {result.message}" for result in failed)
        raise AssertionError(f"{len(failed)} of {len(results)} tests failed\n{texts}")


def _cocotb_libraries() -> tuple[Path, Path]:
    # where libraries lie, and the main program
    try:
        from cocotb_tools import config
    except ImportError:
        raise CocotbNotFoundError(f"test benches need cocotb: {_INSTALL}") from None
    return config.libs_dir, config.share_dir / "lib" / "verilator" / "verilator.cpp"


def _python_library() -> str:
    chosen = os.environ.get("LIBPYTHON_LOC")
    if chosen:
        return chosen
    try:
        from find_libpython import find_libpython
    except ImportError:
        raise CocotbNotFoundError(f"test benches need cocotb: {_INSTALL}") from None
    found = find_libpython()
    if not found:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise CocotbNotFoundError(
            f"test benches need Python as a shared library, and {sys.executable} has none; allowed: a Python built "
            f"with --enable-shared, Debian's package libpython{version}, or the library's path in $LIBPYTHON_LOC"
        )
    return str(found)


def _variables(
    top: str, module: str, tests: Sequence[str] | None, seed: int, results: Path
) -> dict[str, str]:
    python = _python_library()
    from cocotb_tools import config

    variables = {name: value for name, value in os.environ.items() if not _FOREIGN.match(name)}
    # the folder above this one first: that is where tests and all packages are found
    path = [str(Path(__file__).parents[1]), *(os.path.abspath(entry) for entry in sys.path)]
    variables |= {
        "COCOTB_ANSI_OUTPUT": "0",
        "COCOTB_RANDOM_SEED": str(seed),
        "COCOTB_RESULTS_FILE": str(results),
        # all files, the default, would include NumPy's: a second and a half
        "COCOTB_REWRITE_ASSERTION_FILES": "bench_*.py",
        "COCOTB_TEST_MODULES": module,
        "COCOTB_TOPLEVEL": top,
        # Verilator delays writes rightly; where cocotb does it in Python, a test takes twice as
        # long
        "COCOTB_TRUST_INERTIAL_WRITES": "1",
        "GPI_USERS": f"{python};{config.pygpi_entry_point()}",
        "PYGPI_PYTHON_BIN": sys.executable,
        # cocotb rewrites asserts by pytest's means; plugins are of no use there, and slow to start
        "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1",
        "PYTHONPATH": os.pathsep.join(path),
        "PYTHONUNBUFFERED": "1",
        # the bus models still call cocotb by names of its version 1
        "PYTHONWARNINGS": "default,ignore::DeprecationWarning",
        "TOPLEVEL_LANG": "verilog",
    }
    if tests is not None:
        variables["COCOTB_TEST_FILTER"] = rf"\.(?:{'|'.join(map(re.escape, tests))})(?:/|$)"
    return variables


def _read(results: Path, log: str, module: str, tests: Sequence[str] | None) -> list[Result]:
    outputs = _outputs(log)
    found = [
        _result(case, outputs.get(f"{case.get('classname')}.{case.get('name')}", ""))
        for case in ElementTree.parse(results).iter("testcase")
    ]
    known = {name for result in found for name in (result.name, result.name.partition("/")[0])}
    missing = [name for name in tests or [] if name not in known]
    if missing:
        raise BenchError(
            f"{module} has no test {', '.join(map(repr, missing))}; its last lines:\n{_tail(log)}"
        )
    if not found:
        raise BenchError(f"{module} has no tests; its last lines:\n{_tail(log)}")
    return found


def _outputs(log: str) -> dict[str, str]:
    # a test's lines reach from cocotb's announcement of it to that of the next, or to the table of
    # all tests
    table = re.search(r"^.* cocotb\.regression +\*{20,}$", log, re.MULTILINE)
    announcement = r"^.* cocotb\.regression +running (.+?) \(\d+/\d+\).*\n"
    pieces = re.split(announcement, log[: table.start()] if table else log, flags=re.MULTILINE)
    return dict(zip(pieces[1::2], pieces[2::2], strict=True))


def _result(case: ElementTree.Element, output: str) -> Result:
    trouble = next((entry for kind in ("error", "failure", "skipped") for entry in case.iter(kind)), None)
    message = ""
    if trouble is not None:
        reason = f"{trouble.get('type') or trouble.tag}: {trouble.get('message') or trouble.text or ''}"
        message = f"{reason.strip()}\nIts last lines:\n{_tail(output)}" if output else reason.strip()
    properties = {entry.get("name"): entry.get("value") for entry in case.iter("property")}
    return Result(
        name=case.get("name") or "",
        passed=trouble is None,
        message=message,
        nanoseconds=float(properties.get(_NANOSECONDS) or 0),
        seconds=float(case.get("time") or 0),
        output=output,
    )


def _tail(text: str) -> str:
    return "\n".join(text.rstrip().splitlines()[-_TAIL_LINES:])
