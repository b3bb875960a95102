"""Made-up netlists of Cyclone IV's cells: build, evaluate, pack and compare them."""

from __future__ import annotations

import random
from collections.abc import Callable
from copy import deepcopy
from typing import Any

from flow.cyclone4.netlist import FLIP_FLOP, LUT
from flow.cyclone4.packing import pack

SUM, CARRY = 0x96, 0xE8
DIFFERENCE, NO_BORROW = 0x69, 0xB2
"""Tables of a full adder's sum and carry out, inputs a, b and carry in, and the same for a - b."""


class Netlist:
    """A module as Yosys writes it, made cell by cell; every method returns the driven net."""

    def __init__(self) -> None:
        self.nets = 1
        self.module: dict[str, Any] = {"ports": {}, "cells": {}, "netnames": {}}

    def net(self) -> int:
        self.nets += 1
        return self.nets

    def port(self, name: str, direction: str, bits: list[Any]) -> None:
        self.module["ports"][name] = {"direction": direction, "bits": bits}

    def inputs(self, count: int) -> list[int]:
        bits = [self.net() for _ in range(count)]
        self.port(f"i{len(self.module['ports'])}", "input", bits)
        return bits

    def cell(self, kind: str, outputs: dict[str, Any], parameters: dict[str, str], **pins: Any) -> None:
        self.module["cells"][f"cell_{len(self.module['cells'])}"] = {
            "type": kind,
            "parameters": parameters,
            "port_directions": dict.fromkeys(pins, "input") | dict.fromkeys(outputs, "output"),
            "connections": {port: [net] for port, net in (pins | outputs).items()},
        }

    def table(self, mask: int, *data: Any) -> int:
        """In normal mode, up to four inputs; the mask is for these only."""
        output, given = self.net(), len(data)
        mask = sum((mask >> (index & (1 << given) - 1) & 1) << index for index in range(16))
        pins = dict(zip(("dataa", "datab", "datac", "datad"), [*data, *"1111"][:4], strict=True))
        self.cell(LUT, {"combout": output}, {"lut_mask": f"{mask:016b}", "sum_lutc_input": "datac"}, **pins)
        return output

    def chained(self, total: int, carry: int, a: Any, b: Any, cin: Any) -> tuple[int, int]:
        """In arithmetic mode, tables of a, b and carry in; returns the nets of sum and carry."""
        output, onward = self.net(), self.net()
        mode = "cin"
        if isinstance(cin, str):
            # the first of a chain has a known carry in, in its tables
            half = 4 * int(cin)
            total, carry = ((table >> half & 15) * 0x11 for table in (total, carry))
            mode, cin = "datac", "0"
        self.cell(
            LUT,
            {"combout": output, "cout": onward},
            {"lut_mask": f"{total << 8 | carry:016b}", "sum_lutc_input": mode},
            **{"dataa": a, "datab": b, "datac": "1", "datad": "1", "cin": cin},
        )
        return output, onward

    def chain(
        self, a: list[Any], b: list[Any], carry: Any = "0", tables: tuple[int, int] = (SUM, CARRY)
    ) -> tuple[list[int], int]:
        """Sum of two numbers, and the last carry."""
        sums = []
        for x, y in zip(a, b, strict=True):
            bit, carry = self.chained(*tables, x, y, carry)
            sums.append(bit)
        return sums, carry

    def seed(self, signal: Any) -> int:
        """A signal put on a chain."""
        return self.chained(0, 0xAA, signal, "1", "0")[1]

    def tap(self, carry: int) -> int:
        """A carry taken off its chain."""
        return self.chained(0xF0, 0, "1", "1", carry)[0]

    def flip_flops(self, data: list[int]) -> None:
        for bit in data:
            self.cell(FLIP_FLOP, {"q": self.net()}, {}, d=bit)


def tables_of(module: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {name: cell for name, cell in module["cells"].items() if cell["type"] == LUT}


def evaluator(module: dict[str, Any], values: dict[Any, int]) -> Callable[[Any], int]:
    """Values of nets by the model in cells.v; ``values`` are those that no table drives."""
    drivers = {
        net: (cell, port)
        for cell in tables_of(module).values()
        for port, (net,) in cell["connections"].items()
        if port in ("combout", "cout")
    }
    known = {**values, "0": 0, "1": 1}

    def value(net: Any) -> int:
        if net not in known:
            cell, port = drivers[net]
            at = cell["connections"]
            a, b, c, d, cin = (
                value(at[name][0]) if name in at else 0
                for name in ("dataa", "datab", "datac", "datad", "cin")
            )
            third = cin if port == "cout" or cell["parameters"]["sum_lutc_input"] == "cin" else c
            fourth = 0 if port == "cout" else d
            mask = int(cell["parameters"]["lut_mask"], 2)
            known[net] = mask >> (a | b << 1 | third << 2 | fourth << 3) & 1
        return known[net]

    return value


def observed(module: dict[str, Any]) -> list[int]:
    """Nets that leave the tables: to ports and flip-flops."""
    nets = [bit for port in module["ports"].values() if port["direction"] == "output" for bit in port["bits"]]
    others = (cell for cell in module["cells"].values() if cell["type"] != LUT)
    return nets + [cell["connections"]["d"][0] for cell in others]


def assert_possible(module: dict[str, Any]) -> None:
    """Every cell exists in the device: in chains two data inputs, the carry to the next cell."""
    readers: dict[Any, list[tuple[str, str]]] = {}
    for name, cell in module["cells"].items():
        for port, (net,) in cell["connections"].items():
            if cell["port_directions"][port] == "input":
                readers.setdefault(net, []).append((name, port))
    out = set(observed(module))
    for cell in tables_of(module).values():
        at = {port: net for port, (net,) in cell["connections"].items()}
        chained = cell["parameters"]["sum_lutc_input"] == "cin"
        assert chained == isinstance(at.get("cin"), int)
        if chained:
            assert at["datac"] == "1"
        if "cout" in at and readers.get(at["cout"]):
            assert [port for _, port in readers[at["cout"]]] == ["cin"]
            assert at["cout"] not in out
            assert (at["datac"], at["datad"]) == ("1", "1")
        if chained and "combout" not in at:
            assert "cout" in at


def assert_same(before: dict[str, Any], after: dict[str, Any], count: int = 64) -> None:
    sources = [
        bit for port in before["ports"].values() if port["direction"] == "input" for bit in port["bits"]
    ]
    random_bits = random.Random(1)
    for _ in range(count):
        values: dict[Any, int] = {bit: random_bits.getrandbits(1) for bit in sources}
        old, new = evaluator(before, values), evaluator(after, values)
        assert [old(net) for net in observed(before)] == [new(net) for net in observed(after)]


def packed(netlist: Netlist) -> int:
    """Cells that are left, of a netlist that still does the same."""
    before = deepcopy(netlist.module)
    pack(netlist.module)
    assert_possible(netlist.module)
    assert_same(before, netlist.module)
    return len(tables_of(netlist.module))
