"""Mapping to ECP5 as a stand-in: its block RAM used as Cyclone IV's M9K would be, for timing only.

Yosys alone would build long rows out of wide, shallow blocks with multiplexers behind them, and put
more of these where a block must give the old value of what is being written. Cyclone IV needs
neither. Delay lines are in block RAM, as there, however short they are. And tables are mapped by
abc, because abc9, Yosys's own choice, stops with an internal error on some of these designs.
"""

from __future__ import annotations

import re

from sim.rtlil import without_zeros

SCRIPT = """
read_rtlil design.il
synth_ecp5 -top {top} -run begin:map_ram
memory_libmap -lib memory.txt t:$mem_v2 r:WR_PORTS>0 %i r:SIZE>64 %i
techmap -map memory.v
setattr -set ram_style "block" c:*ring_* t:$mem_v2 %i
synth_ecp5 -top {top} -run map_ram:map_luts
abc -lut 4:7
clean
synth_ecp5 -top {top} -run map_cells:
write_json mapped.json
"""
"""From ``design.il`` to ``mapped.json``, with the files :data:`RULES` beside."""
RULES = ("memory.txt", "memory.v")

_COLLISION = re.compile(r"(parameter \\COLLISION_X_MASK \d+')([01]+)")


def relaxed(design: str) -> str:
    """RTLIL in which memories start with anything, and a read of what is being written may give
    anything.

    For timing only. Line buffers never read what is being written, and queues only when they are
    empty and the value does not count; delay lines do, and an M9K gives them the old value by
    itself.
    """
    return _COLLISION.sub(lambda match: match[1] + "1" * len(match[2]), without_zeros(design))
