"""The register map by itself, and the bank that is made of it."""

from __future__ import annotations

from typing import Any

import pytest

from golden import Parameters, Settings
from golden.video import Event
from hdl.build import Build
from hdl.edges.register import ADDRESS_BITS, Register
from hdl.edges.register_bank import SIZES, RegisterBank
from hdl.edges.register_map import IDENTITY, register_map
from tests.hdl.edges.bench import simulate

BUILDS = {
    "paper": Build.profile("paper"),
    "robust": Build.profile("robust", max_width=640, max_height=480, video_out=True),
    "smoothed": Build.profile("paper", max_width=13, pixel_filter="twice", texture="none"),
    "odd": Build.profile(
        "paper", pixel_bits=10, max_width=15, max_height=8192, fit="six", patches="pixels", autostart=True
    ),
    "cells": Build.profile("robust", budget=True, max_per_cell=9, min_cell_width=17),
    "lanes": Build.profile("paper", pixels_per_clock=8, max_width=1919),
}
builds = pytest.mark.parametrize("parameters", BUILDS.values(), ids=BUILDS.keys())
SMALL = Build.profile("paper", max_width=40, max_height=30)


def registers(parameters: Parameters = SMALL) -> dict[str, Register]:
    return {register.name: register for register in register_map(parameters)}


@builds
def test_map_is_sound(parameters: Parameters) -> None:
    everything = register_map(parameters)
    addresses = [register.address for register in everything]
    assert addresses == sorted(set(addresses)) and max(addresses) < 1 << ADDRESS_BITS
    assert all(address % 4 == 0 for address in addresses)
    names = [field.name for register in everything for field in register.fields]
    assert len(names) == len(set(names))
    for register in everything:
        taken = 0
        for field in register.fields:
            assert not taken & field.mask and field.high < 32 and 0 <= field.reset < 1 << field.bits
            taken |= field.mask
        assert register.fields == tuple(sorted(register.fields, key=lambda field: field.low))


def test_texts_say_what_was_built() -> None:
    """The golden model's words: the bits that count for ``Settings.mean_weight``, and limits."""
    paper, robust = registers(), registers(Build.profile("robust", texture="mean", budget=True))
    assert paper["SIGMA2"].text.startswith("Texture threshold: ")
    assert robust["SIGMA2"].text.startswith("Weight of the local level of D")
    assert "bits 16:13; what is 2 or more counts as 15/8" in robust["SIGMA2"].fields[0].text
    for sigma2, weight in (
        (1 << 13, 1),
        (1 << 16, 8),
        ((1 << 17) - 1, 15),
        (1 << 17, 15),
        ((1 << 13) - 1, 0),
    ):
        assert Settings(sigma2=sigma2 / 65536).mean_weight == weight
    smoothed = registers(BUILDS["smoothed"])
    assert smoothed["SIGMA2"].text.endswith("changes nothing without a texture filter.")
    assert smoothed["SIZE"].text.startswith("Frame size, 13x13 to 13x1080.")
    assert registers(BUILDS["lanes"])["SIZE"].text.startswith("Frame size, 25x15 to 1919x1080.")
    assert "less SIGMA2 times the local level" in robust["SIGMA1"].text
    assert "local level" not in paper["SIGMA1"].text
    for built, limits in (
        (paper, "MAX_RECORDS"),
        (robust, "MAX_RECORDS or BUDGET.max_corners"),
        (registers(BUILDS["cells"]), "MAX_RECORDS, BUDGET.max_corners or CELLS.per_cell"),
    ):
        (dropped,) = (field for field in built["STATUS"].fields if field.name == "records_dropped")
        assert f"more corners than {limits} allows:" in dropped.text
        assert built["DROPPED"].fields[0].text == f"They are beyond {limits}."


def test_every_event_has_its_bit_in_status() -> None:
    fields = registers()["STATUS"].fields
    assert [(f.name.upper(), f.mask) for f in fields] == [(event.name, event.value) for event in Event]


def test_capability() -> None:
    known = {name: registers(parameters)["CAPABILITY"].reset for name, parameters in BUILDS.items()}
    assert known["paper"] == 1 | 8 << 4 | 1 << 15 | 1 << 16
    assert known["robust"] == 1 | 8 << 4 | 0b1110011 << 8 | 2 << 16 | 1 << 19 | 1 << 21
    assert known["smoothed"] == 1 | 8 << 4 | 1 << 15 | 1 << 19 | 1 << 26
    assert known["lanes"] == 8 | 8 << 4 | 1 << 15 | 1 << 16
    assert known["odd"] == 1 | 10 << 4 | 0b10001100 << 8
    assert registers(BUILDS["odd"])["CONTROL"].reset == 1 and registers()["CONTROL"].reset == 0
    assert registers()["ID"].reset == IDENTITY == 0x434F524E
    assert registers(BUILDS["robust"])["SIZE_MAX"].reset == 640 | 480 << 16


