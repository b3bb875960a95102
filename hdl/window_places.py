"""Places of the windows that are being read, until something is said about them."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hdl.build import Build
from hdl.candidate_queue import place_layout
from hdl.parts.probes import probe

PLACES = 8
"""Windows between their request and the end of their centre rows, and more."""


class WindowPlaces(wiring.Component):
    """A window's place goes in with its request, and is there when its centre has come.

    They wait in block RAM, because registers would be a logic element for each bit. The memory is
    always read ahead, and ``place`` is its own output register.

    Parameters
    ----------
    build
        Parameters of the detector.
    under_way
        Most windows that are on their way from ``put`` to ``take`` at a time.

    Members
    -------
    put
        A window is requested: ``given`` is its place.
    given
        ``place_layout(build)``
    take
        The oldest window's centre has come: at least two clocks after ``put``, and three after the
        ``take`` before.
    place
        The place of that window, from the clock after ``take`` until the next one.

    Raises
    ------
    ValueError
        ``under_way`` is above :data:`PLACES`.
    """

    def __init__(self, build: Build, under_way: int) -> None:
        if under_way > PLACES:
            raise ValueError(f"under_way is {under_way}; allowed: whole numbers up to {PLACES}")
        place = place_layout(build)
        super().__init__({"put": In(1), "given": In(place), "take": In(1), "place": Out(place)})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        given = Value.cast(self.given)
        m.submodules.memory = memory = Memory(
            shape=len(given), depth=PLACES, init=[], attrs={"ram_style": "block"}
        )
        write, read = memory.write_port(), memory.read_port()
        m.d.comb += [write.en.eq(self.put), write.data.eq(given), read.en.eq(1)]
        for port, step in ((write, self.put), (read, self.take)):
            with m.If(step):
                m.d.sync += port.addr.eq(port.addr + 1)
        found = Signal(len(given), reset_less=True)
        with m.If(self.take):
            m.d.sync += found.eq(read.data)
        m.d.comb += Value.cast(self.place).eq(found)
        probe(self, write=write, read=read)
        return m
