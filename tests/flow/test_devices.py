"""Devices by name and part number, and what they hold."""

from __future__ import annotations

import pytest

from flow.devices import DEFAULT_DEVICE, DEVICES, find_device, placed_device


def test_the_default_is_the_papers_device() -> None:
    device = find_device(DEFAULT_DEVICE)
    assert str(device) == "EP4CGX150CF23C8 (Cyclone IV GX)"
    # Tables 1 and 2 of the paper print both capacities
    assert (device.logic_elements, device.memory_bits) == (149_760, 6_635_520)
    assert (device.package, device.speed_grade) == ("CF23", "8")


def test_a_part_number_says_package_and_speed() -> None:
    device = find_device("ep4ce115F23i8L")
    assert (device.name, device.part, device.family) == ("ep4ce115", "EP4CE115F23I8L", "Cyclone IV E")
    assert (device.package, device.speed_grade) == ("F23", "8L")
    assert find_device("LFE5U-85F-8BG756C").package == "BG756"


@pytest.mark.parametrize("name", DEVICES)
def test_every_device_is_found_by_name_and_by_part(name: str) -> None:
    device = DEVICES[name]
    assert find_device(name.upper()) == find_device(device.part) == device
    assert device.package and device.speed_grade
    assert placed_device(device).tool == "nextpnr"


@pytest.mark.parametrize("text", ["", "ep4ce", "EP4CE22F17", "EP4CE22F17C6X", "EP4CGX150F23C8", "arria"])
def test_other_devices_are_refused(text: str) -> None:
    with pytest.raises(ValueError, match=rf"^device is '{text}'; allowed: ep4ce6, .*, such as EP4CE6E22C8$"):
        find_device(text)


def test_only_what_a_tool_knows_is_taken() -> None:
    with pytest.raises(ValueError, match=r"device is 'lfe5u-45f'; allowed: ep4ce6, .*ep4cgx150, or a part"):
        find_device("lfe5u-45f", ("quartus",))


def test_use_says_what_fits() -> None:
    logic, memory = find_device("ep4ce22").use({"LE": 11_160, "M9K": 67})
    assert (str(logic), logic.fits) == ("11,160 of 22,320 LE (50.0 %)", True)
    assert (str(memory), memory.fits) == ("67 of 66 M9K (101.5 %)", False)
    (none,) = find_device("ep4cgx15").use({"9x9 mult.": 0})
    assert (str(none), none.fits) == ("0 of 0 9x9 mult.", True)
