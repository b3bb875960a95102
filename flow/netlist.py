"""Netlists in Yosys's JSON: reading and changing them, with cells of any kind."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, Generic, TypeVar

Json = dict[str, Any]
Bit = int | str
"""A net by number, or a constant as text: "0", "1" or "x"."""


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


AnyCell = TypeVar("AnyCell", bound=Cell)


class Module(Generic[AnyCell]):
    """A module and its connections: who drives a net, and who reads it.

    Parameters
    ----------
    json
        The module; changes go through to it.
    cell
        Makes a cell from its name and its JSON.
    """

    def __init__(self, json: Json, cell: Callable[[str, Json], AnyCell]) -> None:
        self.json = json
        self._cell = cell
        self.cells = {name: cell(name, each) for name, each in json["cells"].items()}
        self.index()

    def index(self) -> None:
        """Read all connections."""
        self.driver: dict[int, tuple[AnyCell, str]] = {}
        self.readers: dict[int, list[tuple[AnyCell | None, str]]] = defaultdict(list)
        for name, port in self.json["ports"].items():
            if port["direction"] == "output":
                for bit in port["bits"]:
                    if isinstance(bit, int):
                        self.readers[bit].append((None, name))
        for cell in self.cells.values():
            self._connect(cell)
        named = (bit for net in self.json["netnames"].values() for bit in net["bits"])
        self._nets = max((bit for bit in named if isinstance(bit, int)), default=1)

    def _connect(self, cell: AnyCell) -> None:
        for port, bit, output in cell.pins():
            if isinstance(bit, int):
                if output:
                    self.driver[bit] = (cell, port)
                else:
                    self.readers[bit].append((cell, port))

    def _disconnect(self, cell: AnyCell) -> None:
        for port, bit, output in cell.pins():
            if isinstance(bit, int):
                if output:
                    del self.driver[bit]
                else:
                    self.readers[bit].remove((cell, port))

    @contextmanager
    def changing(self, cell: AnyCell) -> Iterator[None]:
        """Context in which the connections of a cell may be changed."""
        self._disconnect(cell)
        yield
        self._connect(cell)

    def remove(self, cell: AnyCell) -> None:
        self._disconnect(cell)
        del self.cells[cell.name], self.json["cells"][cell.name]

    def add(self, name: str, json: Json) -> AnyCell:
        """Add a cell, connected as its JSON says."""
        cell = self._cell(name, json)
        self.json["cells"][name] = json
        self.cells[name] = cell
        self._connect(cell)
        return cell

    def new_net(self) -> int:
        """A net that nothing is connected to."""
        self._nets += 1
        return self._nets

    def of_kind(self, kind: str) -> list[AnyCell]:
        return [cell for cell in self.cells.values() if cell.kind == kind]

    def is_read(self, bit: Bit) -> bool:
        """Whether any cell or port of the module reads a net."""
        return isinstance(bit, int) and bool(self.readers[bit])

    def only_reader(self, bit: Bit) -> tuple[AnyCell, str] | None:
        """The one cell and port that reads a net, if it is only one, and no port of the module."""
        readers = self.readers[bit] if isinstance(bit, int) else []
        if len(readers) != 1 or readers[0][0] is None:
            return None
        return readers[0][0], readers[0][1]
