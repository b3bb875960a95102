"""Packing: joins logic cells of a mapped netlist where one cell can compute both functions.

The map makes chains and tables one by one. A cell of a chain, however, computes any two functions
of two data inputs and its carry in: its output and its carry out. The last one of a chain, whose
carry out nobody reads, computes any function of three data inputs and its carry in: that is normal
mode with the carry in as an input. So the following need no cell of their own:

- tables that each of their readers can compute as well: an operand that is complemented or masked,
  the (d ^ s) of a conditional negation (d ^ s) + s;
- a table behind a sum that nobody else reads, while the sum's cell has an input to spare: the
  clearing of a counter, or what follows a comparison;
- what puts a signal on a chain, where the first bit knows that signal or has a data input to spare;
- what takes the last carry of a comparison off the chain, while nobody reads the last difference.

Each rule saves a cell for the same function, and changes nothing else in the netlist. It works on
Yosys's JSON, one module at a time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

from flow.cyclone4.netlist import LUT
from flow.netlist import Bit, Json

CHAIN_DATA, LAST_DATA, PLAIN_DATA = 2, 3, 4
"""Data inputs of a cell whose carry out is read, with a carry in only, and without carries."""


@dataclass(frozen=True)
class Function:
    """A Boolean function of nets.

    Parameters
    ----------
    inputs
        The nets that it depends on, ascending.
    table
        Bit ``k`` is the value where the inputs are the bits of ``k``, the first input the lowest.
    """

    inputs: tuple[int, ...]
    table: int

    @classmethod
    def of(cls, pins: Sequence[Bit], table: int) -> Function:
        """From a table whose inputs may be constant, the same net twice, or without effect.

        "x" counts as 0.
        """
        nets = sorted({at for at in pins if isinstance(at, int)})
        fixed = sum(1 << k for k, at in enumerate(pins) if at == "1")
        masks = [sum(1 << k for k, at in enumerate(pins) if at == net) for net in nets]
        values = 0
        for index in range(1 << len(nets)):
            address = fixed + sum(mask for k, mask in enumerate(masks) if index >> k & 1)
            values |= (table >> address & 1) << index
        for k, net in enumerate(nets):
            low = sum(1 << index for index in range(1 << len(nets)) if not index >> k & 1)
            if values & low == values >> (1 << k) & low:
                return cls.of(["0" if at == net else at for at in nets], values)
        return cls(tuple(nets), values)

    def value(self, ones: set[int]) -> int:
        """Value where these nets are 1, and all others 0."""
        return self.table >> sum(1 << k for k, net in enumerate(self.inputs) if net in ones) & 1

    def with_input(self, net: int, inner: Function) -> Function:
        """The same with another function in place of one input."""
        if net not in self.inputs:
            return self
        nets = sorted({*self.inputs, *inner.inputs} - {net})
        table = 0
        for index in range(1 << len(nets)):
            ones = {at for k, at in enumerate(nets) if index >> k & 1}
            table |= self.value(ones | {net} if inner.value(ones) else ones) << index
        return Function.of(nets, table)


@dataclass(frozen=True)
class Cell:
    """Functions of a logic cell, and the nets of their results; unread functions are None."""

    sum: Function | None
    carry: Function | None
    combout: Bit
    cin: Bit
    cout: Bit

    @cached_property
    def reads(self) -> set[int]:
        """All its inputs, the carry among them."""
        return {net for function in (self.sum, self.carry) if function for net in function.inputs}

    @property
    def fits(self) -> bool:
        """Whether the device has such a cell."""
        return self.could_read(self.reads)

    def could_read(self, nets: set[int]) -> bool:
        """Whether the device has such a cell with these inputs instead of its own."""
        data = len(nets - {self.cin})
        if self.carry:
            return data <= CHAIN_DATA
        return data <= (LAST_DATA if self.cin in nets else PLAIN_DATA)

    def with_table(self, table: Cell) -> Cell:
        """The same with the function of the table before it."""
        assert table.sum is not None and isinstance(table.combout, int)
        return self.with_input(table.combout, table.sum)

    def with_input(self, net: int, inner: Function) -> Cell:
        """The same with a function in place of one input."""
        return Cell(
            self.sum and self.sum.with_input(net, inner),
            self.carry and self.carry.with_input(net, inner),
            self.combout,
            self.cin,
            self.cout,
        )


def pack(module: Json) -> None:
    """Join logic cells of one module, in place."""
    _Packing(module).run()


class _Packing:
    """The logic cells of one module by name, and who reads and drives which net."""

    def __init__(self, module: Json) -> None:
        self._module = module
        self._cells: dict[str, Cell] = {}
        self._drivers: dict[Bit, str] = {}
        self._readers: dict[Bit, dict[str, None]] = {}
        # nets read by anything except data and carry inputs of logic cells
        self._elsewhere: set[Bit] = set()
        self._changed = False
        for port in module["ports"].values():
            if port["direction"] != "input":
                self._elsewhere.update(port["bits"])
        for name, cell in module["cells"].items():
            if cell["type"] == LUT:
                self._add(name, _function_of(cell))
                continue
            for port, bits in cell["connections"].items():
                if cell["port_directions"][port] != "output":
                    self._elsewhere.update(bits)

    def run(self) -> None:
        """Apply all rules until none of them changes anything."""
        self._changed = True
        while self._changed:
            self._changed = False
            for rule in (self._drop, self._off_the_chain, self._onto_the_chain, self._before, self._behind):
                for name in list(self._cells):
                    if name in self._cells:
                        rule(name)
        self._write()

    def _add(self, name: str, cell: Cell) -> None:
        self._cells[name] = cell
        for net in (cell.combout, cell.cout):
            if isinstance(net, int):
                self._drivers[net] = name
        for read in cell.reads:
            self._readers.setdefault(read, {})[name] = None

    def _remove(self, name: str) -> Cell:
        self._changed = True
        cell = self._cells.pop(name)
        for net in (cell.combout, cell.cout):
            self._drivers.pop(net, None)
        for read in cell.reads:
            del self._readers[read][name]
        return cell

    def _replace(self, name: str, cell: Cell) -> None:
        self._remove(name)
        self._add(name, cell)

    def _readers_of(self, net: Bit) -> list[str]:
        return list(self._readers.get(net, ()))

    def _is_read(self, net: Bit) -> bool:
        return net in self._elsewhere or bool(self._readers.get(net))

    def _only_reader(self, net: Bit) -> str | None:
        readers = self._readers_of(net)
        return readers[0] if len(readers) == 1 and net not in self._elsewhere else None

    def _drop(self, name: str) -> None:
        """Functions that nobody reads, and cells without any."""
        cell = self._cells[name]
        kept = Cell(
            cell.sum if self._is_read(cell.combout) else None,
            cell.carry if self._is_read(cell.cout) else None,
            cell.combout,
            cell.cin,
            cell.cout,
        )
        if kept.sum is None and kept.carry is None:
            self._remove(name)
        elif kept != cell:
            self._replace(name, kept)

    def _off_the_chain(self, name: str) -> None:
        """The cell before the last, used only for its carry, takes the last one's function."""
        last = self._cells[name]
        before = self._drivers.get(last.cin)
        if last.sum is None or last.carry or before is None or not isinstance(last.cin, int):
            return
        cell = self._cells[before]
        if cell.sum or cell.carry is None or self._only_reader(last.cin) != name:
            return
        joined = Cell(last.sum.with_input(last.cin, cell.carry), None, last.combout, cell.cin, "x")
        if joined.fits:
            self._remove(before)
            self._replace(name, joined)

    def _onto_the_chain(self, name: str) -> None:
        """The first bit's cell computes the carry that comes in by itself."""
        cell = self._cells[name]
        before = self._drivers.get(cell.cin)
        if before is None or not isinstance(cell.cin, int) or self._only_reader(cell.cin) != name:
            return
        first = self._cells[before]
        if first.sum or first.carry is None or first.cin in first.reads:
            return
        joined = cell.with_input(cell.cin, first.carry)
        joined = Cell(joined.sum, joined.carry, joined.combout, "x", joined.cout)
        if joined.fits:
            self._remove(before)
            self._replace(name, joined)

    def _before(self, name: str) -> None:
        """A table goes into all cells that read it, if needed together with another table."""
        if not self._is_table(name):
            return
        stopped = self._into_readers([name])
        if stopped is None:
            return
        for net in sorted(self._cells[stopped].reads):
            other = self._drivers.get(net, name)
            if other != name and self._is_table(other) and self._into_readers([name, other]) is None:
                return

    def _is_table(self, name: str) -> bool:
        cell = self._cells[name]
        return (
            cell.sum is not None
            and cell.carry is None
            and cell.cin not in cell.reads
            and cell.combout not in self._elsewhere
            and bool(self._readers_of(cell.combout))
        )

    def _into_readers(self, tables: list[str]) -> str | None:
        """Put the tables into their readers, or return the first reader that cannot take all."""
        behind = {self._cells[table].combout: self._cells[table] for table in tables}
        readers = list(dict.fromkeys(name for net in behind for name in self._readers_of(net)))
        for reader in readers:
            cell = self._cells[reader]
            before = [table.reads for net, table in behind.items() if net in cell.reads]
            if reader in tables or not cell.could_read((cell.reads - behind.keys()).union(*before)):
                return reader
        for name in tables:
            self._remove(name)
        for reader in readers:
            cell = self._remove(reader)
            for table in behind.values():
                cell = cell.with_table(table)
            self._add(reader, cell)
        return None

    def _behind(self, name: str) -> None:
        """A table goes into the cell of a chain whose sum it alone reads."""
        cell = self._cells[name]
        reader = self._only_reader(cell.combout)
        if cell.sum is None or reader is None or not (cell.carry or cell.cin in cell.reads):
            return
        table = self._cells[reader]
        if table.sum is None or table.carry or table.cin in table.reads:
            return
        # what depends on the carry must not come back into the cell that makes it
        if cell.carry and self._depend(table.reads - {cell.combout}, name):
            return
        joined = Cell(table.with_table(cell).sum, cell.carry, table.combout, cell.cin, cell.cout)
        if joined.fits:
            self._remove(reader)
            self._replace(name, joined)

    def _depend(self, nets: set[int], name: str) -> bool:
        """Whether any of the nets comes from a cell, directly or through other tables."""
        seen: set[str] = set()
        waiting = list(nets)
        while waiting:
            driver = self._drivers.get(waiting.pop())
            if driver is not None and driver not in seen:
                seen.add(driver)
                waiting += self._cells[driver].reads
        return name in seen

    def _write(self) -> None:
        # all of them: a net that a cell no longer depends on may not exist any more
        cells = self._module["cells"]
        for name in [name for name, cell in cells.items() if cell["type"] == LUT]:
            if name in self._cells:
                _write_cell(cells[name], self._cells[name])
            else:
                del cells[name]


