"""The devices of ECP5 without transceivers: names, part numbers and what they hold."""

from __future__ import annotations

from flow.device import Device, MemoryBlock

EBR = MemoryBlock("EBR", 18_432)
PACKAGES = {
    "BG256": "CABGA256",
    "BG381": "CABGA381",
    "BG554": "CABGA554",
    "BG756": "CABGA756",
    "MG285": "CSFBGA285",
    "TG144": "TQFP144",
}
"""Packages in part numbers, and what nextpnr calls them."""
_ORDER = rf"-(?P<speed>[6-8])(?P<package>{'|'.join(PACKAGES)})[CI]"
_SOURCE = (
    "ECP5 and ECP5-5G Family Data Sheet (FPGA-DS-02012), Table 1.1; lookup tables as nextpnr counts them"
)


def _device(name: str, suffix: str, elements: int, blocks: int, multipliers: int) -> Device:
    return Device(
        name=name.lower(),
        part=name + suffix,
        order=_ORDER,
        family="ECP5",
        logic=("LUT4", "FF"),
        logic_elements=elements,
        memory=EBR,
        memory_blocks=blocks,
        multipliers=multipliers,
        tool="nextpnr",
        source=_SOURCE,
    )


# name, speed grade and package unless told otherwise, lookup tables, EBRs, 18x18 multipliers
DEVICES = (
    _device("LFE5U-25F", "-6BG381C", 24_288, 56, 28),
    _device("LFE5U-45F", "-6BG381C", 43_848, 108, 72),
    _device("LFE5U-85F", "-6BG381C", 83_640, 208, 156),
)