class Bus:
    """What a bus adapter does, in a test bench."""

    def __init__(self, context: Any, dut: RegisterBank) -> None:
        self._context, self._dut = context, dut
        self._map = dut.registers

    def read(self, name: str) -> int:
        """In no time: reading has no side effect."""
        self._context.set(self._dut.bus.read_address, self._map[name].address >> 2)
        assert not self._context.get(self._dut.bus.read_error)
        return int(self._context.get(self._dut.bus.read_data))

    async def write(self, name: str, value: int, mask: int = 0xF) -> None:
        bus = self._dut.bus
        self._context.set(bus.write_address, self._map[name].address >> 2)
        self._context.set(bus.write_data, value)
        self._context.set(bus.write_mask, mask)
        self._context.set(bus.write, 1)
        assert self._context.get(bus.write_error) == (self._map[name].access == "ro")
        await self._context.tick()
        self._context.set(bus.write, 0)


def with_bank(parameters: Parameters, bench: Any) -> None:
    dut = RegisterBank(parameters)

    async def run(context: Any) -> None:
        await bench(context, dut, Bus(context, dut))

    simulate(dut, run)


@builds
def test_reset_values(parameters: Parameters) -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        for register in register_map(parameters):
            assert bus.read(register.name) == register.reset, register.name
        for word in set(range(1 << (ADDRESS_BITS - 2))) - {r.address >> 2 for r in register_map(parameters)}:
            context.set(dut.bus.read_address, word)
            context.set(dut.bus.write_address, word)
            assert context.get(dut.bus.read_error) and context.get(dut.bus.write_error)
            assert context.get(dut.bus.read_data) == 0

    with_bank(parameters, bench)


@builds
def test_every_writable_bit_can_be_written_byte_by_byte(parameters: Parameters) -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        for register in register_map(parameters):
            if register.access != "rw" or register.name in SIZES:
                continue
            writable = register.mask & ~(2 if register.name == "CONTROL" else 0)
            before = register.reset & writable
            for byte in range(4):
                part = 0xFF << 8 * byte
                value = before ^ (part & writable)
                await bus.write(register.name, value ^ (~part & writable), 1 << byte)
                assert bus.read(register.name) & writable == value, (register.name, byte)
                before = value
            await bus.write(register.name, register.reset)
        await bus.write("ID", 0)
        assert bus.read("ID") == IDENTITY

    with_bank(parameters, bench)


def test_size_out_of_range_is_refused_and_said() -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        for width, height, mask in (
            *((14, 20, 15), (41, 20, 15), (20, 14, 15), (20, 31, 15), (0, 0, 15), (0xFFFF, 0xFFFF, 15)),
            *((20 + 0x8000, 20, 15), (20, 20, 0b0011), (20, 20, 0b0111)),
        ):
            await bus.write("SIZE", width | height << 16, mask)
            assert bus.read("SIZE") == 40 | 30 << 16
            assert bus.read("STATUS") == Event.SIZE_REFUSED
            await bus.write("STATUS", Event.SIZE_REFUSED)
            assert bus.read("STATUS") == 0
        for width, height in ((15, 15), (40, 30), (16, 29)):
            await bus.write("SIZE", width | height << 16)
            assert bus.read("SIZE") == width | height << 16 and bus.read("STATUS") == 0
        context.set(dut.active, 1)
        await bus.write("SIZE", 15 | 15 << 16)
        assert bus.read("SIZE") == 15 | 15 << 16 and bus.read("STATUS") == Event.SIZE_CHANGED

    with_bank(SMALL, bench)


def test_the_narrowest_frame_is_a_beat_wider_with_several_pixels_per_clock() -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        for width, height, good in ((24, 15, False), (25, 14, False), (25, 15, True), (1919, 15, True)):
            before = bus.read("SIZE")
            await bus.write("SIZE", width | height << 16)
            assert bus.read("SIZE") == (width | height << 16 if good else before)
            assert bus.read("STATUS") == (0 if good else Event.SIZE_REFUSED)
            await bus.write("STATUS", Event.SIZE_REFUSED)

    with_bank(BUILDS["lanes"], bench)


