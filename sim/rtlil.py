"""Designs as RTLIL text, the form in which Yosys takes them from Amaranth."""

from __future__ import annotations

import re

_MODULE = re.compile(r"^module .*?^end\n", re.MULTILINE | re.DOTALL)
_MEMORY_INIT = re.compile(r"^  cell \$meminit_v2 .*?^  end\n", re.MULTILINE | re.DOTALL)
_MEMORY_WRITE = re.compile(r"^  cell \$memwr_v2 .*?^  end\n", re.MULTILINE | re.DOTALL)
_MEMORY_NAME = re.compile(r'parameter \\MEMID "(.*?)"')
_ALL_ZERO = re.compile(r"connect \\DATA \d+'0*$", re.MULTILINE)


def without_zeros(text: str) -> str:
    """RTLIL without the zeros that memories with a write port start with.

    Amaranth writes these out word by word. They would be most of the Verilog, and some synthesis
    tools would not use block RAM. They would also be half of what a simulator has to compile, and
    its memories start with zeros by themselves. Tables, which have no write port, keep their
    contents.

    Raises
    ------
    ValueError
        A cell of a memory has no name, which Amaranth always gives.
    """
    return _MODULE.sub(lambda match: _module_without_zeros(match[0]), text)


def _module_without_zeros(module: str) -> str:
    written = {_memory_name(cell) for cell in _MEMORY_WRITE.findall(module)}

    def keep(match: re.Match[str]) -> str:
        cell = match[0]
        return "" if _memory_name(cell) in written and _ALL_ZERO.search(cell) else cell

    return _MEMORY_INIT.sub(keep, module)


def _memory_name(cell: str) -> str:
    match = _MEMORY_NAME.search(cell)
    if match is None:
        raise ValueError(f"memory cell without a name: {cell.splitlines()[0].strip()}")
    return match[1]
