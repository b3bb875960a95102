"""Output registers of ECP5's block RAM: flip-flops behind a block RAM move into it.

Yosys leaves these registers unused. Quartus does the same with the M9K. In the slowest grade a
block takes 5.8 ns to its output, and 1 ns from this register.
"""

from __future__ import annotations

from dataclasses import dataclass

from flow.netlist import Bit, Cell, Module

FLIP_FLOP = "TRELLIS_FF"


@dataclass(frozen=True)
class Port:
    """A port of a block that reads: the names of its pins, and of the parameter for its register.

    ``data`` begins the names of the ``width`` outputs.
    """

    data: str
    width: int
    clock: str
    enable: str
    mode: str


BLOCK_RAMS = {
    "DP16KD": tuple(Port(f"DO{port}", 18, f"CLK{port}", f"OCE{port}", f"REGMODE_{port}") for port in "AB"),
    "PDPW16KD": (Port("DO", 36, "CLKR", "OCER", "REGMODE"),),
}
"""Kinds of block RAM, and their ports that read; the second kind is wider and has one of each."""


def use_output_registers(module: Module[Cell]) -> int:
    """Move flip-flops that take what a port reads into the block RAM; returns their number.

    Either all flip-flops of a port move, or none.
    Each output in use must go to one flip-flop and nowhere else; these must have the port's clock,
    one clock enable for all, and no reset, for which the port has no place. An enable that the
    flip-flops invert gets one lookup table for all ports, because a port does not invert.
    """
    inverted: dict[Bit, Bit] = {}
    return sum(
        _move(module, ram, port, inverted)
        for kind, ports in BLOCK_RAMS.items()
        for ram in module.of_kind(kind)
        for port in ports
    )


def _move(module: Module[Cell], ram: Cell, port: Port, inverted: dict[Bit, Bit]) -> int:
    outputs = [name for name in (f"{port.data}{k}" for k in range(port.width)) if module.is_read(ram[name])]
    registers = [_register_behind(module, ram, port, name) for name in outputs]
    found = [register for register in registers if register is not None]
    enables = {_enable(register) for register in found}
    if len(found) != len(outputs) or len(enables) != 1:
        return 0
    enable, inverts = enables.pop()
    if inverts:
        enable = _inverted(module, enable, inverted)
    for register in found:
        module.remove(register)
    with module.changing(ram):
        for name, register in zip(outputs, found, strict=True):
            ram[name] = register["Q"]
        ram[port.enable] = enable
    ram.json["parameters"][port.mode] = "OUTREG"
    return len(found)


def _register_behind(module: Module[Cell], ram: Cell, port: Port, output: str) -> Cell | None:
    """The flip-flop that alone reads an output, if it can move."""
    reader = module.only_reader(ram[output])
    if reader is None or reader[0].kind != FLIP_FLOP or reader[1] != "DI":
        return None
    register = reader[0]
    # no reset is a reset that never comes
    plain = register.parameter("CLKMUX") == "CLK" and register.parameter("CEMUX") in ("CE", "INV", "1")
    fits = register["CLK"] == ram[port.clock] and register["LSR"] in ("0", "x")
    return register if plain and fits else None


def _enable(register: Cell) -> tuple[Bit, bool]:
    """The clock enable, and whether the flip-flop inverts it."""
    mux = register.parameter("CEMUX")
    return ("1", False) if mux == "1" else (register["CE"], mux == "INV")


def _inverted(module: Module[Cell], bit: Bit, made: dict[Bit, Bit]) -> Bit:
    """The inverse of a net; ``made`` has those that there are."""
    if bit not in made:
        made[bit] = net = module.new_net()
        module.add(
            f"output_enable_{net}",
            {
                "hide_name": 1,
                "type": "LUT4",
                "parameters": {"INIT": f"{0x5555:016b}"},
                "attributes": {},
                "port_directions": {**dict.fromkeys("ABCD", "input"), "Z": "output"},
                "connections": {"A": [bit], "B": ["0"], "C": ["0"], "D": ["0"], "Z": [net]},
            },
        )
    return made[bit]
