"""A netlist of Cyclone IV's cells: their tables, and what a netlist takes of the device."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product

from flow import netlist
from flow.cyclone4.area import Area, Block
from flow.netlist import Bit, Json

LUT, FLIP_FLOP, MEMORY = "cycloneiv_lcell_comb", "dffeas", "altsyncram"
MULTIPLIER, PRODUCT = "cycloneiv_mac_mult", "cycloneiv_mac_out"
"""The two halves of an embedded multiplier."""
PRIMITIVES = (LUT, FLIP_FLOP, MEMORY, MULTIPLIER, PRODUCT)

Values = dict[int, int]
"""Values of nets."""


class Cell(netlist.Cell):
    """One cell of a module; the members below are those of a table."""

    @property
    def mask(self) -> int:
        return int(self.parameter("lut_mask"), 2)

    def set_mask(self, mask: int) -> None:
        self.json["parameters"]["lut_mask"] = f"{mask:016b}"

    @property
    def data(self) -> tuple[Bit, Bit, Bit, Bit]:
        """Inputs a to d of a table."""
        return self["dataa"], self["datab"], self["datac"], self["datad"]

    @property
    def nets(self) -> set[int]:
        """Nets among the data inputs of a table."""
        return {bit for bit in self.data if isinstance(bit, int)}

    @property
    def reads_carry(self) -> bool:
        return isinstance(self["cin"], int)

    def output(self, values: Values) -> int:
        """Output of a table in normal mode, for values of the nets at its data inputs."""
        a, b, c, d = (values[bit] if isinstance(bit, int) else int(bit == "1") for bit in self.data)
        return self.mask >> (a | b << 1 | c << 2 | d << 3) & 1


class Module(netlist.Module[Cell]):
    """A module of such cells."""

    def __init__(self, json: Json) -> None:
        super().__init__(json, Cell)

    def drop_unused(self) -> None:
        """Remove tables that nobody reads."""
        idle = self.of_kind(LUT)
        while idle:
            idle = [cell for cell in idle if cell.name in self.cells and not self._is_in_use(cell)]
            before = {self.driver[net][0].name for cell in idle for net in cell.nets if net in self.driver}
            before |= {
                self.driver[net][0].name
                for cell in idle
                if isinstance(net := cell["cin"], int) and net in self.driver
            }
            for cell in idle:
                self.remove(cell)
            idle = [
                self.cells[name] for name in before if name in self.cells and self.cells[name].kind == LUT
            ]

    def _is_in_use(self, cell: Cell) -> bool:
        return any(self.is_read(bit) for _, bit, output in cell.pins() if output)

    def table_behind(self, bit: Bit) -> Cell | None:
        """The table in normal mode, without carries, that drives a net."""
        if not isinstance(bit, int) or bit not in self.driver:
            return None
        cell, _ = self.driver[bit]
        return cell if cell.kind == LUT and not cell.reads_carry and not self.makes_carry(cell) else None

    def makes_carry(self, cell: Cell) -> bool:
        return self.is_read(cell["cout"])

    def add_table(self, nets: list[int], function: Callable[[Values], int]) -> int:
        """A new table in normal mode; returns the net that it drives."""
        output = self.new_net()
        data: list[Bit] = [*nets, *["1"] * (4 - len(nets))]
        json: Json = {
            "hide_name": 1,
            "type": LUT,
            "parameters": {"lut_mask": "", "sum_lutc_input": "datac"},
            "attributes": {},
            "port_directions": {
                **{f"data{letter}": "input" for letter in "abcd"},
                "combout": "output",
            },
            "connections": {
                **{f"data{letter}": [bit] for letter, bit in zip("abcd", data, strict=True)},
                "combout": [output],
            },
        }
        self.add(f"$table${output}", json).set_mask(mask_of(nets, function))
        return output


def mask_of(nets: list[int], function: Callable[[Values], int]) -> int:
    """Mask of a table of up to four nets, the first one at input a."""
    values = ({net: index >> place & 1 for place, net in enumerate(nets)} for index in range(16))
    return sum(function(value) << index for index, value in enumerate(values))


def assignments(nets: list[int]) -> Iterator[Values]:
    """All values that nets can have."""
    for values in product((0, 1), repeat=len(nets)):
        yield dict(zip(nets, values, strict=True))


def packed_pairs(module: Module) -> int:
    """Flip-flops that share a logic element with the table that drives them; a table takes one."""
    driven = {cell["d"] for cell in module.of_kind(FLIP_FLOP)}
    return len(driven & {cell["combout"] for cell in module.of_kind(LUT)} - {"x", "0", "1"})


def own_area(json: Json) -> Area:
    """Area of a module without the modules inside, as far as the netlist tells it."""
    module = Module(json)
    return Area(
        lut4=len(module.of_kind(LUT)),
        ff=len(module.of_kind(FLIP_FLOP)),
        packed_pairs=packed_pairs(module),
        m9k=len(module.of_kind(MEMORY)),
    )


def area_tree(design: Json, top: str, memory_bits: dict[str, int], multipliers: dict[str, int]) -> Block:
    """Area of the top module and of each instance below it.

    ``memory_bits`` and ``multipliers`` are by module: the mapped cells do not tell them.
    ``ValueError`` if a module has cells that the map does not know.
    """
    modules = design["modules"]

    def block(name: str, kind: str) -> Block:
        cells = {instance: cell["type"] for instance, cell in modules[kind]["cells"].items()}
        inside = {instance: module for instance, module in cells.items() if module not in PRIMITIVES}
        foreign = set(inside.values()) - set(modules)
        if foreign:
            raise ValueError(
                f"module {kind} holds cells that the map does not know: {', '.join(sorted(foreign))}"
            )
        declared = Area(memory_bits=memory_bits.get(kind, 0), multipliers=multipliers.get(kind, 0))
        blocks = tuple(block(instance, module) for instance, module in inside.items())
        return Block(name, own_area(modules[kind]) + declared, blocks)

    return block(top, top)
