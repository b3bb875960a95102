"""The stand-in for timing: what it makes of block RAM, and of the registers behind."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from amaranth.hdl import Module as Circuit
from amaranth.hdl import Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from flow.devices import DEVICES
from flow.ecp5 import synthesis
from flow.ecp5.output_registers import BLOCK_RAMS, FLIP_FLOP, use_output_registers
from flow.ecp5.timing import TooLargeError, large_enough
from flow.netlist import Cell, Module
from flow.verilog import MODULE

WIDTH, DEPTH = 20, 2000


class Row(wiring.Component):
    """A row of pixels and a register behind it; ``kind`` is the special case."""

    def __init__(self, kind: str, depth: int = DEPTH) -> None:
        self._kind = kind
        self._depth = depth
        super().__init__(
            {
                "enable": In(1),
                "clear": In(1),
                "address": In(range(depth)),
                "i": In(WIDTH),
                "o": Out(WIDTH),
                "at_once": Out(WIDTH),
            }
        )

    def elaborate(self, platform: Any) -> Circuit:
        m = Circuit()
        m.submodules.memory = memory = Memory(shape=WIDTH, depth=self._depth, init=[])
        write, read = memory.write_port(), memory.read_port()
        m.d.comb += [
            write.addr.eq(self.address),
            read.addr.eq(self.address),
            write.data.eq(self.i),
            write.en.eq(1),
            read.en.eq(self.enable),
        ]
        register = Signal(WIDTH, reset_less=self._kind != "reset")
        enable = {"no enable": 1, "inverted enable": ~self.clear}.get(self._kind, self.enable)
        with m.If(enable):
            m.d["other" if self._kind == "other clock" else "sync"] += register.eq(
                read.data ^ 1 if self._kind == "logic" else read.data
            )
        if self._kind == "enables":
            with m.If(self.clear):
                m.d.sync += register[:10].eq(read.data[:10])
        elif self._kind == "reset":
            with m.If(self.clear):
                m.d.sync += register.eq(0)
        elif self._kind == "read twice":
            m.d.comb += self.at_once.eq(read.data)
        elif self._kind == "read by logic, too":
            m.d.comb += self.at_once.eq(read.data & self.i)
        elif self._kind == "an enable itself":
            with m.If(read.data[0]):
                m.d.sync += self.at_once[0].eq(self.clear)
        # a bit that nobody else reads is read as an enable only
        used = register & ~1 if self._kind == "an enable itself" else register
        m.d.comb += self.o.eq(used)
        return m


def mapped(component: wiring.Component, folder: Path, *, stands_in: bool = True) -> Module[Cell]:
    """The netlist, before flip-flops move into block RAM."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(synthesis, "use_output_registers", lambda module: 0)
        netlist = synthesis.map_component(component, "row", folder, stands_in=stands_in)
    return Module(netlist["modules"]["row"], Cell)


def blocks(module: Module[Cell]) -> list[Cell]:
    return [cell for cell in module.cells.values() if cell.kind in BLOCK_RAMS]


def outputs(block: Cell) -> list[int]:
    """Nets at the reading port's outputs."""
    bits = [block[f"DOB{k}"] for k in range(18)]
    return [bit for bit in bits if isinstance(bit, int)]


@pytest.mark.parametrize("kind", ["", "no enable"])
def test_a_register_behind_a_row_moves_into_its_blocks(tmp_path: Path, kind: str) -> None:
    module = mapped(Row(kind), tmp_path)
    # a long row takes blocks of 9 bits, none of them with a multiplexer behind
    assert len(blocks(module)) == 3 and len(module.of_kind(FLIP_FLOP)) == WIDTH
    results = {cell["Q"] for cell in module.of_kind(FLIP_FLOP)}
    enables = {"1"} if kind else {cell["CE"] for cell in module.of_kind(FLIP_FLOP)}
    assert len(enables) == 1 and (kind or isinstance(*enables, int))
    assert use_output_registers(module) == WIDTH
    assert not module.of_kind(FLIP_FLOP)
    driven = [net for block in blocks(module) for net in outputs(block) if module.readers.get(net)]
    # what the registers drove comes out of the blocks, enabled as the registers were
    assert sorted(driven) == sorted(net for net in results if isinstance(net, int))
    for block in blocks(module):
        assert block.json["parameters"]["REGMODE_B"] == "OUTREG"
        assert "REGMODE_A" not in block.json["parameters"]
        assert {block["OCEB"]} == enables
    # the connections that the module knows are those of its JSON
    again = Module(module.json, Cell)
    assert again.driver.keys() == module.driver.keys()


