"""A mapped netlist as Yosys writes it in JSON: reading and changing it, and counting what it takes."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import product
from typing import Any

from flow.cyclone4.area import Area, Block

LUT, FLIP_FLOP, MEMORY = "cycloneiv_lcell_comb", "dffeas", "altsyncram"
PRIMITIVES = (LUT, FLIP_FLOP, MEMORY)

Json = dict[str, Any]
Bit = int | str
"""A net by number, or a constant as text: "0", "1" or "x"."""
Values = dict[int, int]
"""Values of nets."""


class Cell:
    """One cell of a module; changes go through to the JSON."""

    def __init__(self, name: str, json: Json) -> None:
        self.name = name
        self.json = json
        self.kind: str = json["type"]

    def pins(self) -> Iterator[tuple[str, Bit, bool]]:
        """Port, what it is connected to and whether that is an output, bit by bit."""
        for port, bits in self.json["connections"].items():
            for bit in bits:
                yield port, bit, self.json["port_directions"][port] == "output"

    def bits(self, port: str) -> list[Bit]:
        return self.json["connections"].get(port, [])

    def __getitem__(self, port: str) -> Bit:
        """What a port of one bit is connected to; "x" for nothing."""
        bits = self.bits(port)
        return bits[0] if bits else "x"

    def __setitem__(self, port: str, bit: Bit) -> None:
        self.json["connections"][port] = [bit]

    def parameter(self, name: str) -> str:
        return self.json["parameters"][name].rstrip()

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


class Module:
    """A module and its connections: who drives a net, and who reads it."""

    def __init__(self, json: Json) -> None:
        self.json = json
        self.cells = {name: Cell(name, cell) for name, cell in json["cells"].items()}
        self.index()

    def index(self) -> None:
        """Look at all connections."""
        self.driver: dict[int, tuple[Cell, str]] = {}
        self.readers: dict[int, list[tuple[Cell | None, str]]] = defaultdict(list)
        for name, port in self.json["ports"].items():
            if port["direction"] == "output":
                for bit in port["bits"]:
                    if isinstance(bit, int):
                        self.readers[bit].append((None, name))
        for cell in self.cells.values():
            self._connect(cell)
        named = (bit for net in self.json["netnames"].values() for bit in net["bits"])
        self._nets = max((bit for bit in named if isinstance(bit, int)), default=1)

    def _connect(self, cell: Cell) -> None:
        for port, bit, output in cell.pins():
            if isinstance(bit, int):
                if output:
                    self.driver[bit] = (cell, port)
                else:
                    self.readers[bit].append((cell, port))

    def _disconnect(self, cell: Cell) -> None:
        for port, bit, output in cell.pins():
            if isinstance(bit, int):
                if output:
                    del self.driver[bit]
                else:
                    self.readers[bit].remove((cell, port))

    @contextmanager
    def changing(self, cell: Cell) -> Iterator[None]:
        """Around changes to what a cell is connected to."""
        self._disconnect(cell)
        yield
        self._connect(cell)

    def remove(self, cell: Cell) -> None:
        self._disconnect(cell)
        del self.cells[cell.name], self.json["cells"][cell.name]

    def drop_unused(self) -> None:
        """Remove tables that nobody reads."""
        idle = self.of_kind(LUT)
        while idle:
            idle = [cell for cell in idle if cell.name in self.cells and not self._is_read(cell)]
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

    def _is_read(self, cell: Cell) -> bool:
        return any(self.readers[bit] for _, bit, output in cell.pins() if output and isinstance(bit, int))

    def of_kind(self, kind: str) -> list[Cell]:
        return [cell for cell in self.cells.values() if cell.kind == kind]

    def table_behind(self, bit: Bit) -> Cell | None:
        """The table in normal mode, without carries, that drives a net."""
        if not isinstance(bit, int) or bit not in self.driver:
            return None
        cell, _ = self.driver[bit]
        return cell if cell.kind == LUT and not cell.reads_carry and not self.makes_carry(cell) else None

    def makes_carry(self, cell: Cell) -> bool:
        carry = cell["cout"]
        return isinstance(carry, int) and bool(self.readers[carry])

    def only_reader(self, bit: Bit) -> tuple[Cell, str] | None:
        """The one cell and port that reads a net, if it is only one, and no port of the module."""
        readers = self.readers[bit] if isinstance(bit, int) else []
        if len(readers) != 1 or readers[0][0] is None:
            return None
        return readers[0][0], readers[0][1]

    def add_table(self, nets: list[int], function: Callable[[Values], int]) -> int:
        """A new table in normal mode; returns the net that it drives."""
        self._nets += 1
        output = self._nets
        name = f"$table${output}"
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
        cell = Cell(name, json)
        cell.set_mask(mask_of(nets, function))
        self.json["cells"][name] = json
        self.cells[name] = cell
        self._connect(cell)
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
    """What the cells of a module take that can be counted in the netlist, without modules inside."""
    module = Module(json)
    return Area(
        lut4=len(module.of_kind(LUT)),
        ff=len(module.of_kind(FLIP_FLOP)),
        packed_pairs=packed_pairs(module),
        m9k=len(module.of_kind(MEMORY)),
    )


def area_tree(netlist: Json, top: str, memory_bits: dict[str, int], multipliers: dict[str, int]) -> Block:
    """Area of the top module and of each instance below it.

    ``memory_bits`` and ``multipliers`` are by module: the mapped cells do not tell them.
    """
    modules = netlist["modules"]

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
