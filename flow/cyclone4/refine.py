"""Improves a mapped netlist by features of the device that Yosys's passes do not use.

Each rule takes away cells and changes no behaviour:

- block RAM and multipliers have registers of their own, which take the flip-flops at their ports,
  see :mod:`flow.cyclone4.absorb`;
- tables and cells of carry chains become one, see :mod:`flow.cyclone4.packing`;
- a synchronous clear or load takes the multiplexer before a flip-flop, so that the flip-flop shares
  a logic element with what lies before the multiplexer. Clear and load are signals of a whole LAB,
  so several flip-flops must have them in common.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass

from flow.cyclone4.absorb import absorb_registers
from flow.cyclone4.netlist import FLIP_FLOP, LUT, Cell, Module, Values, assignments
from flow.cyclone4.packing import pack
from flow.netlist import Bit, Json

LEAST_TOGETHER = 4
"""Flip-flops with a clear or load in common that are worth one of a LAB's control signals."""


def refine(netlist: Json) -> None:
    """Apply all rules to all modules of a netlist."""
    for json in netlist["modules"].values():
        if not json["cells"]:
            continue
        pack(json)
        module = Module(json)
        absorb_registers(module)
        while _synchronous_control(module):
            pass
        module.drop_unused()


@dataclass(frozen=True)
class _Control:
    """The condition on which a flip-flop is loaded past its multiplexer."""

    enable: Bit
    clear: Bit
    nets: tuple[int, ...]
    """The nets that the condition reads."""
    condition: tuple[int, ...]
    """The condition for all values of these nets."""
    clears: bool


@dataclass(frozen=True)
class _Candidate:
    register: Cell
    table: Cell
    data: int
    """The net that goes to the flip-flop where the condition does not hold."""
    inverted: bool
    other: Bit
    """The net that is loaded."""


def _synchronous_control(module: Module) -> bool:
    groups: dict[_Control, dict[str, _Candidate]] = defaultdict(dict)
    for register in module.of_kind(FLIP_FLOP):
        for control, candidate in _candidates(module, register):
            groups[control].setdefault(register.name, candidate)
    # the largest first; a flip-flop is changed once, then all is looked at again
    for control, members in sorted(groups.items(), key=lambda item: -len(item[1])):
        taken: set[int] = set()
        worth = []
        for candidate in members.values():
            if candidate.data not in taken:
                taken.add(candidate.data)
                worth.append(candidate)
        if len(worth) >= LEAST_TOGETHER:
            _give_control(module, control, worth)
            return True
    return False


def _candidates(module: Module, register: Cell) -> list[tuple[_Control, _Candidate]]:
    table = module.table_behind(register["d"])
    if register["sload"] != "0" or table is None or module.only_reader(register["d"]) is None:
        return []
    found = []
    for data in table.nets:
        source = module.driver[data][0] if data in module.driver else None
        if source is None or source.kind != LUT or module.driver[data][1] != "combout":
            continue
        if any(reader is not None and port == "d" for reader, port in module.readers[data]):
            continue
        split = _split(table, data)
        if split is None:
            continue
        nets, condition, inverted, other = split
        if inverted and module.only_reader(data) is None:
            continue
        if other != "0":
            # what is loaded comes in where the table of the same element has its third input
            if (
                not source.reads_carry
                and not module.makes_carry(source)
                and len(source.nets) > 3
                and other not in source.nets
            ):
                continue
        elif register["sclr"] != "0" and len(nets) > 3:
            continue
        control = _Control(register["ena"], register["sclr"], nets, condition, other == "0")
        found.append((control, _Candidate(register, table, data, inverted, other)))
    return found


def _split(table: Cell, data: int) -> tuple[tuple[int, ...], tuple[int, ...], bool, Bit] | None:
    """A table as a multiplexer: the nets and values of its condition, and what it then takes."""
    rest = sorted(table.nets - {data})
    rows = [
        (table.output({**values, data: 0}), table.output({**values, data: 1})) for values in assignments(rest)
    ]
    passing = {row for row in rows if row[0] != row[1]}
    if len(passing) != 1:
        return None
    inverted = passing == {(1, 0)}
    fixed = [
        (values, row[0]) for values, row in zip(assignments(rest), rows, strict=True) if row[0] == row[1]
    ]
    if not fixed:
        return None
    other: Bit | None = None
    if len({value for _, value in fixed}) == 1:
        other = str(fixed[0][1])
    else:
        for net in rest:
            if all(values[net] == value for values, value in fixed):
                other = net
    if other is None:
        return None
    # where the condition does not hold, nothing is known about the net that is loaded, so the
    # result may depend on it
    condition = [int(row[0] == row[1]) for row in rows]
    needed = [
        net
        for place, net in enumerate(rest)
        if any(
            condition[index] != condition[index ^ 1 << (len(rest) - 1 - place)]
            for index in range(len(condition))
        )
    ]
    reduced = []
    for values in assignments(needed):
        full = {**dict.fromkeys(rest, 0), **values}
        index = int("".join(str(full[net]) for net in rest) or "0", 2)
        reduced.append(condition[index])
    return tuple(needed), tuple(reduced), inverted, other


def _give_control(module: Module, control: _Control, members: list[_Candidate]) -> None:
    nets = list(control.nets)
    truth = {
        tuple(values.values()): held
        for values, held in zip(assignments(nets), control.condition, strict=True)
    }

    def condition(values: Values) -> int:
        return truth[tuple(values[net] for net in nets)]

    clear = control.clear
    if control.clears and isinstance(clear, int):
        signal = module.add_table([*nets, clear], lambda values: int(values[clear] or condition(values)))
    elif len(nets) == 1 and truth[(1,)] == 1:
        signal = nets[0]
    else:
        signal = module.add_table(nets, condition)
    for member in members:
        register = member.register
        if member.inverted:
            source = module.driver[member.data][0]
            source.set_mask(source.mask ^ (0xFF00 if module.makes_carry(source) else 0xFFFF))
        with module.changing(register):
            register["d"] = member.data
            if control.clears:
                register["sclr"] = signal
            else:
                register["sload"], register["asdata"] = signal, member.other
        module.remove(member.table)
