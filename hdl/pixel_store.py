# amaranth: UnusedElaboratable=no
"""The last rows of pixels in block RAM, to be read anywhere, for gradient steps."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Array, Cat, Module, Mux, Signal, Value, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Member, Out

from hdl.build import Build
from hdl.parts.lanes import each_lane, lane_name, lanes_of
from hdl.parts.probes import probe
from hdl.parts.stream import Beat
from hdl.sample import pixels_shape
from hdl.step_layouts import columns_read

BANKS = 4
"""Rows that can be read at once: row r lies in bank r modulo 4."""
PART = 2
"""Bits of a memory: a block RAM holds more words of two bits, and none has to be chosen from.

With several pixels per clock there are as many times fewer words, and as many times more bits.
"""

_BANKS_LATENCY = 2
"""A memory's own register, and one behind it."""


class PixelStore(wiring.Component):
    """Passes pixels on, and keeps the last rows of them.

    Rows are numbered through all frames, modulo twice the rows that are kept, so that it can be
    told which of two numbers is the older. A row takes the place of one so many rows before. Its
    first beat waits until that one is not needed any more; no other beat ever waits.

    Each lane of a beat has banks of its own, so that neighbouring columns are read at once,
    wherever the first of them lies: column x is in lane x modulo P, the lanes to the left of the
    first column's have the columns of the next beat.

    The banks' addresses put the row below the beat, so that neither has to be multiplied.

    Parameters
    ----------
    build
        Parameters of the detector; ``pixel_bits``, ``max_width`` and ``pixels_per_clock`` matter.
    rows
        Rows that are kept, a power of two from 8.

    Members
    -------
    i, o
        Streams of ``Beat(pixels_shape(build))``, in the same clock.
    needed
        Number of the oldest row that is still needed, never more than one ahead of the last row
        that was passed on.
    reading
        The registers for reading move.
    place
        Row and column of the topmost pixel that is read.
    column
        That pixel and the three below it, and as many in each of the columns behind it that
        :func:`hdl.step_layouts.columns_read` tells; ``read_latency`` such clocks later.
    """

    latency = 0

    def __init__(self, build: Build, rows: int) -> None:
        self._build, self._rows = build, rows
        self.read_latency = read_latency(build)
        beat = Beat(pixels_shape(build))
        super().__init__(
            {
                "i": In(stream.Signature(beat)),
                "o": Out(stream.Signature(beat)),
                **store_members(build, rows),
            }
        )

    @property
    def memory_bits(self) -> int:
        build = self._build
        return self._rows * build.beats * build.pixels_per_clock * build.pixel_bits

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        waiting = Signal()
        step = self.o.valid & self.o.ready
        m.d.comb += [
            self.o.valid.eq(self.i.valid & ~waiting),
            self.i.ready.eq(self.o.ready & ~waiting),
            self.o.payload.eq(self.i.payload),
        ]
        row, x = Signal(range(2 * self._rows)), Signal(range(self._build.beats))
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
        m.d.comb += self.column.eq(self._read(m, self._banks(m, row, x, step)))
        probe(self, row=row, x=x, waiting=waiting, occupied=occupied)
        return m

    def _banks(self, m: Module, row: Signal, x: Signal, step: Value) -> list[list[Signal]]:
        """What each bank holds of each lane, one clock behind the memories."""
        lanes, slots = self._build.pixels_per_clock, self._rows // BANKS
        slot_bits, lane_bits = (slots - 1).bit_length(), (lanes - 1).bit_length()
        slot, top = row[2 : 2 + slot_bits], self.place.row
        word, first = self.place.x[lane_bits:], self.place.x[:lane_bits]
        # the last lane is never to the left of the first column's
        words = [*((word + (first > lane))[: len(word)] for lane in range(lanes - 1)), word]
        size = min(PART * lanes, self._build.pixel_bits)
        banks = []
        for number in range(BANKS):
            # below the topmost row, banks of smaller numbers hold the rows after the next multiple
            # of four
            later = top[:2] > number
            bank = []
            for lane, pixel in enumerate(each_lane(self.i.payload.data, lanes)):
                data = []
                for low in range(0, len(pixel), size):
                    part = pixel[low : low + size]
                    name = lane_name(f"bank_{number}_{low}", lane, lanes)
                    m.submodules[name] = memory = Memory(
                        shape=len(part),
                        depth=self._build.beats * slots,
                        init=[],
                        attrs={"ram_style": "block"},
                    )
                    writing, reading = memory.write_port(), memory.read_port()
                    m.d.comb += [
                        writing.addr.eq(Cat(slot, x)),
                        writing.data.eq(part),
                        writing.en.eq(step & (row[:2] == number)),
                        reading.addr.eq(Cat((top[2:] + later)[:slot_bits], words[lane])),
                        reading.en.eq(self.reading),
                    ]
                    data.append(reading.data)
                bank.append(self._later(m, Cat(data), lane_name(f"kept_{number}", lane, lanes)))
            banks.append(bank)
        return banks

    def _read(self, m: Module, banks: list[list[Signal]]) -> Value:
        """The columns in their order, then the rows in theirs."""
        row, rows = self.place.row[:2], [bank[0] for bank in banks]
        for k in range(_BANKS_LATENCY):
            row = self._later(m, row, f"first_{k}")
        if self._build.pixels_per_clock > 1:
            row, rows = self._later(m, row, "first"), self._put_in_order(m, banks)
        return self._later(m, Cat(Array(rows)[(row + k)[:2]] for k in range(BANKS)), "ordered")

    def _put_in_order(self, m: Module, banks: list[list[Signal]]) -> list[Signal]:
        """The columns of each bank from the first one that is read, a clock later."""
        lane_bits = (self._build.pixels_per_clock - 1).bit_length()
        first: Value = self.place.x[:lane_bits]
        for k in range(_BANKS_LATENCY):
            first = self._later(m, first, f"first_lane_{k}")
        columns = range(columns_read(self._build))
        return [
            self._later(m, Cat(Array(bank)[(first + k)[:lane_bits]] for k in columns), f"ordered_{number}")
            for number, bank in enumerate(banks)
        ]

    def _later(self, m: Module, value: Value, name: str) -> Signal:
        register = Signal(value.shape(), name=name, reset_less=True)
        with m.If(self.reading):
            m.d.sync += register.eq(value)
        return register


def read_latency(build: Build) -> int:
    """Clocks from a place to what is read there: one more where lanes have to be put in order."""
    return _BANKS_LATENCY + (1 if build.pixels_per_clock == 1 else 2)


def store_members(build: Build, rows: int) -> dict[str, Member]:
    """Members of the store beside its streams, as it sees them."""
    return {
        "needed": In(range(2 * rows)),
        "reading": In(1),
        "place": In(place_layout(build, rows)),
        "column": Out(column_layout(build)),
    }


def column_layout(build: Build) -> data.ArrayLayout:
    """Four rows of the columns that are read at once: a pixel each, or an array of pixels."""
    return data.ArrayLayout(lanes_of(unsigned(build.pixel_bits), columns_read(build)), BANKS)


def place_layout(build: Build, rows: int) -> data.StructLayout:
    """A row by its place in the store, and a column."""
    return data.StructLayout({"row": range(rows), "x": range(build.max_width)})
