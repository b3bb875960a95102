"""Area on Cyclone IV: what is counted, and how lookup tables and flip-flops make logic elements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, fields

from flow.cyclone4.device import M9K


@dataclass(frozen=True)
class Area:
    """Resources of a netlist; a logic element is one table of four inputs and one flip-flop.

    Parameters
    ----------
    lut4
        Lookup tables, those of carry chains included.
    ff
        Flip-flops outside of block RAM.
    packed_pairs
        Flip-flops that share a logic element with the table that drives their data input; each
        table once.
    m9k
        Blocks of RAM.
    memory_bits
        Bits of the words that the design declares and block RAM holds: width times depth.
    multipliers
        Embedded multipliers, in elements of 9x9 bits.
    """

    lut4: int = 0
    ff: int = 0
    packed_pairs: int = 0
    m9k: int = 0
    memory_bits: int = 0
    multipliers: int = 0

    @property
    def le_lower(self) -> int:
        """The lower bound, as in a nearly full device: every flip-flop shares an element."""
        return max(self.lut4, self.ff)

    @property
    def le_upper(self) -> int:
        """Nothing shares."""
        return self.lut4 + self.ff

    @property
    def le_packed(self) -> int:
        """The estimate: a flip-flop shares an element with its own table only."""
        return self.lut4 + self.ff - self.packed_pairs

    @property
    def used(self) -> dict[str, int]:
        """The estimate, by the names of :attr:`flow.device.Device.capacity`."""
        return {"LE": self.le_packed, M9K.name: self.m9k, "9x9 mult.": self.multipliers}

    def __add__(self, other: Area) -> Area:
        return Area(*(getattr(self, field.name) + getattr(other, field.name) for field in fields(self)))

    def as_dict(self) -> dict[str, int]:
        """All figures by name, counted and derived."""
        return {
            **asdict(self),
            "le_packed": self.le_packed,
            "le_lower": self.le_lower,
            "le_upper": self.le_upper,
        }


def total(areas: Iterable[Area]) -> Area:
    """The sum."""
    return sum(areas, Area())


@dataclass(frozen=True)
class Block:
    """A module of the netlist, and the modules inside of it.

    Parameters
    ----------
    name
        Name of the instance, or of the top module.
    own
        Area without that of the blocks inside.
    blocks
        Those blocks, in the order of the netlist.
    """

    name: str
    own: Area
    blocks: tuple[Block, ...] = ()

    @property
    def area(self) -> Area:
        """Area of the block and of all blocks inside."""
        return total([self.own, *(block.area for block in self.blocks)])

    def walk(self, depth: int = 0) -> Iterator[tuple[int, Block]]:
        """This block and all below with their depths, parents first."""
        yield depth, self
        for block in self.blocks:
            yield from block.walk(depth + 1)
