"""The independent engine: emitted Verilog, exactly as it leaves the project, under Verilator.

Compilation and clock loop are those of the compiled engine.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from amaranth.hdl import Fragment
from amaranth.lib import wiring

from hdl.identifiers import plain_port
from sim.compiler import build, find_compiler, package_text
from sim.native import NativeEngine, describe_levels, describe_streams
from sim.ports import Ports, discover
from sim.verilator import Verilator, verilator_root, verilog_ports
from sim.waves import views

_CLASS = "Vdut"
_GENERATORS = ("verilog_engine.py", "verilator.py", "native.py")
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


def port_name(name: str, present: set[str]) -> str:
    """The name in Verilog of a component's port; a mapped netlist keeps the sources' names."""
    plain = plain_port(name)
    return plain if plain in present else name


def describe(ports: Ports, present: set[str], *, waves: bool) -> str:
    """The C++ between Verilator's model and the harness."""

    def member(port: str) -> str | None:
        name = port_name(port, present)
        # Verilator reserves double underscores for itself.
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
        # It is not used, but Amaranth warns of a component that is never elaborated.
        Fragment.get(component, platform=None)
        self._verilator = Verilator(verilator_root(), notify, cache)
        self.name = f"verilog (verilator {self._verilator.version}, {find_compiler().label})"
        self._text = verilog.read_text(encoding="utf-8")
        self._top, self._present = verilog_ports(self._text)
        self._notify = notify
        self._cache = cache

    def _generate(self, folder: Path, *, waves: bool) -> list[str]:
        options, sources = (["--trace-vcd"], ["verilated_vcd_c.cpp"]) if waves else ([], [])
        model = self._verilator.translate(folder, _CLASS, self._top, *options)
        main = model + describe(self.ports, self._present, waves=waves)
        (folder / "main.cc").write_text(main, encoding="utf-8")
        return ["main.cc", str(self._verilator.runtime(sources))]

    def _build(self, *, waves: bool) -> Path:
        names = ["harness.h", "verilator_ports.h", *(["wave_file.h"] if waves else [])]
        return build(
            {"design.v": self._text, **{name: package_text(name) for name in names}},
            lambda folder: self._generate(folder, waves=waves),
            includes=self._verilator.includes,
            extra=self._verilator.version + "".join(map(package_text, _GENERATORS)) + str(waves),
            notify=self._notify,
            directory=self._cache,
        )
