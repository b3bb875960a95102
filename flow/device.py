"""A device: its name, its resources, and the tools that know it.

How to add one:

- Another device of a family that is here: one line in the table of ``flow/FAMILY/device.py``.
- Another family: a folder ``flow/FAMILY/`` whose ``device.py`` defines ``DEVICES``, and one line in
  :data:`flow.devices.DEVICES`. If Quartus compiles it (``tool="quartus"``), ``cornerstream quartus
  export`` takes it from then on. If nextpnr does, ``cornerstream synth`` places and routes it.
- The figures come from the maker's data sheet, which ``source`` names.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Literal

Tool = Literal["quartus", "nextpnr"]


@dataclass(frozen=True)
class MemoryBlock:
    """A block of RAM: its name in reports, and its bits."""

    name: str
    bits: int


@dataclass(frozen=True)
class Use:
    """How much of one resource of a device a core needs."""

    resource: str
    used: int
    available: int

    @property
    def fits(self) -> bool:
        return self.used <= self.available

    @property
    def percent(self) -> float | None:
        """Used part of what is available; None where the device has none."""
        return 100 * self.used / self.available if self.available else None

    def __str__(self) -> str:
        share = "" if self.percent is None else f" ({self.percent:.1f} %)"
        return f"{self.used:,} of {self.available:,} {self.resource}{share}"


@dataclass(frozen=True, kw_only=True)
class Device:
    """A device: size, package and speed grade.

    Parameters
    ----------
    name
        The name that ``--device`` takes: the beginning of the part number, in small letters.
    part
        The part number that the vendor's tool takes.
    order
        Regular expression for what follows the name in a part number, with the groups ``package``
        and ``speed``.
    family
        The name in the vendor's tool.
    logic
        Units in which logic is counted; there are ``logic_elements`` of each.
    logic_elements
        Lookup tables of four inputs, each with one flip-flop.
    memory, memory_blocks
        The kind of block RAM, and the number of blocks.
    multipliers
        Embedded multipliers of 18x18 bits.
    tool
        The tool that compiles for it.
    stand_in
        Name of the device that is placed and routed in its place, because no free tool knows the
        delays of this one; None where nextpnr knows the device itself.
    source
        The source of the figures.
    """

    name: str
    part: str
    order: str
    family: str
    logic: tuple[str, ...]
    logic_elements: int
    memory: MemoryBlock
    memory_blocks: int
    multipliers: int
    tool: Tool
    stand_in: str | None = None
    source: str

    def __str__(self) -> str:
        return f"{self.part} ({self.family})"

    @property
    def memory_bits(self) -> int:
        return self.memory_blocks * self.memory.bits

    @property
    def package(self) -> str:
        return self._ordered["package"]

    @property
    def speed_grade(self) -> str:
        return self._ordered["speed"]

    @property
    def capacity(self) -> dict[str, int]:
        """How much there is, by the name of the resource."""
        return {
            **dict.fromkeys(self.logic, self.logic_elements),
            self.memory.name: self.memory_blocks,
            # an 18x18 multiplier is two of 9x9
            "9x9 mult.": 2 * self.multipliers,
        }

    def use(self, used: Mapping[str, int]) -> list[Use]:
        """What a core needs and what there is; ``used`` is by names of :attr:`capacity`."""
        return [Use(resource, number, self.capacity[resource]) for resource, number in used.items()]

    def with_part(self, part: str) -> Device | None:
        """This device in the package and speed grade of a part number; None for another device."""
        fits = re.fullmatch(re.escape(self.name.upper()) + self.order, part.upper())
        return replace(self, part=part.upper()) if fits else None

    @property
    def _ordered(self) -> re.Match[str]:
        match = re.fullmatch(self.order, self.part[len(self.name) :])
        if match is None:
            raise ValueError(f"part is {self.part!r}; allowed: {self.name.upper()}, then {self.order}")
        return match
