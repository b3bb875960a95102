"""Which memories the Verilog has, and whether Quartus can make block RAM of them.

Intel's guidelines (Quartus Prime Standard Edition User Guide: Design Recommendations, "Recommended HDL Coding
Styles", 2.4) give templates. A written memory is expected in the form of 2.4.1.5, *Single-Clock, Simple Dual-Port
Synchronous RAM with Old Data Read-During-Write Behavior*; a table in that of 2.4.2, *ROM functions*, with its
contents in an initial block as in 2.4.1.11. Both may have an enable on the read, which becomes the block's.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Literal

Kind = Literal["simple dual-port RAM", "ROM", "logic"]

_DECLARATION = re.compile(r"^  reg (?:\[(\d+):0\] )?(\w+) \[(\d+):0\];\n", re.MULTILINE)
_CLOCKED = r"always @\(posedge (\w+)\)(?: begin)?\s+(?:if \(\w+(?:\[\d+\])?\)(?: begin)?\s+)?"
_ATTRIBUTES: dict[Kind, str] = {
    "simple dual-port RAM": '  (* ramstyle = "M9K, no_rw_check" *)\n',
    "ROM": '  (* romstyle = "M9K" *)\n',
    "logic": "",
}


@dataclass(frozen=True)
class Memory:
    """One memory of a module.

    Parameters
    ----------
    module, name
        Where it is declared.
    width, depth
        Bits of a word, and words.
    kind
        ``"simple dual-port RAM"`` or ``"ROM"`` where it follows the template; ``"logic"`` where it does not,
        and Quartus would make it of flip-flops and multiplexers.
    """

    module: str
    name: str
    width: int
    depth: int
    kind: Kind

    @property
    def bits(self) -> int:
        return self.width * self.depth


def find_memories(module: str, body: str) -> list[Memory]:
    """The memories of a module, in the order of their declarations."""
    return [
        Memory(
            module=module,
            name=match[2],
            width=int(match[1] or 0) + 1,
            depth=int(match[3]) + 1,
            kind=_kind(match[2], body),
        )
        for match in _DECLARATION.finditer(body)
    ]


def _kind(name: str, body: str) -> Kind:
    word = rf"\b{name}\[[^\[\]]+(?:\[[\d:]+\])?\]"
    reads = re.findall(rf"{_CLOCKED}\w+ <= {word};", body)
    writes = re.findall(rf"{_CLOCKED}{word} <= [^;]+;", body)
    contents = re.findall(rf"^    {name}\[\d+\] = [^;]+;", body, re.MULTILINE)
    # every other way to use it, such as reading it without a clock, is in no template
    known = len(reads) + len(writes) + len(contents)
    if len(re.findall(rf"\b{name}\b", body)) != known + 1 or len(reads) != 1 or len({*reads, *writes}) != 1:
        return "logic"
    if contents and not writes:
        return "ROM"
    return "simple dual-port RAM" if len(writes) == 1 else "logic"


def with_attributes(body: str) -> str:
    """A module with an attribute in front of each memory that follows a template.

    ``M9K`` keeps Quartus from making small ones of logic. ``no_rw_check`` says that the value read from an
    address in the very clock in which it is written is never used, so that the memory block may deliver
    anything there; a test replaces all these values by noise.
    """

    def attributed(match: re.Match[str]) -> str:
        return _ATTRIBUTES[_kind(match[2], body)] + match[0]

    return _DECLARATION.sub(attributed, body)
