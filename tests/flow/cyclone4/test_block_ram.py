"""Memories become block RAM with output registers and second ports, with the same words."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from random import Random
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from amaranth.hdl import Cat, Module, Signal, Value, unsigned
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from numpy.typing import NDArray

from flow import rules
from flow.cyclone4 import synthesis
from flow.cyclone4.area import Area
from sim import Stimulus, make_engine

COMMANDS = data.StructLayout(
    {"write": 1, "read": 1, "move": 1, "turn": 1, "to": 13, "at": 13, "other": 13, "word": 21}
)
"""One beat: whether to write, to read, and to let registers of two kinds take over; addresses; what
to write.
"""

Values = list[Any]
Build = Callable[[Module, Any], Values]


class Bench(wiring.Component):
    """Memories that obey commands; the output's payload is their data, and changes with beats."""

    def __init__(self, width: int, build: Build) -> None:
        self._build = build
        super().__init__(
            {"i": In(stream.Signature(unsigned(COMMANDS.size))), "o": Out(stream.Signature(width))}
        )

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        step = self.i.valid & self.i.ready
        view = data.View(COMMANDS, self.i.payload)
        gated = {name: view[name] & step for name in ("write", "read", "move", "turn")}
        rest = {name: view[name] for name in ("to", "at", "other", "word")}
        m.d.comb += self.i.ready.eq(~self.o.valid | self.o.ready)
        with m.If(self.i.ready):
            m.d.sync += self.o.valid.eq(self.i.valid)
        values = Cat(*self._build(m, SimpleNamespace(**gated, **rest)))
        assert len(values) == len(self.o.payload)
        m.d.comb += self.o.payload.eq(values)
        return m


def ram(m: Module, c: Any, width: int, depth: int, **kind: Any) -> Value:
    """Read data of a memory; what is written is the command's word over and over."""
    memory = Memory(shape=width, depth=depth, init=[], attrs={"ram_style": "block"})
    m.submodules += memory
    write, read = memory.write_port(), memory.read_port(**kind)
    word = Cat(c.word, ~c.word, c.word)[:width]
    m.d.comb += [write.en.eq(c.write), write.addr.eq(c.to), write.data.eq(word)]
    m.d.comb += [read.en.eq(c.read), read.addr.eq(c.at)]
    return read.data


def table(m: Module, c: Any, width: int, depth: int, ports: int) -> Values:
    """Read data of each port of a memory with contents."""
    word = Random(width)
    init = [word.getrandbits(width) for _ in range(depth)]
    memory = Memory(shape=width, depth=depth, init=init, attrs={"ram_style": "block"})
    m.submodules += memory
    reads = [memory.read_port() for _ in range(ports)]
    for read, address in zip(reads, (c.at, c.other), strict=False):
        m.d.comb += [read.en.eq(c.read), read.addr.eq(address)]
    return [read.data for read in reads]


def register(m: Module, value: Any, enable: Any = None, **kind: Any) -> Signal:
    """A register behind a value, without reset unless told otherwise."""
    taken = Signal(len(value), **{"reset_less": True, **kind})
    if enable is None:
        m.d.sync += taken.eq(value)
    else:
        with m.If(enable):
            m.d.sync += taken.eq(value)
    return taken


def commands(count: int = 1500) -> NDArray[np.uint64]:
    """Random commands to eight addresses, so that words are read back, often during a write."""
    random = np.random.default_rng(5)
    places = np.array([0, 1, 5, 255, 256, 511, 1100, 7244], dtype=np.uint64)
    fields = {
        name: random.integers(0, 1 << field.width, count, dtype=np.uint64)
        for name, field in ((name, COMMANDS[name]) for name, _ in COMMANDS)
    }
    for name in ("to", "at", "other"):
        fields[name] = random.choice(places, count)
    same = random.random(count) < 0.3
    fields["at"][same] = fields["to"][same]
    beats = np.zeros(count, dtype=np.uint64)
    for name, value in fields.items():
        beats |= value << np.uint64(COMMANDS[name].offset)
    return beats


def outputs(engine: Any) -> list[Any]:
    return engine.run(Stimulus({"i": commands()})).outputs["o"].tolist()


def mapped(folder: Path, width: int, build: Build) -> tuple[Area, str, bool]:
    """What a bench takes, its netlist, and whether that does the same as its source."""
    tree, verilog = synthesis.map_component(Bench(width, build), "bench")
    path = folder / "gates.v"
    path.write_text(rules.rule_text("cyclone4", "cells.v") + verilog)
    found = outputs(make_engine("verilog", Bench(width, build), verilog=path))
    return tree.area, verilog, found == outputs(make_engine("amaranth", Bench(width, build)))


def with_output_registers(m: Module, c: Any) -> Values:
    """Every width of the block, a deep memory, a wide one over several blocks; with registers."""
    sizes = [(1, 8192), (2, 4096), (4, 2048), (9, 1024), (18, 512), (36, 256), (10, 1200), (40, 256)]
    return [register(m, ram(m, c, *size), c.move) for size in sizes]


def test_output_registers_are_the_blocks_own(tmp_path: Path) -> None:
    area, verilog, same = mapped(tmp_path, 120, with_output_registers)
    assert same
    # one flip-flop: whether there is a beat
    assert (area.ff, area.m9k) == (1, 6 + 3 + 2)
    assert area.memory_bits == 3 * 8192 + 3 * 9216 + 10 * 1200 + 40 * 256
    assert (
        verilog.count('.outdata_reg_b("CLOCK0")') == verilog.count('.clock_enable_output_b("NORMAL")') == 11
    )
    # nothing but the output register waits for that enable
    assert verilog.count('.clock_enable_input_a("BYPASS")') == verilog.count("altsyncram #") == 11


