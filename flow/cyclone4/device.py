"""The devices of Cyclone IV: names, part numbers and what they hold."""

from __future__ import annotations

from flow.device import Device, MemoryBlock

M9K = MemoryBlock("M9K", 9216)
_STAND_IN = "lfe5u-45f"
_SOURCE = "Cyclone IV Device Handbook, volume 1, chapter 1, Tables 1-1 and 1-2"
_E = r"(?P<package>[EFMU]\d\d)[CIA](?P<speed>[6-9]L?)"
_GX = r"(?P<package>[BCD][FN]\d\d)[CI](?P<speed>[6-8])"


def _device(
    family: str, order: str, name: str, suffix: str, elements: int, blocks: int, multipliers: int
) -> Device:
    return Device(
        name=name.lower(),
        part=name + suffix,
        order=order,
        family=family,
        logic=("LE",),
        logic_elements=elements,
        memory=M9K,
        memory_blocks=blocks,
        multipliers=multipliers,
        tool="quartus",
        stand_in=_STAND_IN,
        source=_SOURCE,
    )


# name, package and speed grade unless told otherwise, logic elements, M9Ks, 18x18 multipliers
DEVICES = (
    _device("Cyclone IV E", _E, "EP4CE6", "E22C8", 6_272, 30, 15),
    _device("Cyclone IV E", _E, "EP4CE10", "F17C8", 10_320, 46, 23),
    _device("Cyclone IV E", _E, "EP4CE15", "F23C8", 15_408, 56, 56),
    _device("Cyclone IV E", _E, "EP4CE22", "F17C6", 22_320, 66, 66),
    _device("Cyclone IV E", _E, "EP4CE30", "F23C8", 28_848, 66, 66),
    _device("Cyclone IV E", _E, "EP4CE40", "F23C8", 39_600, 126, 116),
    _device("Cyclone IV E", _E, "EP4CE55", "F23C8", 55_856, 260, 154),
    _device("Cyclone IV E", _E, "EP4CE75", "F23C8", 75_408, 305, 200),
    _device("Cyclone IV E", _E, "EP4CE115", "F29C7", 114_480, 432, 266),
    _device("Cyclone IV GX", _GX, "EP4CGX15", "BF14C8", 14_400, 60, 0),
    _device("Cyclone IV GX", _GX, "EP4CGX22", "CF19C8", 21_280, 84, 40),
    _device("Cyclone IV GX", _GX, "EP4CGX30", "CF23C8", 29_440, 120, 80),
    _device("Cyclone IV GX", _GX, "EP4CGX50", "CF23C8", 49_888, 278, 140),
    _device("Cyclone IV GX", _GX, "EP4CGX75", "CF23C8", 73_920, 462, 198),
    _device("Cyclone IV GX", _GX, "EP4CGX110", "CF23C8", 109_424, 610, 280),
    _device("Cyclone IV GX", _GX, "EP4CGX150", "CF23C8", 149_760, 720, 360),
)
