"""Logic cells that become one: the same functions in fewer cells, which the device has."""

from __future__ import annotations

import random
from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

from flow.cyclone4 import packing
from flow.cyclone4.packing import Function, pack
from tests.support.netlists import CARRY, DIFFERENCE, NO_BORROW, SUM, Netlist, packed, tables_of

# -- functions


def test_functions_depend_on_what_matters_only() -> None:
    conjunction = Function.of([7, 5], 0b1000)
    assert conjunction == Function((5, 7), 0b1000)
    assert Function.of([5, 5], 0b0110) == Function((), 0)
    assert Function.of(["1", 5], 0b1000) == Function((5,), 0b10)
    assert Function.of(["x", 5], 0b1011) == Function((5,), 0b01)
    assert Function.of([5, 9, 7], 0b10101010) == Function((5,), 0b10)
    exclusive = Function.of([5, 6], 0b0110)
    assert exclusive.with_input(6, conjunction) == Function.of([5, 7], 0b0010)
    assert exclusive.with_input(4, conjunction) == exclusive
    assert exclusive.with_input(6, Function.of([5], 0b01)) == Function((), 1)


# -- each rule, where it applies and where it must not


def operand(netlist: Netlist, mask: int, a: list[int], signal: int) -> list[int]:
    return [netlist.table(mask, bit, signal) for bit in a]


def conditional_negation() -> Netlist:
    """(d ^ s) + s"""
    netlist = Netlist()
    d, (s,) = netlist.inputs(8), netlist.inputs(1)
    sums, _ = netlist.chain(operand(netlist, 0b0110, d, s), [s, *"0000000"])
    netlist.flip_flops(sums)
    return netlist


def masked_operands() -> Netlist:
    """Both operands of a bit are functions of the same two signals: only together they fit."""
    netlist = Netlist()
    x, y = netlist.inputs(4), netlist.inputs(4)
    a = [netlist.table(0b1000, p, q) for p, q in zip(x, y, strict=True)]
    b = [netlist.table(0b1110, p, q) for p, q in zip(x, y, strict=True)]
    netlist.flip_flops(netlist.chain(a, b)[0])
    return netlist


def complement_for_two() -> Netlist:
    """Two chains read the same complemented number."""
    netlist = Netlist()
    a, b, c = (netlist.inputs(4) for _ in range(3))
    inverted = [netlist.table(0b01, bit) for bit in a]
    netlist.flip_flops(netlist.chain(inverted, b)[0] + netlist.chain(inverted, c)[0])
    return netlist


def third_signal() -> Netlist:
    """A masked operand beside another one: three data signals, which only the last cell takes."""
    netlist = Netlist()
    a, b, (s,) = netlist.inputs(4), netlist.inputs(4), netlist.inputs(1)
    netlist.flip_flops(netlist.chain(operand(netlist, 0b1000, a, s), b)[0])
    return netlist


def read_elsewhere() -> Netlist:
    """A complemented number that leaves the module, too."""
    netlist = Netlist()
    a, b = netlist.inputs(4), netlist.inputs(4)
    inverted = [netlist.table(0b01, bit) for bit in a]
    netlist.port("inverted", "output", inverted)
    netlist.flip_flops(netlist.chain(inverted, b)[0])
    return netlist


def cleared_counter() -> Netlist:
    """x + 1, or zero"""
    netlist = Netlist()
    x, (clear,) = netlist.inputs(6), netlist.inputs(1)
    sums, _ = netlist.chain(x, [*"100000"])
    netlist.flip_flops(operand(netlist, 0b0010, sums, clear))
    return netlist


def gated_sum() -> Netlist:
    """a + b, or zero: no room but in the last cell."""
    netlist = Netlist()
    a, b, (clear,) = netlist.inputs(6), netlist.inputs(6), netlist.inputs(1)
    netlist.flip_flops(operand(netlist, 0b0010, netlist.chain(a, b)[0], clear))
    return netlist


def sum_read_twice() -> Netlist:
    """x + 1, also cleared: the sums themselves are read."""
    netlist = Netlist()
    x, (clear,) = netlist.inputs(4), netlist.inputs(1)
    sums, _ = netlist.chain(x, [*"1000"])
    netlist.port("sums", "output", sums)
    netlist.flip_flops(operand(netlist, 0b0010, sums, clear))
    return netlist


def neighbours() -> Netlist:
    """Neighbouring bits of x + 1 combined: the lower cell makes the higher one's carry."""
    netlist = Netlist()
    sums, _ = netlist.chain(netlist.inputs(4), [*"1000"])
    netlist.port("sums", "output", sums[1::2])
    netlist.flip_flops([netlist.table(0b0110, sums[0], sums[1]), netlist.table(0b0110, sums[2], sums[3])])
    return netlist


def comparison() -> Netlist:
    """a >= b, and a signal"""
    netlist = Netlist()
    a, b, (s,) = netlist.inputs(5), netlist.inputs(5), netlist.inputs(1)
    _, carry = netlist.chain(a, b, "1", (DIFFERENCE, NO_BORROW))
    netlist.flip_flops([netlist.table(0b1000, netlist.tap(carry), s)])
    return netlist


