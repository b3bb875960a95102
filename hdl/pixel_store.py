# amaranth: UnusedElaboratable=no
"""The last rows of pixels in block RAM, to be read anywhere, for gradient steps."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Array, Cat, Module, Mux, Signal, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Member, Out

from golden.parameters import Parameters
from hdl.parts.probes import probe
from hdl.parts.stream import Beat

BANKS = 4
"""Rows that can be read at once: row r lies in bank r modulo 4."""
PART = 2
"""Bits of a memory: a block RAM holds more words of two bits, and none has to be chosen from."""


class PixelStore(wiring.Component):
    """Passes pixels on, and keeps the last rows of them.

    Rows are numbered through all frames, modulo twice the rows that are kept, so that it can be
    told which of two numbers is the older. A row takes the place of one so many rows before. Its
    first pixel waits until that one is not needed any more; no other pixel ever waits.

    The banks' addresses put the row below the column, so that neither has to be multiplied.

    Parameters
    ----------
    parameters
        Parameters of the detector; ``pixel_bits`` and ``max_width`` matter.
    rows
        Rows that are kept, a power of two from 8.

    Members
    -------
    i, o
        Streams of ``Beat(unsigned(pixel_bits))``, in the same clock.
    needed
        Number of the oldest row that is still needed, never more than one ahead of the last row
        that was passed on.
    reading
        The registers for reading move.
    place
        Row and column of the topmost pixel that is read.
    column
        That pixel and the three below it, ``read_latency`` such clocks later.
    """

    latency = 0
    read_latency = 3

    def __init__(self, parameters: Parameters, rows: int) -> None:
        self._rows = rows
        self._max_width = parameters.max_width
        self._pixel = pixel = unsigned(parameters.pixel_bits)
        super().__init__(
            {
                "i": In(stream.Signature(Beat(pixel))),
                "o": Out(stream.Signature(Beat(pixel))),
                **store_members(parameters, rows),
            }
        )

    @property
    def memory_bits(self) -> int:
        return self._rows * self._max_width * self._pixel.width

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        waiting = Signal()
        step = self.o.valid & self.o.ready
        m.d.comb += [
            self.o.valid.eq(self.i.valid & ~waiting),
            self.i.ready.eq(self.o.ready & ~waiting),
            self.o.payload.eq(self.i.payload),
        ]
        row, x = Signal(range(2 * self._rows)), Signal(range(self._max_width))
        # a clock late, which is known well before the row ends
        occupied, ended = Signal(), Signal()
        following = (row + 1)[: len(row)]
        m.d.sync += occupied.eq((following - self.needed)[len(row) - 1])
        m.d.comb += ended.eq(step & self.i.payload.eol)
        with m.If(step):
            m.d.sync += x.eq(Mux(self.i.payload.eol, 0, x + 1))
        with m.If((ended | waiting) & ~occupied):
            m.d.sync += row.eq(following)
        with m.If(ended | waiting):
            m.d.sync += waiting.eq(occupied)
        self._banks(m, row, x, step)
        probe(self, row=row, x=x, waiting=waiting, occupied=occupied)
        return m

    def _banks(self, m: Module, row: Signal, x: Signal, step: Any) -> None:
        slot_bits = (self._rows // BANKS - 1).bit_length()
        slot = row[2 : 2 + slot_bits]
        top, read_out = self.place.row, []
        for number in range(BANKS):
            kept = Signal(self._pixel, name=f"kept_{number}", reset_less=True)
            # below the topmost row, banks of smaller numbers hold the rows after the next multiple
            # of four
            later = top[:2] > number
            data = []
            for low in range(0, self._pixel.width, PART):
                part = self.i.payload.data[low : low + PART]
                m.submodules[f"bank_{number}_{low}"] = memory = Memory(
                    shape=len(part),
                    depth=self._max_width * self._rows // BANKS,
                    init=[],
                    attrs={"ram_style": "block"},
                )
                writing, reading = memory.write_port(), memory.read_port()
                m.d.comb += [
                    writing.addr.eq(Cat(slot, x)),
                    writing.data.eq(part),
                    writing.en.eq(step & (row[:2] == number)),
                    reading.addr.eq(Cat((top[2:] + later)[:slot_bits], self.place.x)),
                    reading.en.eq(self.reading),
                ]
                data.append(reading.data)
            with m.If(self.reading):
                m.d.sync += kept.eq(Cat(data))
            read_out.append(kept)
        first = top[:2]
        for k in range(2):
            later_first = Signal(range(BANKS), name=f"first_{k}", reset_less=True)
            with m.If(self.reading):
                m.d.sync += later_first.eq(first)
            first = later_first
        with m.If(self.reading):
            m.d.sync += [self.column[k].eq(Array(read_out)[(first + k)[:2]]) for k in range(BANKS)]


def store_members(parameters: Parameters, rows: int) -> dict[str, Member]:
    """Members of the store beside its streams, as it sees them."""
    return {
        "needed": In(range(2 * rows)),
        "reading": In(1),
        "place": In(place_layout(parameters, rows)),
        "column": Out(data.ArrayLayout(unsigned(parameters.pixel_bits), BANKS)),
    }


def place_layout(parameters: Parameters, rows: int) -> data.StructLayout:
    """A row by its place in the store, and a column."""
    return data.StructLayout({"row": range(rows), "x": range(parameters.max_width)})
