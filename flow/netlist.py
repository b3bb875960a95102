"""A mapped netlist as Yosys writes it in JSON: reading it, and counting what it takes."""

from __future__ import annotations

from typing import Any

from flow.area import Area, Block

LUT, FLIP_FLOP, MEMORY = "cycloneiv_lcell_comb", "dffeas", "altsyncram"
PRIMITIVES = (LUT, FLIP_FLOP, MEMORY)

Netlist = dict[str, Any]
Bit = int | str
"""A net by number, or a constant as text: "0", "1" or "x"."""


def cells_of(module: Netlist, kind: str) -> list[Netlist]:
    """All cells of one type."""
    return [cell for cell in module["cells"].values() if cell["type"] == kind]


def pin(cell: Netlist, port: str) -> Bit:
    """What a port of one bit is connected to; "x" for nothing."""
    bits = cell["connections"].get(port)
    return bits[0] if bits else "x"


def packed_pairs(module: Netlist) -> int:
    """Flip-flops that share a logic element with the table that drives them; a table takes one."""
    tables = {pin(cell, "combout") for cell in cells_of(module, LUT)}
    return len(tables & {pin(cell, "d") for cell in cells_of(module, FLIP_FLOP)} - {"x", "0", "1"})


def area_tree(netlist: Netlist, top: str, memory_bits: dict[str, int], multipliers: dict[str, int]) -> Block:
    """Area of the top module and of each instance below it.

    ``memory_bits`` and ``multipliers`` are by module: the mapped cells do not tell them.
    """
    modules = netlist["modules"]

    def block(name: str, kind: str) -> Block:
        module = modules[kind]
        known = [(instance, cell["type"]) for instance, cell in module["cells"].items()]
        foreign = {kind for _, kind in known if kind not in PRIMITIVES and kind not in modules}
        if foreign:
            raise ValueError(
                f"module {kind} holds cells that the map does not know: {', '.join(sorted(foreign))}"
            )
        own = Area(
            lut4=len(cells_of(module, LUT)),
            ff=len(cells_of(module, FLIP_FLOP)),
            packed_pairs=packed_pairs(module),
            m9k=len(cells_of(module, MEMORY)),
            memory_bits=memory_bits.get(kind, 0),
            multipliers=multipliers.get(kind, 0),
        )
        inside = tuple(block(instance, kind) for instance, kind in known if kind not in PRIMITIVES)
        return Block(name, own, inside)

    return block(top, top)