def comparison_and_difference() -> Netlist:
    """a - b and its borrow: the cell that takes the carry off stays, with room for three nets."""
    netlist = Netlist()
    a, b, s = netlist.inputs(5), netlist.inputs(5), netlist.inputs(3)
    sums, carry = netlist.chain(a, b, "1", (DIFFERENCE, NO_BORROW))
    netlist.flip_flops([*sums, netlist.table(0b1011001101110010, netlist.tap(carry), *s)])
    return netlist


def known_carry() -> Netlist:
    """{s, a} + s: the first bit knows the carry in."""
    netlist = Netlist()
    a, (s,) = netlist.inputs(5), netlist.inputs(1)
    netlist.flip_flops(netlist.chain(a, [s, *"0000"], netlist.seed(s))[0])
    return netlist


def unknown_carry() -> Netlist:
    """a + b + s"""
    netlist = Netlist()
    a, b, (s,) = netlist.inputs(5), netlist.inputs(5), netlist.inputs(1)
    netlist.flip_flops(netlist.chain(a, b, netlist.seed(s))[0])
    return netlist


def unread() -> Netlist:
    """The low half of a sum, and a table, that nobody reads."""
    netlist = Netlist()
    a, b = netlist.inputs(6), netlist.inputs(6)
    netlist.table(0b1000, a[0], b[0])
    netlist.flip_flops(netlist.chain(a, b)[0][:3])
    return netlist


@pytest.mark.parametrize(
    ("build", "before", "after"),
    [
        (conditional_negation, 16, 8),
        (masked_operands, 12, 4),
        (complement_for_two, 12, 8),
        (third_signal, 8, 7),
        (read_elsewhere, 8, 8),
        (cleared_counter, 12, 6),
        (gated_sum, 12, 11),
        (sum_read_twice, 8, 8),
        (neighbours, 6, 6),
        (comparison, 7, 5),
        (comparison_and_difference, 7, 6),
        (known_carry, 6, 5),
        (unknown_carry, 6, 6),
        (unread, 7, 3),
    ],
)  # fmt: skip
def test_cells_that_are_left(build: Callable[[], Netlist], before: int, after: int) -> None:
    netlist = build()
    assert len(tables_of(netlist.module)) == before
    assert packed(netlist) == after


# -- whatever the netlist


def anything(seed: int) -> Netlist:
    """Tables and chains of any functions, which read each other and now and then a constant."""
    choose = random.Random(seed)
    netlist = Netlist()
    nets: list[Any] = [*netlist.inputs(choose.randint(2, 7))]

    def some() -> Any:
        return choose.choice("01") if choose.random() < 0.15 else choose.choice(nets[-8:])

    for _ in range(choose.randint(2, 14)):
        if choose.random() < 0.6:
            count = choose.randint(1, 4)
            nets.append(netlist.table(choose.getrandbits(1 << count), *(some() for _ in range(count))))
            continue
        carry: Any = netlist.seed(some()) if choose.random() < 0.3 else choose.choice("01")
        for _ in range(choose.randint(1, 5)):
            usual = (choose.choice([SUM, DIFFERENCE]), choose.choice([CARRY, NO_BORROW]))
            tables = usual if choose.random() < 0.5 else (choose.getrandbits(8), choose.getrandbits(8))
            bit, carry = netlist.chained(*tables, some(), some(), carry)
            if choose.random() < 0.7:
                nets.append(bit)
        if choose.random() < 0.5:
            nets.append(netlist.tap(carry))
    driven = [net for net in nets if net not in netlist.module["ports"]["i0"]["bits"]]
    netlist.port("o", "output", choose.sample(driven, min(len(driven), choose.randint(1, 4))))
    netlist.flip_flops(choose.sample(driven, min(len(driven), 2)))
    return netlist


SEEDS = range(400)


def test_any_netlist_stays_the_same() -> None:
    saved = 0
    for seed in SEEDS:
        netlist = anything(seed)
        count = len(tables_of(netlist.module))
        saved += count - packed(netlist)
        # nothing is left to do
        again = deepcopy(netlist.module)
        pack(again)
        assert again == netlist.module
    assert saved > 1000


def inverted(self: Function, net: int, inner: Function) -> Function:
    """As if what comes in were complemented."""
    return (
        Function.of(self.inputs, self.table)
        if net not in self.inputs
        else Function.of(self.inputs, ~self.table)
    )


@pytest.mark.parametrize(
    ("where", "name", "wrong"),
    [
        (packing, "CHAIN_DATA", 3),
        (packing, "LAST_DATA", 4),
        (Function, "with_input", inverted),
        # forgets readers that are no tables
        (packing._Packing, "_only_reader", lambda self, net: next(iter(self._readers_of(net)), None)),
        (packing._Packing, "_depend", lambda self, nets, name: False),
        (packing._Packing, "_is_read", lambda self, net: bool(self._readers_of(net))),
    ],
    ids=["chain of three inputs", "last of four", "function", "only reader", "loop", "read"],
)
def test_faults_are_noticed(monkeypatch: pytest.MonkeyPatch, where: Any, name: str, wrong: Any) -> None:
    monkeypatch.setattr(where, name, wrong)
    with pytest.raises((AssertionError, KeyError, RecursionError)):
        for seed in SEEDS:
            packed(anything(seed))