def without_output_registers(m: Module, c: Any) -> Values:
    """What the block's output register does not do, or not for all of its bits."""
    cleared = ram(m, c, 18, 512)
    preset = ram(m, c, 18, 512)
    two_enables = ram(m, c, 18, 512)
    some = ram(m, c, 18, 512)
    twice = ram(m, c, 18, 512)
    return [
        register(m, cleared, c.move, reset_less=False),
        register(m, preset, c.move, init=5),
        register(m, two_enables[:9], c.move),
        register(m, two_enables[9:], c.turn),
        register(m, some[:9], c.move),
        some[9:],
        register(m, twice, c.move),
        twice,
    ]


def test_other_registers_stay_flip_flops(tmp_path: Path) -> None:
    area, verilog, same = mapped(tmp_path, 6 * 18, without_output_registers)
    assert same
    assert (area.ff, area.m9k) == (1 + 4 * 18 + 9, 5)
    assert '.outdata_reg_b("CLOCK0")' not in verilog


def tables(m: Module, c: Any) -> Values:
    """Tables with two ports and zero to two registers, also different ones; one with one port."""
    first, second = table(m, c, 18, 512, 2)
    third, fourth = table(m, c, 7, 1024, 2)
    values = [register(m, first, c.move), register(m, second, c.move), register(m, third, c.move), fourth]
    values += table(m, c, 40, 256, 2)
    fifth, sixth = table(m, c, 9, 512, 2)
    values += [register(m, fifth, c.move), register(m, sixth, c.turn)]
    (single,) = table(m, c, 11, 600, 1)
    return [*values, register(m, single)]


def test_tables_are_read_by_two_ports_of_one_block(tmp_path: Path) -> None:
    area, verilog, same = mapped(tmp_path, 2 * (18 + 7 + 40 + 9) + 11, tables)
    assert same
    # 40 bits are three blocks, 18 bits the most through two ports; 11 bits of 600 words are two
    assert area.m9k == 1 + 1 + 3 + 1 + 2
    assert verilog.count('.operation_mode("BIDIR_DUAL_PORT")') == 6
    # both ports' output registers have one enable in common
    assert area.ff == 1 + 9
    assert verilog.count('.outdata_reg_a("CLOCK0")') == 3
    # counted once, whatever the ports
    assert area.memory_bits == 18 * 512 + 7 * 1024 + 40 * 256 + 9 * 512 + 11 * 600


FULL = {1: 8192, 2: 4096, 4: 2048, 9: 1024, 18: 512, 36: 256}
"""Words of each width that fill the block."""


def full_tables(m: Module, c: Any) -> Values:
    """Every width of the block, read through one port and, but for the widest, through two."""
    values = [table(m, c, width, depth, 1) for width, depth in FULL.items()]
    values += [table(m, c, width, depth, 2) for width, depth in FULL.items() if width < 36]
    return [register(m, Cat(*values), c.move)]


def test_tables_keep_their_contents_in_every_width(tmp_path: Path) -> None:
    area, verilog, same = mapped(tmp_path, sum(FULL) + 2 * (sum(FULL) - 36), full_tables)
    assert same
    assert area.m9k == verilog.count("altsyncram #") == 6 + 5
    for width in FULL:
        assert verilog.count(f".width_b(32'd{width})") == (1 if width == 36 else 2)


def some_of_all(m: Module, c: Any) -> Values:
    first, second = table(m, c, 18, 512, 2)
    return [
        register(m, ram(m, c, 10, 1200), c.move),
        register(m, first, c.move),
        register(m, second, c.move),
        table(m, c, 11, 600, 1)[0],
        table(m, c, 2, 4096, 1)[0],
    ]


def test_some_of_all_is_right(tmp_path: Path) -> None:
    assert mapped(tmp_path, 59, some_of_all)[2]


@pytest.mark.parametrize(
    ("file", "right", "wrong"),
    [
        # writing waits for the output register's enable
        ("memory.v", '.clock_enable_input_a("BYPASS")', '.clock_enable_input_a("NORMAL")'),
        ("memory.v", '.clock_enable_input_b("BYPASS")', '.clock_enable_input_b("NORMAL")'),
        ("memory.v", ".rden_b(PORT_R_RD_EN)", ".rden_b(1'b1)"),
        ("memory.v", ".rden_a(PORT_A_RD_EN)", ".rden_a(1'b1)"),
        ("memory.v", ".address_b(PORT_B_ADDR", ".address_b(PORT_A_ADDR"),
        ("memory.v", ".contents(INIT)", ".contents(INIT >> 9)"),
        ("memory.v", ".wren_a(PORT_W_WR_EN)", ".wren_a(1'b1)"),
        # narrow words follow each other without a gap
        ("cells.v", "width_a < 9 ?", "width_a < 0 ?"),
    ],
)
def test_faults_are_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str, right: str, wrong: str
) -> None:
    whole = rules.rule_text

    def changed(device: str, name: str) -> str:
        text = whole(device, name)
        assert name != file or right in text
        return text.replace(right, wrong) if name == file else text

    monkeypatch.setattr(rules, "rule_text", changed)
    assert not mapped(tmp_path, 59, some_of_all)[2]
