"""Flip-flops that become the registers that block RAM and multipliers have at their ports."""

from __future__ import annotations

from flow.cyclone4.netlist import FLIP_FLOP, MEMORY, MULTIPLIER, PRODUCT, Cell, Module
from flow.netlist import Bit

CLOCK_0 = "0 "
"""A text in Yosys's JSON: without the blank it would be a bit."""


def absorb_registers(module: Module) -> None:
    """Move flip-flops into the outputs of block RAM and multipliers, and multipliers' inputs.

    All of a port move, or none: they must have one clock enable, and no clear or load.
    """
    for memory in module.of_kind(MEMORY):
        for port in "ab":
            _into_memory(module, memory, port)
    for multiplier in module.of_kind(MULTIPLIER):
        _before_multiplier(module, multiplier)
    for product in module.of_kind(PRODUCT):
        _behind_product(module, product)


def _into_memory(module: Module, memory: Cell, port: str) -> None:
    outputs = memory.bits(f"q_{port}")
    registers = _behind(module, outputs)
    enable = _common_enable(registers)
    if enable is None or {each["clk"] for each in registers.values()} != {memory["clock0"]}:
        return
    # one enable serves the output registers of both ports
    if enable != "1" and memory["clocken0"] not in ("1", enable):
        return
    for register in registers.values():
        module.remove(register)
    with module.changing(memory):
        memory.json["parameters"][f"outdata_reg_{port}"] = "CLOCK0"
        if enable != "1":
            memory["clocken0"] = enable
            memory.json["parameters"][f"clock_enable_output_{port}"] = "NORMAL"
        memory.json["connections"][f"q_{port}"] = _through(registers, outputs, "q")


def _behind_product(module: Module, product: Cell) -> None:
    outputs = product.bits("dataout")
    registers = _behind(module, outputs)
    enable = _common_enable(registers)
    if enable is None:
        return
    clock = next(iter(registers.values()))["clk"]
    for register in registers.values():
        module.remove(register)
    with module.changing(product):
        product.json["parameters"]["output_clock"] = CLOCK_0
        product["clk"], product["ena"] = clock, enable
        product.json["connections"]["dataout"] = _through(registers, outputs, "q")


def _before_multiplier(module: Module, multiplier: Cell) -> None:
    ports = ("dataa", "datab")
    nets = {bit for port in ports for bit in multiplier.bits(port) if isinstance(bit, int)}
    registers: dict[Bit, Cell] = {}
    for net in nets:
        driver = module.driver.get(net)
        readers = {cell.name if cell else None for cell, _ in module.readers[net]}
        if driver is None or driver[0].kind != FLIP_FLOP or readers != {multiplier.name}:
            return
        registers[net] = driver[0]
    enable = _common_enable(registers)
    if enable is None:
        return
    clock = next(iter(registers.values()))["clk"]
    with module.changing(multiplier):
        for port in ports:
            multiplier.json["parameters"][f"{port}_clock"] = CLOCK_0
            multiplier.json["connections"][port] = _through(registers, multiplier.bits(port), "d")
        multiplier["clk"], multiplier["ena"] = clock, enable
    for register in registers.values():
        module.remove(register)


def _behind(module: Module, outputs: list[Bit]) -> dict[Bit, Cell]:
    """The flip-flop behind each output that is read; nothing where one goes elsewhere."""
    registers = {}
    for bit in outputs:
        if not module.is_read(bit):
            continue
        reader = module.only_reader(bit)
        if reader is None or reader[0].kind != FLIP_FLOP or reader[1] != "d":
            return {}
        registers[bit] = reader[0]
    return registers


def _common_enable(registers: dict[Bit, Cell]) -> Bit | None:
    """The clock enable of flip-flops that can move together; None if they cannot."""
    enables = {register["ena"] for register in registers.values()}
    clocks = {register["clk"] for register in registers.values()}
    plain = all(
        register["sclr"] == "0" and register["sload"] == "0" and register.parameter("power_up") == "low"
        for register in registers.values()
    )
    return enables.pop() if plain and len(enables) == len(clocks) == 1 else None


def _through(registers: dict[Bit, Cell], bits: list[Bit], port: str) -> list[Bit]:
    """Those bits, past the registers: with what their ``port`` is connected to."""
    return [registers[bit][port] if bit in registers else bit for bit in bits]