@pytest.mark.parametrize(
    ("depth", "kind", "number"),
    [(512, "PDPW16KD", 1), (513, "DP16KD", 2), (1024, "DP16KD", 2), (1025, "DP16KD", 3)],
)
def test_short_rows_take_wide_blocks_with_their_registers(
    tmp_path: Path, depth: int, kind: str, number: int
) -> None:
    """36, 18 or 9 bits wide: none needs a multiplexer."""
    module = mapped(Row("", depth), tmp_path)
    assert [block.kind for block in blocks(module)] == [kind] * number
    assert len(module.of_kind("LUT4")) == 0
    assert use_output_registers(module) == WIDTH and not module.of_kind(FLIP_FLOP)
    (port, *_) = reversed(BLOCK_RAMS[kind])
    assert {block.json["parameters"][port.mode] for block in blocks(module)} == {"OUTREG"}


def test_what_has_too_many_blocks_is_placed_on_a_larger_device() -> None:
    device = DEVICES["lfe5u-45f"]

    def placed(number: int) -> str:
        cells = {str(k): {"type": "PDPW16KD" if k % 2 else "DP16KD"} for k in range(number)}
        netlist = {"modules": {MODULE: {"cells": {**cells, "logic": {"type": "LUT4"}}}}}
        return large_enough(netlist, device).name

    blocks = [1, device.memory_blocks, device.memory_blocks + 1, 208]
    assert list(map(placed, blocks)) == ["lfe5u-45f", "lfe5u-45f", "lfe5u-85f", "lfe5u-85f"]
    with pytest.raises(TooLargeError, match=r"^the core has 209 EBR; allowed on ECP5: 208$"):
        placed(209)


def test_an_inverted_enable_gets_one_lookup_table(tmp_path: Path) -> None:
    module = mapped(Row("inverted enable"), tmp_path)
    registers = module.of_kind(FLIP_FLOP)
    assert {register.parameter("CEMUX") for register in registers} == {"INV"}
    (enable,) = {register["CE"] for register in registers}
    others = {cell.name for cell in module.of_kind("LUT4")}
    assert use_output_registers(module) == WIDTH
    (inverter,) = (cell for cell in module.of_kind("LUT4") if cell.name not in others)
    # all ones where A is 0
    assert inverter["A"] == enable and int(inverter.parameter("INIT"), 2) == 0x5555
    assert {block["OCEB"] for block in blocks(module)} == {inverter["Z"]}
    assert len(blocks(module)) == 3 and len(module.readers[inverter["Z"]]) == 3


@pytest.mark.parametrize(
    ("kind", "kept_blocks"),
    [
        ("reset", 3),
        ("logic", 1),
        ("enables", 1),
        ("other clock", 3),
        ("read twice", 3),
        ("read by logic, too", 3),
        ("an enable itself", 1),
    ],
)
def test_a_register_stays_where_it_does_something_else(tmp_path: Path, kind: str, kept_blocks: int) -> None:
    module = mapped(Row(kind), tmp_path)
    registers = len(module.of_kind(FLIP_FLOP))
    moved = use_output_registers(module)
    assert len(module.of_kind(FLIP_FLOP)) == registers - moved
    # a block holds 9 bits: one may still have only such as can move
    assert moved < WIDTH
    kept = [block for block in blocks(module) if "REGMODE_B" not in block.json["parameters"]]
    assert len(kept) == kept_blocks and all(block["OCEB"] == "1" for block in kept)


def test_the_device_itself_pays_for_the_old_value_of_a_word_being_written(tmp_path: Path) -> None:
    tables = {
        stands_in: len(mapped(Row(""), tmp_path, stands_in=stands_in).of_kind("LUT4"))
        for stands_in in (True, False)
    }
    # the word that is written, held beside the block, and a choice for each bit
    assert tables[True] < WIDTH <= tables[False]
