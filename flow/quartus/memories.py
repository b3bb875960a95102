"""Which memories the Verilog has, and whether Quartus can make block RAM of them.

Intel's guidelines (Quartus Prime Standard Edition User Guide: Design Recommendations, "Recommended
HDL Coding Styles", 2.4) give templates. A written memory is expected in the form of 2.4.1.5,
*Single-Clock, Simple Dual-Port Synchronous RAM with Old Data Read-During-Write Behavior*; a table
in that of 2.4.2, *ROM functions*, with its contents in an initial block as in 2.4.1.11, read once
or twice. All may have an enable on the read, which becomes the block's.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

from flow.device import MemoryBlock

Kind = Literal["simple dual-port RAM", "ROM", "dual-port ROM", "logic"]

_DECLARATION = re.compile(r"^  reg (?:\[(\d+):0\] )?(\w+) \[(\d+):0\];\n", re.MULTILINE)
# an always block on a clock, and the only statements allowed in it: assignments, each with or
# without an enable
_BLOCK = re.compile(r"^  always @\(posedge (\w+)\)(?: begin)?\n((?:    .*\n)+)", re.MULTILINE)
_ASSIGNMENT = re.compile(
    r"\s*(?:if \(\w+(?:\[\d+\])?\)( begin)?\s+)?(\w+(?:\[[^;=]+\])?) <= ([^;]+);(?(1)\s+end)\s*"
)
# the attribute by which other tools are asked for the same
_FOREIGN = re.compile(r"^  \(\* ram_style = .* \*\)\n", re.MULTILINE)


@dataclass(frozen=True)
class Memory:
    """One memory of a module.

    Parameters
    ----------
    module, name
        Module that declares it, and its name there.
    width, depth
        Bits of a word, and words.
    kind
        ``"logic"`` where it follows no template, so that Quartus would make it from flip-flops and
        multiplexers.
    same_address
        It is read at the address of the write, as a delay line: the old data are needed.
    """

    module: str
    name: str
    width: int
    depth: int
    kind: Kind
    same_address: bool

    @property
    def bits(self) -> int:
        return self.width * self.depth

    def attribute(self, block: MemoryBlock) -> str:
        """The line that tells Quartus about it; empty where it follows no template.

        The name of the device's block of RAM keeps Quartus from making small ones of logic.
        ``no_rw_check`` says that the value read from an address in the very clock in which it is
        written is never used, so that the memory block may deliver anything there; a test replaces
        all these values by noise.
        """
        if self.kind == "logic":
            return ""
        if self.kind != "simple dual-port RAM":
            return f'  (* romstyle = "{block.name}" *)\n'
        return f'  (* ramstyle = "{block.name}{"" if self.same_address else ", no_rw_check"}" *)\n'


def find_memories(module: str, body: str) -> list[Memory]:
    """The memories of a module, in the order of their declarations."""
    return [_memory(module, match, body) for match in _DECLARATION.finditer(body)]


def with_attributes(body: str, block: MemoryBlock) -> str:
    """A module with Quartus' attribute in front of each memory that follows a template."""
    body = _FOREIGN.sub("", body)
    return _DECLARATION.sub(lambda match: _memory("", match, body).attribute(block) + match[0], body)


def _memory(module: str, declaration: re.Match[str], body: str) -> Memory:
    high, name, last = declaration.groups()
    # an address is a signal, or several of them or their bits
    word = re.compile(rf"{name}\[((?:[^\[\]]|\[[\d:]+\])+)\]")
    # each a clock and an address
    reads, writes = [], []
    for clock, target, value in _assignments(body):
        if match := word.fullmatch(target):
            writes.append((clock, match[1]))
        if match := word.fullmatch(value):
            reads.append((clock, match[1]))
    contents = re.findall(rf"^    {name}\[\d+\] = [^;]+;", body, re.MULTILINE)
    kind: Kind = "logic"
    # any other use, such as a read without a clock, is in no template
    known = 1 + len(reads) + len(writes) + len(contents)
    clocks = {clock for clock, _ in (*reads, *writes)}
    if len(re.findall(rf"\b{name}\b", body)) == known and len(clocks) == 1:
        if contents and not writes and len(reads) in (1, 2):
            kind = "ROM" if len(reads) == 1 else "dual-port ROM"
        elif len(writes) == len(reads) == 1:
            kind = "simple dual-port RAM"
    return Memory(
        module=module,
        name=name,
        width=int(high or 0) + 1,
        depth=int(last) + 1,
        kind=kind,
        same_address=bool(writes) and [place for _, place in writes] == [place for _, place in reads],
    )


def _assignments(body: str) -> Iterator[tuple[str, str, str]]:
    """Clock, target and value of each assignment in always blocks with nothing but assignments."""
    for clock, inside in _BLOCK.findall(body):
        found = []
        place = 0
        while match := _ASSIGNMENT.match(inside, place):
            found.append((clock, match[2], match[3]))
            place = match.end()
        if place == len(inside):
            yield from found
