"""Register bank: the hardware of the register map, behind a simple bus."""

from __future__ import annotations

from typing import Any

from amaranth.hdl import C, Cat, Module, Signal, Value
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.formats import MAX_CELL, MIN_CELL
from golden.video import Event
from hdl.build import Build
from hdl.edges.frame_guard import events_layout
from hdl.edges.register import ADDRESS_BITS, DATA_BITS, Field, Register
from hdl.edges.register_map import RESET_BIT, TIMEOUT_BITS, register_map
from hdl.edges.video_detector import control_layout, initial_control, report_members

OWN_EVENTS = (Event.SIZE_CHANGED, Event.SIZE_REFUSED)
SIZES = ("SIZE", "CELLS")
"""Registers that refuse sizes out of range."""
OTHER_EVENTS = tuple(event for event in Event if event not in OWN_EVENTS)


def register_bus() -> wiring.Signature:
    """The bus, seen from its user, to which any other bus can be adapted.

    Writes and reads take one clock each, and can be in the same clock. ``write`` and ``read`` are
    high in the clock of an access; addresses count words. A byte of ``write_data`` is written if
    its bit in ``write_mask`` is set. Read data and errors (no such register, or a read-only one)
    come in the same clock, whether or not ``read`` or ``write`` is high.
    """
    address = ADDRESS_BITS - 2
    return wiring.Signature(
        {
            "write": Out(1),
            "write_address": Out(address),
            "write_data": Out(DATA_BITS),
            "write_mask": Out(DATA_BITS // 8),
            "write_error": In(1),
            "read": Out(1),
            "read_address": Out(address),
            "read_data": In(DATA_BITS),
            "read_error": In(1),
        }
    )


class RegisterBank(wiring.Component):
    """Registers that software writes, results that it reads, events that stay until it clears them.

    If an event comes in the clock in which its bit is cleared, the bit stays set. The interrupt is
    a register.

    Members
    -------
    bus
        ``register_bus()``, seen from the bank.
    control
        ``control_layout(build)``.
    timeout
        Limit of the watchdogs, in clocks.
    active, results, history, clocks, times, reset_done
        The same as in ``VideoDetector``.
    events
        ``events_layout(*OTHER_EVENTS)``.
    irq
        A bit is set both in STATUS and in IRQ_ENABLE.
    """

    def __init__(self, build: Build) -> None:
        self._build = build
        self.registers = {register.name: register for register in register_map(build)}
        status = len(Event)
        self._status_bits, self._enabled = Signal(status, name="status"), Signal(status, name="irq_enable")
        self._changed, self._refused = Signal(name="size_changed"), Signal(name="size_refused")
        super().__init__(
            {
                "bus": In(register_bus()),
                "control": Out(control_layout(build), init=initial_control(build)),
                "timeout": Out(TIMEOUT_BITS, init=self.registers["TIMEOUT"].reset),
                **{name: member.flip() for name, member in report_members(build).items()},
                "events": In(events_layout(*OTHER_EVENTS)),
                "irq": Out(1),
            }
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        bus = self.bus
        written = {name: Signal(name=f"write_{name.lower()}") for name in self.registers}
        m.d.comb += [bus.write_error.eq(1), bus.read_error.eq(1)]
        # a write of no byte has no effect
        writes = bus.write & bus.write_mask.any()
        with m.Switch(bus.write_address):
            for name, register in self.registers.items():
                if register.access != "ro":
                    with m.Case(register.address >> 2):
                        m.d.comb += [written[name].eq(writes), bus.write_error.eq(0)]
        with m.Switch(bus.read_address):
            for register in self.registers.values():
                with m.Case(register.address >> 2):
                    m.d.comb += [bus.read_data.eq(self._contents(register)), bus.read_error.eq(0)]

        self._settings(m, written)
        self._sizes(m, written)
        self._status(m, written)
        return m

    def _field(self, name: str) -> Value | None:
        """Where a field is stored; None if it never changes."""
        reports = {name: getattr(self, name) for name in report_members(self._build)}
        for place in (self.control, self.control.settings, *reports.values()):
            if isinstance(place, data.View) and name in dict(place.shape()):
                return Value.cast(place[name])
        return {"timeout": self.timeout, "clocks": self.clocks}.get(name)

    def _contents(self, register: Register) -> Value:
        if register.name == "STATUS":
            return self._status_bits
        if register.name == "IRQ_ENABLE":
            return self._enabled
        contents: Value = C(0, 0)
        for field in register.fields:
            stored = self._field(field.source or field.name)
            bits = C(field.reset, field.bits) if stored is None else stored
            contents = Cat(contents, C(0, field.low - len(contents)), bits)
        return contents

    def _write(self, m: Module, written: Signal, field: Field, stored: Value) -> None:
        """Writes the bytes that the mask selects; the others stay."""
        for byte in range(field.low // 8, field.high // 8 + 1):
            low, high = max(8 * byte, field.low), min(8 * byte + 7, field.high)
            with m.If(written & self.bus.write_mask[byte]):
                m.d.sync += stored[low - field.low : high + 1 - field.low].eq(
                    self.bus.write_data[low : high + 1]
                )

    def _settings(self, m: Module, written: dict[str, Signal]) -> None:
        for name, register in self.registers.items():
            if register.access != "rw" or name in (*SIZES, "IRQ_ENABLE"):
                continue
            for field in register.fields:
                stored = self._field(field.source or field.name)
                assert stored is not None
                if field.name != "reset":
                    self._write(m, written[name], field, stored)
        # writing 1 asks for a reset, and writing 0 does not take that back
        reset = self.control.reset
        with m.If(written["CONTROL"] & self.bus.write_mask[0] & self.bus.write_data[RESET_BIT]):
            m.d.sync += reset.eq(1)
        with m.Elif(self.reset_done):
            m.d.sync += reset.eq(0)

    def _sizes(self, m: Module, written: dict[str, Signal]) -> None:
        """Sizes are checked before they are stored, all fields of a register together."""
        build = self._build
        size = self._given("SIZE")
        good = _within(size["width"], build.min_width, build.max_width) & _within(
            size["height"], build.algorithm.support, build.max_height
        )
        stored, refused = self._store(m, "SIZE", written, good)
        if build.max_per_cell:
            cells = self._given("CELLS")
            good = (
                _within(cells["cell_width"], build.min_cell_width, MAX_CELL)
                & _within(cells["cell_height"], MIN_CELL, MAX_CELL)
                & (cells["per_cell"] <= build.max_per_cell)
            )
            _, cells_refused = self._store(m, "CELLS", written, good | (cells["per_cell"] == 0))
            refused |= cells_refused
        m.d.comb += [self._changed.eq(stored & self.active), self._refused.eq(refused)]

    def _given(self, name: str) -> dict[str, Value]:
        """What is written to the fields of a register."""
        fields = self.registers[name].fields
        return {field.name: self.bus.write_data[field.low : field.high + 1] for field in fields}

    def _store(self, m: Module, name: str, written: dict[str, Signal], good: Value) -> tuple[Value, Value]:
        """Stores what is written if it is good and complete; returns whether it was, or was not."""
        stored = written[name] & good & self.bus.write_mask.all()
        with m.If(stored):
            for field, value in self._given(name).items():
                place = self._field(field)
                assert place is not None
                m.d.sync += place.eq(value)
        return stored, written[name] & ~stored

    def _status(self, m: Module, written: dict[str, Signal]) -> None:
        own = {"size_changed": self._changed, "size_refused": self._refused}
        for event in Event:
            name, bit = str(event.name).lower(), event.bit_length() - 1
            happens = own[name] if name in own else self.events[name]
            cleared = written["STATUS"] & self.bus.write_data[bit] & self.bus.write_mask[bit // 8]
            m.d.sync += self._status_bits[bit].eq(happens | (self._status_bits[bit] & ~cleared))
        for field in self.registers["IRQ_ENABLE"].fields:
            self._write(m, written["IRQ_ENABLE"], field, self._enabled[field.low : field.high + 1])
        m.d.sync += self.irq.eq((self._status_bits & self._enabled).any())


def _within(value: Value, low: int, high: int) -> Value:
    return (value >= low) & (value <= high)