def test_cells_out_of_range_are_refused_and_said() -> None:
    """A number of 0 is always taken, whatever the sizes beside it."""

    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        good = 17 | 128 << 8 | 9 << 16
        await bus.write("CELLS", good)
        assert bus.read("CELLS") == good and bus.read("STATUS") == 0
        assert context.get(dut.control.settings.per_cell) == 9
        for word, mask in (
            *((16 | 64 << 8 | 1 << 16, 15), (129 | 64 << 8 | 1 << 16, 15), (64 | 7 << 8 | 1 << 16, 15)),
            *((64 | 129 << 8 | 1 << 16, 15), (64 | 64 << 8 | 10 << 16, 15), (64 | 64 << 8 | 1 << 16, 7)),
        ):
            await bus.write("CELLS", word, mask)
            assert bus.read("CELLS") == good and bus.read("STATUS") == Event.SIZE_REFUSED
            await bus.write("STATUS", Event.SIZE_REFUSED)
        await bus.write("CELLS", 0)
        assert bus.read("CELLS") == 0 and bus.read("STATUS") == 0
        context.set(dut.active, 1)
        await bus.write("CELLS", good)
        assert bus.read("CELLS") == good and bus.read("STATUS") == 0

    with_bank(BUILDS["cells"], bench)


def test_a_write_of_no_byte_changes_nothing() -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        context.set(dut.events, {"sof_early": 1})
        await context.tick()
        context.set(dut.events, {})
        context.set(dut.active, 1)
        before = {name: bus.read(name) for name in dut.registers}
        for name in dut.registers:
            for value in (0, 0xFFFFFFFF, 20 | 20 << 16):
                await bus.write(name, value, 0)
                await context.tick().repeat(2)
                assert {name: bus.read(name) for name in dut.registers} == before
        assert before["STATUS"] == Event.SOF_EARLY and not context.get(dut.control.reset)

    with_bank(SMALL, bench)


def test_status_is_sticky_and_never_loses_an_event() -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        context.set(dut.events, {"sof_early": 1, "frame_done": 1})
        await context.tick()
        context.set(dut.events, {})
        await context.tick().repeat(3)
        assert bus.read("STATUS") == Event.SOF_EARLY | Event.FRAME_DONE
        await bus.write("STATUS", Event.FRAME_DONE)
        assert bus.read("STATUS") == Event.SOF_EARLY
        # in the very clock of its clearing
        context.set(dut.events, {"sof_early": 1})
        await bus.write("STATUS", Event.SOF_EARLY)
        context.set(dut.events, {})
        assert bus.read("STATUS") == Event.SOF_EARLY
        # only bytes that are written clear
        await bus.write("STATUS", 0xFFFFFFFF, 0b1110)
        assert bus.read("STATUS") == Event.SOF_EARLY

    with_bank(SMALL, bench)


def test_interrupt() -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        context.set(dut.events, {"frame_done": 1, "eol_late": 1})
        await context.tick().repeat(2)
        context.set(dut.events, {})
        assert not context.get(dut.irq)
        await bus.write("IRQ_ENABLE", Event.FRAME_DONE | Event.RECORDS_DROPPED)
        await context.tick()
        assert context.get(dut.irq)
        await bus.write("STATUS", Event.FRAME_DONE)
        await context.tick()
        assert not context.get(dut.irq) and bus.read("STATUS") == Event.EOL_LATE
        context.set(dut.events, {"records_dropped": 1})
        await context.tick().repeat(2)
        assert context.get(dut.irq)

    with_bank(SMALL, bench)


def test_reset_is_asked_for_until_it_is_done() -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        await bus.write("CONTROL", 0b10011)
        assert context.get(dut.control.reset) and bus.read("CONTROL") == 0b10011
        await bus.write("CONTROL", 0b00001)
        assert bus.read("CONTROL") == 0b00011
        context.set(dut.reset_done, 1)
        await context.tick()
        assert bus.read("CONTROL") == 0b00001

    with_bank(SMALL, bench)


def test_results_are_read_back() -> None:
    async def bench(context: Any, dut: RegisterBank, bus: Bus) -> None:
        context.set(dut.results, {"frames": 3, "corners": 70_000, "dropped": 9, "maximum": 130_050})
        context.set(dut.clocks, 4_000_000_000)
        got = [bus.read(name) for name in ("FRAMES", "CORNERS", "DROPPED", "CLOCKS", "MAXIMUM")]
        assert got == [3, 70_000, 9, 4_000_000_000, 130_050]

    with_bank(SMALL, bench)
