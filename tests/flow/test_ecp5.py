"""The stand-in for timing: what it makes of block RAM, and of the registers behind."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from amaranth.back import rtlil
from amaranth.hdl import Module as Circuit
from amaranth.hdl import Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from flow.ecp5 import RULES, SCRIPT, relaxed
from flow.ecp5.output_registers import BLOCK_RAM, FLIP_FLOP, use_output_registers
from flow.netlist import Cell, Module
from flow.rules import write_rules
from flow.yowasp import run_yosys

WIDTH, DEPTH = 20, 2000


class Row(wiring.Component):
    """A row of pixels and a register behind it; ``fault`` says why that one has to stay outside."""

    def __init__(self, fault: str) -> None:
        self._fault = fault
        super().__init__(
            {
                "enable": In(1),
                "clear": In(1),
                "address": In(range(DEPTH)),
                "i": In(WIDTH),
                "o": Out(WIDTH),
                "at_once": Out(WIDTH),
            }
        )

    def elaborate(self, platform: Any) -> Circuit:
        m = Circuit()
        m.submodules.memory = memory = Memory(shape=WIDTH, depth=DEPTH, init=[])
        write, read = memory.write_port(), memory.read_port()
        m.d.comb += [
            write.addr.eq(self.address),
            read.addr.eq(self.address),
            write.data.eq(self.i),
            write.en.eq(1),
            read.en.eq(self.enable),
        ]
        register = Signal(WIDTH, reset_less=self._fault != "reset")
        with m.If(self.enable):
            m.d.sync += register.eq(read.data ^ 1 if self._fault == "logic" else read.data)
        if self._fault == "enables":
            with m.If(self.clear):
                m.d.sync += register[:10].eq(read.data[:10])
        if self._fault == "reset":
            with m.If(self.clear):
                m.d.sync += register.eq(0)
        if self._fault == "read twice":
            m.d.comb += self.at_once.eq(read.data)
        m.d.comb += self.o.eq(register)
        return m


def mapped(component: wiring.Component, folder: Path) -> Module:
    write_rules("ecp5", RULES, folder)
    (folder / "design.il").write_text(relaxed(rtlil.convert(component, name="row", emit_src=False)))
    run_yosys(SCRIPT.format(top="row"), folder)
    return Module(json.loads((folder / "mapped.json").read_text())["modules"]["row"])


def blocks(module: Module) -> list[Cell]:
    return module.of_kind(BLOCK_RAM)


def outputs(block: Cell) -> list[int]:
    """Nets at the reading port's outputs."""
    bits = [block[f"DOB{k}"] for k in range(18)]
    return [bit for bit in bits if isinstance(bit, int)]


def test_a_register_behind_a_row_moves_into_its_blocks(tmp_path: Path) -> None:
    module = mapped(Row(""), tmp_path)
    # a long row takes blocks of 9 bits, none of them with a multiplexer behind
    assert len(blocks(module)) == 3 and len(module.of_kind(FLIP_FLOP)) == WIDTH
    results = {cell["Q"] for cell in module.of_kind(FLIP_FLOP)}
    enables = {cell["CE"] for cell in module.of_kind(FLIP_FLOP)}
    assert len(enables) == 1
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
    again = Module(module.json)
    assert again.driver.keys() == module.driver.keys()


@pytest.mark.parametrize("fault", ["reset", "logic", "enables", "read twice"])
def test_a_register_stays_where_it_does_something_else(tmp_path: Path, fault: str) -> None:
    module = mapped(Row(fault), tmp_path)
    registers = len(module.of_kind(FLIP_FLOP))
    moved = use_output_registers(module)
    assert len(module.of_kind(FLIP_FLOP)) == registers - moved
    # a block holds 9 bits: one may still have only such as can move
    assert moved < WIDTH
    kept = [block for block in blocks(module) if "REGMODE_B" not in block.json["parameters"]]
    assert kept and all(block["OCEB"] == "1" for block in kept)
    assert len(kept) == {"reset": 3, "logic": 1, "enables": 1, "read twice": 3}[fault]
