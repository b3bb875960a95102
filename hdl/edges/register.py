"""What a register map is made of: registers, their fields, and the width of their addresses."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Access = Literal["ro", "rw", "w1c"]
"""Read only; read and write; read, and write one to clear."""

DATA_BITS = 32
ADDRESS_BITS = 8
"""Width of a byte address; registers are 4 bytes wide."""


@dataclass(frozen=True)
class Field:
    """Some bits of a register: ``bits`` of them from bit ``low`` up.

    They are ``reset`` after reset. ``source`` is the setting or the result that they show, where
    that has another name.
    """

    name: str
    low: int
    bits: int
    text: str
    reset: int = 0
    source: str = ""

    @property
    def high(self) -> int:
        return self.low + self.bits - 1

    @property
    def mask(self) -> int:
        return ((1 << self.bits) - 1) << self.low


@dataclass(frozen=True)
class Register:
    """32 bits at a byte address; bits that belong to no field read 0."""

    name: str
    address: int
    access: Access
    text: str
    fields: tuple[Field, ...]

    @property
    def reset(self) -> int:
        return sum(field.reset << field.low for field in self.fields)

    @property
    def mask(self) -> int:
        return sum(field.mask for field in self.fields)
