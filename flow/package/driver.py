"""Registers of the core by name, over anything that reads and writes words; it needs only Python.

    registers = Cornerstream(mmio.read, mmio.write)
    registers.set(width=640, height=480, enable=1)
    while not registers.get("frame_done"):
        pass
    registers.clear("frame_done")

Where reading and writing take an ``await``, take the map by itself::

    word = await bus.read_dword(MAP.address("STATUS"))
    await bus.write_dword(MAP.address("SIZE"), MAP.encode("SIZE", width=640, height=480))
    if MAP.decode("STATUS", word)["size_refused"]: ...

Registers have names in capitals, their fields in small letters; no field has the name of another
register's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from operator import index
from typing import NamedTuple


class Field(NamedTuple):
    """Some bits of a register, from ``low`` up.

    A command acts when 1 is written to it; 0 has no effect.
    """

    low: int
    bits: int
    command: bool = False

    @property
    def mask(self) -> int:
        return ((1 << self.bits) - 1) << self.low


class Register(NamedTuple):
    """A word at a byte address.

    Access is ``ro``, ``rw`` or ``w1c``: read only, read and write, or write one to clear.
    """

    address: int
    access: str
    reset: int
    fields: Mapping[str, Field]

    @property
    def mask(self) -> int:
        return sum(field.mask for field in self.fields.values())


def _whole(value: object) -> int:
    """The value if it is a whole number, also NumPy's; otherwise -1, which is never allowed."""
    return index(value) if hasattr(value, "__index__") else -1


class Map:
    """The registers, and the places of their fields in words.

    Every mistake is a ``ValueError`` that says what is allowed.
    """

    def __init__(self, registers: Mapping[str, Register]) -> None:
        self.registers = dict(registers)
        self._homes = {field: name for name, register in registers.items() for field in register.fields}

    def register(self, name: str) -> Register:
        if name not in self.registers:
            raise ValueError(f"register is {name!r}; allowed: {', '.join(self.registers)}")
        return self.registers[name]

    def address(self, name: str) -> int:
        """Address of a register, in bytes."""
        return self.register(name).address

    def home(self, field: str) -> str:
        """The register that a field is in."""
        if field not in self._homes:
            raise ValueError(f"field is {field!r}; allowed: {', '.join(self._homes)}")
        return self._homes[field]

    def encode(self, name: str, **values: int) -> int:
        """The word of a register from values of its fields; fields without a value are 0."""
        fields, word = self.register(name).fields, 0
        for field, value in values.items():
            if field not in fields:
                raise ValueError(f"field of {name} is {field!r}; allowed: {', '.join(fields)}")
            highest = (1 << fields[field].bits) - 1
            if not 0 <= _whole(value) <= highest:
                raise ValueError(f"{field} is {value!r}; allowed: whole numbers from 0 to {highest}")
            word |= index(value) << fields[field].low
        return word

    def decode(self, name: str, word: int) -> dict[str, int]:
        """Values of all fields of a register, from its word."""
        return {
            field: (word & place.mask) >> place.low for field, place in self.register(name).fields.items()
        }


class Registers:
    """Reads and writes by name.

    Parameters
    ----------
    registers
        The map of the core.
    read, write
        ``read(address)`` returns the word at a byte address, counted from the core's first;
        ``write(address, word)`` writes one.
    """

    def __init__(
        self, registers: Map, read: Callable[[int], int], write: Callable[[int, int], object]
    ) -> None:
        self.map = registers
        self._read, self._write = read, write

    def read(self, name: str) -> int:
        """The word of a register."""
        return int(self._read(self.map.address(name)))

    def write(self, name: str, word: int) -> None:
        """Writes a register as a whole."""
        register = self.map.register(name)
        if register.access == "ro":
            raise ValueError(f"register {name} is read only; allowed: {self._writable()}")
        if _whole(word) & ~register.mask:
            raise ValueError(f"{name} is {word!r}; allowed: bits of {register.mask:#010x}")
        self._write(register.address, index(word))

    def wide(self, name: str) -> int:
        """The number of 64 bits in two registers, ``NOW`` or ``FRAME_TIME``.

        It may change between two reads; so it is read until its high half has stayed.
        """
        high = self.read(f"{name}_HIGH")
        while True:
            low, before, high = self.read(f"{name}_LOW"), high, self.read(f"{name}_HIGH")
            if high == before:
                return high << 32 | low

    def fields(self, name: str) -> dict[str, int]:
        """Reads a register: the values of its fields."""
        return self.map.decode(name, self.read(name))

    def get(self, field: str) -> int:
        """Reads a field."""
        return self.fields(self.map.home(field))[field]

    def set(self, **values: int) -> None:
        """Writes fields, also of several registers; all other fields keep their values.

        Each register is written once, in the order of the first fields; none is written if a value
        is wrong.
        """
        words: dict[str, dict[str, int]] = {}
        for field, value in values.items():
            name = self.map.home(field)
            if self.map.register(name).access != "rw":
                raise ValueError(f"field {field} cannot be set; allowed: fields of {self._writable('rw')}")
            words.setdefault(name, {})[field] = value
        encoded = {name: self.map.encode(name, **fields) for name, fields in words.items()}
        for name, word in encoded.items():
            self.write(name, word | self._others(name, words[name]))

    def clear(self, *fields: str) -> None:
        """Clears fields by writing ones to them; all clearable fields if none is named."""
        found: dict[str, dict[str, int]] = {}
        clearable = [name for name, register in self.map.registers.items() if register.access == "w1c"]
        for field in fields or [field for name in clearable for field in self.map.register(name).fields]:
            name = self.map.home(field)
            if name not in clearable:
                raise ValueError(
                    f"field {field} cannot be cleared; allowed: fields of {', '.join(clearable)}"
                )
            found.setdefault(name, {})[field] = (1 << self.map.register(name).fields[field].bits) - 1
        for name, values in found.items():
            self.write(name, self.map.encode(name, **values))

    def _others(self, name: str, given: Mapping[str, int]) -> int:
        """The word of a register without these fields; it is read only where it has other ones."""
        others = [
            field
            for key, field in self.map.register(name).fields.items()
            if key not in given and not field.command
        ]
        return self.read(name) & sum(field.mask for field in others) if others else 0

    def _writable(self, *kinds: str) -> str:
        allowed = kinds or ("rw", "w1c")
        return ", ".join(name for name, register in self.map.registers.items() if register.access in allowed)
