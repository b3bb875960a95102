"""Synthesis for Cyclone IV: Yosys with our own map, see ``docs/explanation/synthesis.md``."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from tempfile import TemporaryDirectory

from amaranth.back import rtlil
from amaranth.lib import wiring

from flow.cyclone4.area import Area, Block, total
from flow.cyclone4.netlist import PRIMITIVES, area_tree, own_area
from flow.cyclone4.refine import refine
from flow.netlist import Json
from flow.rules import write_rules
from flow.verilog import MODULE
from flow.yowasp import run_yosys
from hdl.build import Build
from hdl.edges import Interface, make_core

RULES = (
    "cells.v",
    "operators.v",
    "multipliers.v",
    "memory.txt",
    "memory.v",
    "arithmetic.v",
    "flipflops.v",
    "luts.v",
)

# every memory becomes block RAM, as the exported project asks Quartus to do
MAP = """
read_verilog -lib -DPORTS_ONLY cells.v
read_rtlil design.il
hierarchy -check -top {top}
proc
opt_expr
opt_clean
check -assert
opt
opt -full
wreduce
peepopt
opt_clean
techmap -map operators.v t:$lt t:$gt t:$ge t:$le
opt
alumacc
maccmap -unmap
wreduce
techmap -map operators.v t:$add t:$sub
share
opt
tee -q -o multipliers.txt dump -m t:$mul
techmap -map multipliers.v t:$mul
memory -nomap
opt_clean
setattr -set ram_style "block" t:$mem_v2
tee -q -o memories.txt dump -m t:$mem_v2
memory_libmap -lib memory.txt
tee -q -o left.txt dump -m t:$mem_v2
techmap -map memory.v
opt -fast -mux_undef -undriven -fine
memory_map
opt -undriven -fine
techmap -map arithmetic.v
techmap
opt -fast
opt_expr -undriven -fine
opt_clean
dfflegalize -cell $_DFFE_PP_ 01 -cell $_SDFFCE_PP0P_ 0 -mince 4 -minsrst 4
techmap -map flipflops.v
opt_expr -mux_undef
simplemap
opt_merge
opt_clean
design -save before_tables
"""
# from logic to tables, for area: logic is shared where that saves some, even if a path becomes
# longer
TABLES = """
design -load before_tables
abc -lut 4 -script +{script}
clean
techmap -map luts.v
clean
write_json mapped_{number}.json
"""
ABC = (
    "strash;ifraig;scorr;&get,-n;&syn3;&syn4;&dch;&put;if,-a;mfs2;lutpack,-S,1",
    "strash;ifraig;scorr;dc2;dch,-f;if,-a;mfs2;lutpack,-S,1",
)
"""None of these is the best for all blocks, so each block takes the best for it."""

WRITE = """
read_verilog -lib -DPORTS_ONLY cells.v
read_json refined.json
hierarchy -check -top {top}
opt_clean
check -assert
write_json mapped.json
write_verilog -noattr netlist.v
"""


@dataclass(frozen=True)
class Synthesis:
    """A detector, mapped to cells of Cyclone IV.

    Parameters
    ----------
    build
        What was built.
    tree
        Area of the top module and of all modules below it.
    verilog
        Structural netlist of ``cycloneiv_lcell_comb``, ``dffeas`` and ``altsyncram``, top module
        :data:`flow.verilog.MODULE`. The cells' behaviour is in ``flow/cyclone4/cells.v``.
    """

    build: Build
    tree: Block
    verilog: str

    @property
    def blocks(self) -> dict[str, Area]:
        """Area of each block by name, with all inside: of the detector's stages, or another top's.

        The wiring between them is ``(top)``.
        """
        stages = [block for block in self.tree.blocks if block.name.endswith("_stage")]
        others = [block for block in self.tree.blocks if block not in stages]
        blocks = [*others, *chain.from_iterable(stage.blocks for stage in stages)]
        areas = {block.name: block.area for block in blocks}
        own = total([self.tree.own, *(stage.own for stage in stages)])
        return areas | {"(top)": own} if own != Area() else areas

    @property
    def total(self) -> Area:
        return self.tree.area


def synthesize(build: Build, interface: Interface = "stream") -> Synthesis:
    """Map a core to Cyclone IV; hierarchy is kept, and each block mapped by itself.

    Raises
    ------
    ValueError
        This build cannot have such edges.
    ToolNotFoundError, ToolError
        A tool is missing, or failed; the message says what to install, or what went wrong.
    """
    tree, verilog = map_component(make_core(build, interface), MODULE)
    return Synthesis(build, tree, verilog)


def map_component(component: wiring.Component, top: str) -> tuple[Block, str]:
    """Area and structural netlist of any component, as module ``top``."""
    with TemporaryDirectory(prefix="cornerstream-") as name:
        folder = Path(name)
        write_rules("cyclone4", RULES, folder)
        (folder / "design.il").write_text(
            rtlil.convert(component, name=top, emit_src=False), encoding="utf-8"
        )
        ways = "".join(TABLES.format(script=script, number=number) for number, script in enumerate(ABC))
        run_yosys(MAP.format(top=top) + ways, folder)
        mapped = [
            json.loads((folder / f"mapped_{number}.json").read_text(encoding="utf-8"))
            for number in range(len(ABC))
        ]
        netlist = _best(mapped)
        (folder / "refined.json").write_text(json.dumps(netlist), encoding="utf-8")
        run_yosys(WRITE.format(top=top), folder)
        netlist = json.loads((folder / "mapped.json").read_text(encoding="utf-8"))
        read = {stem: (folder / f"{stem}.txt").read_text() for stem in ("memories", "left", "multipliers")}
        verilog = (folder / "netlist.v").read_text(encoding="utf-8")
    bits = _per_module(read["memories"], _bits)
    for module, logic in _per_module(read["left"], _bits).items():
        bits[module] -= logic
    return area_tree(netlist, top, bits, _per_module(read["multipliers"], _elements)), verilog


def _best(netlists: list[Json]) -> Json:
    """The best of several netlists, module by module: each is refined, the smallest is taken."""
    for netlist in netlists:
        refine(netlist)
    modules = {
        name: min(
            (netlist["modules"][name] for netlist in netlists), key=lambda json: own_area(json).le_packed
        )
        for name in netlists[0]["modules"]
        if name not in PRIMITIVES
    }
    return {**netlists[0], "modules": modules}


_MODULE = re.compile(r"^module \\(\S+)$(.*?)^end$", re.MULTILINE | re.DOTALL)
_CELL = re.compile(r"^  cell .*?^  end$", re.MULTILINE | re.DOTALL)


def _per_module(dump: str, measure: Callable[[str], int]) -> dict[str, int]:
    """Sum of a measure of the cells that were dumped, by module."""
    return {name: sum(map(measure, _CELL.findall(body))) for name, body in _MODULE.findall(dump)}


def _parameter(cell: str, name: str) -> int:
    match = re.search(rf"^    parameter (?:signed )?\\{name} (\d+)$", cell, re.MULTILINE)
    if match is None:
        raise ValueError(f"a cell without parameter {name}: {cell.splitlines()[0].strip()}")
    return int(match[1])


def _bits(cell: str) -> int:
    return _parameter(cell, "WIDTH") * _parameter(cell, "SIZE")


def _elements(cell: str) -> int:
    """9x9 elements of a product: an 18x18 multiplier is two of them."""
    a, b = (_parameter(cell, f"{operand}_WIDTH") for operand in "AB")
    return 1 if max(a, b) <= 9 else 2 * -(-a // 18) * -(-b // 18)
