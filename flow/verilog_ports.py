"""Emitted Verilog read again: its modules and their ports."""

from __future__ import annotations

import re
from dataclasses import dataclass

_MODULE = re.compile(r"^module (\w+)\(.*?^endmodule\n", re.MULTILINE | re.DOTALL)
_PORT = re.compile(r"^  (input|output) (?:\[(\d+):0\] )?(\w+);", re.MULTILINE)


@dataclass(frozen=True)
class Port:
    """A port of a Verilog module."""

    name: str
    direction: str
    width: int

    @property
    def pins(self) -> list[str]:
        """One name per bit, as Quartus has them."""
        return [self.name] if self.width == 1 else [f"{self.name}[{bit}]" for bit in range(self.width)]


def ports_of(body: str) -> list[Port]:
    """The ports of one Verilog module, sorted by name."""
    found = [Port(name, kind, int(high or 0) + 1) for kind, high, name in _PORT.findall(body)]
    return sorted(found, key=lambda port: port.name)


def split_modules(text: str) -> tuple[str, dict[str, str]]:
    """The opening comment of emitted Verilog, and its modules by name, the top first."""
    heading = text[: text.index("\nmodule ") + 1]
    return heading, {match[1]: match[0] for match in _MODULE.finditer(text)}