def _function_of(cell: Json) -> Cell:
    mask = int(cell["parameters"]["lut_mask"], 2)
    a, b, c, d, cin = (_pin(cell, port) for port in ("dataa", "datab", "datac", "datad", "cin"))
    third = cin if cell["parameters"]["sum_lutc_input"] == "cin" else c
    combout, cout = _pin(cell, "combout"), _pin(cell, "cout")
    return Cell(
        Function.of([a, b, third, d], mask) if isinstance(combout, int) else None,
        Function.of([a, b, cin], mask & 0xFF) if isinstance(cout, int) else None,
        combout,
        cin,
        cout,
    )


def _write_cell(into: Json, cell: Cell) -> None:
    chained = cell.cin in cell.reads
    data: list[Bit] = sorted(cell.reads - {cell.cin})
    data += ["1"] * (4 - len(data))
    third, fourth = (cell.cin, data[2]) if chained else (data[2], data[3])
    pins = [*data[:2], third, fourth]
    # with the fourth input high, the upper half is the sum's table; the lower one is the carry's
    halves = [(cell.sum, pins), (cell.sum, pins)]
    if cell.carry:
        halves[0] = (cell.carry, [*data[:2], cell.cin])
    mask = 0
    for index in range(16):
        function, at = halves[index >> 3]
        ones = {net for k, net in enumerate(at) if index >> k & 1 and isinstance(net, int)}
        mask |= (function.value(ones) if function else 0) << index
    into["parameters"] = {"lut_mask": f"{mask:016b}", "sum_lutc_input": "cin" if chained else "datac"}
    inputs = {"dataa": data[0], "datab": data[1], "datac": "1" if chained else third, "datad": fourth}
    if chained or cell.carry:
        inputs["cin"] = cell.cin if chained else "0"
    outputs = {"combout": cell.combout} if cell.sum else {}
    if cell.carry:
        outputs["cout"] = cell.cout
    into["connections"] = {port: [net] for port, net in (inputs | outputs).items()}
    into["port_directions"] = dict.fromkeys(inputs, "input") | dict.fromkeys(outputs, "output")


def _pin(cell: Json, port: str) -> Bit:
    bits = cell["connections"].get(port)
    return bits[0] if bits else "x"
