"""Mapping to ECP5 with Yosys, for the device itself or as a stand-in for Cyclone IV.

Yosys alone would build long rows out of wide, shallow blocks with multiplexers behind them. Here
block RAM is used as Cyclone IV's M9K would be, and delay lines are in block RAM, as there, however
short they are. Lookup tables are mapped by abc, because abc9, Yosys's own choice, stops with an
internal error on some of these designs.
"""

from __future__ import annotations

import json
import re
from pathlib import Path

from amaranth.back import rtlil
from amaranth.lib import wiring

from flow.ecp5.output_registers import use_output_registers
from flow.netlist import Cell, Json, Module
from flow.rules import write_rules
from flow.yowasp import run_yosys
from sim.rtlil import without_zeros

SCRIPT = """
read_rtlil design.il
synth_ecp5 -top {top} -run begin:map_ram
memory_libmap -lib memory.txt -D WORDS_512 t:$mem_v2 r:WR_PORTS>0 %i r:SIZE>64 %i r:SIZE<=512 %i r:WIDTH>9 %i
memory_libmap -lib memory.txt -D WORDS_1024 t:$mem_v2 r:WR_PORTS>0 %i r:SIZE>64 %i r:SIZE<=1024 %i r:WIDTH>9 %i
memory_libmap -lib memory.txt t:$mem_v2 r:WR_PORTS>0 %i r:SIZE>64 %i
techmap -map memory.v
setattr -set ram_style "block" c:*ring_* t:$mem_v2 %i
synth_ecp5 -top {top} -run map_ram:map_luts
abc -lut 4:7
clean
synth_ecp5 -top {top} -run map_cells:
write_json mapped.json
"""
"""Makes ``mapped.json`` from ``design.il``, in a folder that has the files :data:`RULES`."""
RULES = ("memory.txt", "memory.v")

_COLLISION = re.compile(r"(parameter \\COLLISION_X_MASK \d+')([01]+)")


def map_component(component: wiring.Component, top: str, folder: Path, *, stands_in: bool) -> Json:
    """The netlist of a component, flattened, as module ``top``; Yosys works in ``folder``.

    Parameters
    ----------
    stands_in
        The netlist is for timing in place of Cyclone IV, where a read of a word that is being
        written costs no logic: see :func:`relaxed`.

    Raises
    ------
    ToolNotFoundError, ToolError
        A tool is missing, or failed; the message says what to install, or what went wrong.
    """
    design = without_zeros(rtlil.convert(component, name=top, emit_src=False))
    (folder / "design.il").write_text(relaxed(design) if stands_in else design, encoding="utf-8")
    write_rules("ecp5", RULES, folder)
    run_yosys(SCRIPT.format(top=top), folder)
    netlist: Json = json.loads((folder / "mapped.json").read_text(encoding="utf-8"))
    use_output_registers(Module(netlist["modules"][top], Cell))
    return netlist


def relaxed(design: str) -> str:
    """RTLIL in which a read of a word that is being written may give anything.

    For timing as a stand-in only. Line buffers never read what is being written, and queues only
    when they are empty and the value does not count; delay lines do, and an M9K gives them the old
    value by itself, where ECP5 needs logic.
    """
    return _COLLISION.sub(lambda match: match[1] + "1" * len(match[2]), design)
