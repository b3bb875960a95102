# amaranth: UnusedElaboratable=no
"""Every rule of the Cyclone IV map applies, and its result is equal to its source."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from amaranth.hdl import C, Cat, Module, Mux, Signal, signed, unsigned

from flow import rules
from flow.cyclone4 import packing, refine
from flow.cyclone4.area import Area
from tests.support.equivalence import Several, equivalent, logic, mapped

Values = list[Any]


def sums(m: Module, a: Any, b: Any, carry: Any) -> Values:
    values = [a + b, a - b, (a + b + carry)[: len(a)], a - b - carry, -a, (a << 3) + b]
    return [*values, a + b + (a >> 1), a - b - (b >> 1) - carry, a - (b << 2)]


def constants(m: Module, a: Any, b: Any, carry: Any) -> Values:
    return [a + 1, a - 1, a + 13, a - 24, 40 - a, 64 + a, a + carry, a - carry, (a + 20)[:4], a + C(-7, 5)]


def known_low_bits(m: Module, a: Any, b: Any, carry: Any) -> Values:
    """Operands whose low bits are constants of all kinds, with every carry in."""
    low = [C(value, 2) for value in range(4)]
    values = [Cat(x, a) + Cat(y, b) for x in low for y in low]
    values += [Cat(x, a) - Cat(y, b) for x in low for y in low]
    return values + [Cat(x, a) + Cat(y, b) + carry for x in low for y in low]


def comparisons(m: Module, a: Any, b: Any, carry: Any) -> Values:
    values = [a < b, a <= b, a > b, a >= b, a == b, a != b, (a < b) & carry, Mux(a >= b, a, b)]
    return [*values, a < 9, a <= 17, a > 5, a >= 12, 30 > a, a == 11]


def signs(m: Module, a: Any, b: Any, carry: Any) -> Values:
    a, b = a.as_signed(), b.as_signed()
    return [a < -3, a >= 2, b > -1, b <= 1, 0 < a, a < b, a - b, a + 5]


def order(m: Module, a: Any, b: Any, carry: Any) -> Values:
    return [a.as_signed() < b.as_signed()]


def carries(m: Module, a: Any, b: Any, carry: Any) -> Values:
    """Sums of which only the top is used, and steps that add or subtract."""
    step = a + (b ^ carry.replicate(len(b))) + carry
    return [(a + b)[-1], (a - b)[-1] ^ carry, step, (a + b + carry)[-2:], ((a + b) >> 3)[:3]]


def tables(m: Module, a: Any, b: Any, carry: Any) -> Values:
    wide = Cat(a, b, carry)
    return [
        ~a[0],
        a[0] & b[0],
        a[0] ^ b[0] ^ carry,
        Mux(carry, a, b),
        wide.any(),
        wide.all(),
        wide.xor(),
        a[:2] == b[:2],
    ]


COMBINATIONAL = [sums, constants, known_low_bits, comparisons, signs, order, carries, tables]


@pytest.mark.parametrize("shape", [unsigned(6), signed(6), unsigned(3)], ids=repr)
@pytest.mark.parametrize("function", COMBINATIONAL, ids=lambda function: function.__name__)
def test_logic(tmp_path: Path, function: Callable[..., Values], shape: Any) -> None:
    mapped(logic(function, a=shape, b=shape, carry=1), tmp_path)
    assert equivalent(tmp_path)


def test_operands_of_different_widths_and_signs(tmp_path: Path) -> None:
    def mixed(m: Module, a: Any, b: Any, c: Any) -> Values:
        return [a + b, a - b, b - a, a + c, c - b, b - c, a < b, b <= c, c > a, a + b - c]

    mapped(logic(mixed, a=unsigned(3), b=signed(7), c=unsigned(5)), tmp_path)
    assert equivalent(tmp_path)


def flip_flops(m: Module, a: Any, enable: Any, clear: Any, other: Any) -> Values:
    """Registers with every enable, reset and initial value; the reset resets all but one."""
    bits = len(a)
    registers = [
        Signal(bits, name=f"register_{k}", init=init, reset_less=k == 1)
        for k, init in enumerate([0, 0, 5, 0, 19, 0])
    ]
    plain, always, start, enabled, both, cleared = registers
    m.d.sync += [plain.eq(a), always.eq(~a)]
    with m.If(enable):
        m.d.sync += [start.eq(a), enabled.eq(a)]
        with m.If(clear):
            m.d.sync += both.eq(7)
        with m.Else():
            m.d.sync += both.eq(a)
    m.d.sync += cleared.eq(a)
    with m.If(clear):
        m.d.sync += cleared.eq(0)
    return registers


def counters(m: Module, a: Any, enable: Any, clear: Any, other: Any) -> Values:
    """Sums that are cleared or replaced: by nothing, by all ones, by a value, and twice over."""
    wrapping, loaded, preset, twice, turned = (Signal(len(a), name=f"counter_{k}") for k in range(5))
    with m.If(enable):
        m.d.sync += [wrapping.eq(Mux(clear, 0, wrapping + 1)), loaded.eq(Mux(clear, a, loaded + 3))]
        m.d.sync += preset.eq(Mux(clear & other, (1 << len(a)) - 1, preset + a))
    m.d.sync += [twice.eq(Mux(clear, 0, Mux(other, a, twice + a))), turned.eq(Mux(clear, ~(turned + a), 0))]
    return [wrapping, loaded, preset, twice, turned]


def multiplexers(m: Module, a: Any, enable: Any, clear: Any, other: Any) -> Values:
    """Registers behind choices between several registers."""
    banks = [Signal(len(a), name=f"bank_{k}") for k in range(4)]
    chosen = Signal(len(a))
    m.d.sync += banks[0].eq(a)
    for before, after in pairwise(banks):
        m.d.sync += after.eq(before)
    m.d.sync += chosen.eq(Mux(enable, Mux(clear, banks[0], banks[1]), Mux(other, banks[2], banks[3])))
    return [chosen, banks[3]]


@pytest.mark.parametrize(
    "function", [flip_flops, counters, multiplexers], ids=lambda function: function.__name__
)
def test_registers(tmp_path: Path, function: Callable[..., Values]) -> None:
    mapped(logic(function, a=5, enable=1, clear=1, other=1), tmp_path)
    assert equivalent(tmp_path)


# -- what each rule saves


def areas(folder: Path, functions: list[Callable[..., Values]]) -> list[Area]:
    """What functions of two bytes and a bit take, each by itself; all proven equivalent."""
    parts = {f"part_{k}": logic(function, a=8, b=8, c=1) for k, function in enumerate(functions)}
    tree = mapped(Several(parts), folder)
    assert equivalent(folder)
    found = {block.name: block.area for block in tree.blocks}
    # parts without cells are no blocks
    return [found.get(name, Area()) for name in parts]


OPERATIONS: list[tuple[Callable[..., Values], int]] = [
    (lambda m, a, b, c: [a + b], 9),
    (lambda m, a, b, c: [(a + b)[:8]], 8),
    (lambda m, a, b, c: [(a - b)[:8]], 8),
    (lambda m, a, b, c: [a - b], 9),
    # a carry in that is a signal takes a cell
    (lambda m, a, b, c: [(a + b + c)[:8]], 9),
    # a carry out takes a cell only if the last difference is read too
    (lambda m, a, b, c: [a < b], 8),
    (lambda m, a, b, c: [(a >= b) & c], 8),
    (lambda m, a, b, c: [(a - b)[:8], a < b], 9),
    # constants
    (lambda m, a, b, c: [(a + 1)[:8]], 8),
    # the low bits of one operand are known, so the sum's are the other's
    (lambda m, a, b, c: [(a + (b << 3))[:8]], 5),
    # tables of one or two signals before a chain become part of it
    (lambda m, a, b, c: [(a + ~b)[:8]], 8),
    (lambda m, a, b, c: [((a & b) + a)[:8]], 8),
    (lambda m, a, b, c: [((a & c.replicate(8)) + 85)[:8]], 8),
    # carry in and lowest bit share a cell, if only two signals reach them
    (lambda m, a, b, c: [(Cat(c, a[1:]) + Cat(C(1, 1), b[1:]) + ~c)[:8]], 8),
    # comparing with a constant takes no chain
    (lambda m, a, b, c: [a < 100], 2),
    (lambda m, a, b, c: [a.as_signed() >= -100], 2),
    (lambda m, a, b, c: [c], 0),
    (lambda m, a, b, c: [~c], 1),
    (lambda m, a, b, c: [Cat(a[:3], c).xor()], 1),
]  # fmt: skip


def test_cells_of_operations(tmp_path: Path) -> None:
    found = areas(tmp_path, [function for function, _ in OPERATIONS])
    assert [(area.lut4, area.ff) for area in found] == [(cells, 0) for _, cells in OPERATIONS]


def accumulate(value: Callable[..., Any]) -> Callable[..., Values]:
    def function(m: Module, a: Any, b: Any, c: Any) -> Values:
        total = Signal(8, reset_less=True)
        m.d.sync += total.eq(value(total, a, b, c))
        return [total]

    return function


REGISTERS: list[tuple[Callable[..., Any], int]] = [
    (lambda total, a, b, c: total + a, 8),
    (lambda total, a, b, c: Mux(c, 0, total + a), 8),
    (lambda total, a, b, c: Mux(c, 255, total + a), 8),
    (lambda total, a, b, c: Mux(c, b, total + a), 8),
    # the condition is a table of its own
    (lambda total, a, b, c: Mux(c & b[0], b, total + a), 9),
    # two chains: the second comes in by the load
    (lambda total, a, b, c: Mux(c, total + b, total + a), 16),
    # no multiplexer; the last bit's cell has an input to spare
    (lambda total, a, b, c: (total + a) ^ c.replicate(8), 15),
]  # fmt: skip


def test_elements_of_registers(tmp_path: Path) -> None:
    found = areas(tmp_path, [accumulate(value) for value, _ in REGISTERS])
    assert [area.ff for area in found] == [8] * len(REGISTERS)
    assert [(area.lut4, area.le_packed) for area in found] == [(cells, cells) for _, cells in REGISTERS]


def test_a_control_signal_is_not_spent_on_few_flip_flops(tmp_path: Path) -> None:
    def function(m: Module, a: Any, b: Any, c: Any) -> Values:
        totals = [Signal(3, name=f"total_{k}", reset_less=True) for k in range(3)]
        for total, control in zip(totals, c, strict=True):
            m.d.sync += total.eq(Mux(control, b, total ^ a))
        return totals

    mapped(logic(function, a=3, b=3, c=3), tmp_path)
    assert ".sload(1'h0)" in (tmp_path / "netlist.v").read_text()
    assert ".sload(c" not in (tmp_path / "netlist.v").read_text()


# -- a fault in any rule is noticed


def spoil(monkeypatch: pytest.MonkeyPatch, rule: str, right: str, wrong: str) -> None:
    """Change a file of the map, in one place."""
    whole = rules.rule_text

    def changed(device: str, name: str) -> str:
        text = whole(device, name)
        if name == rule:
            assert right in text
            return text.replace(right, wrong)
        return text

    monkeypatch.setattr(rules, "rule_text", changed)


@pytest.mark.parametrize(
    ("rule", "right", "wrong", "function"),
    [
        ("arithmetic.v", "8'h96;", "8'h97;", sums),
        ("arithmetic.v", "8'hB2", "8'hE8", sums),
        ("arithmetic.v", "FIRST_CARRY ? CARRY[7:4]", "!FIRST_CARRY ? CARRY[7:4]", sums),
        ("arithmetic.v", "16'h00AA", "16'h0055", carries),
        ("arithmetic.v", "X[i+1] ^ Y[i+1]", "X[i+1]", order),
        ("arithmetic.v", "16'hF0F0", "16'h0F0F", comparisons),
        ("operators.v", '== "$ge" ||', '== "$lt" ||', comparisons),
        ("operators.v", "below[i] : x[i]", "below[i] : y[i]", signs),
        ("operators.v", '== "$sub"', '!= "$sub"', sums),
        ("luts.v", "{4{LUT[3:0]}}", "{4{LUT[0], LUT[2], LUT[1], LUT[3]}}", tables),
        ("luts.v", ".datad(A[3])", ".datad(A[2])", tables),
    ],
)
def test_fault_in_the_map_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rule: str, right: str, wrong: str, function: Any
) -> None:
    spoil(monkeypatch, rule, right, wrong)
    mapped(logic(function, a=6, b=6, carry=1), tmp_path)
    assert not equivalent(tmp_path)


@pytest.mark.parametrize(
    ("right", "wrong", "function"),
    [
        ('"high" : "low"', '"low" : "high"', flip_flops),
        (".ena(E)", ".ena(1'b1)", flip_flops),
        (".sclr(R)", ".sclr(1'b0)", flip_flops),
    ],
)
def test_fault_in_the_flip_flops_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, right: str, wrong: str, function: Any
) -> None:
    spoil(monkeypatch, "flipflops.v", right, wrong)
    mapped(logic(function, a=5, enable=1, clear=1, other=1), tmp_path)
    assert not equivalent(tmp_path)


def test_fault_in_the_packing_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # as if cells that make a carry had three data inputs
    monkeypatch.setattr(packing, "CHAIN_DATA", 3)
    mapped(logic(carries, a=6, b=6, carry=1), tmp_path)
    assert not equivalent(tmp_path)


def test_fault_in_clear_and_load_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    split = refine._split

    def wrong(table: Any, data: int) -> Any:
        found = split(table, data)
        return None if found is None else (found[0], tuple(1 - held for held in found[1]), *found[2:])

    monkeypatch.setattr(refine, "_split", wrong)
    mapped(logic(counters, a=5, enable=1, clear=1, other=1), tmp_path)
    assert not equivalent(tmp_path)
