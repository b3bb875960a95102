"""All devices that ``--device`` takes."""

from __future__ import annotations

from collections.abc import Collection
from typing import get_args

from flow.cyclone4 import device as cyclone4
from flow.device import Device, Tool
from flow.ecp5 import device as ecp5

DEVICES: dict[str, Device] = {
    device.name: device
    for family in (
        cyclone4.DEVICES,
        ecp5.DEVICES,
    )
    for device in family
}
"""All devices by name."""
DEFAULT_DEVICE = "ep4cgx150"
"""The paper's device."""
_TOOLS: tuple[Tool, ...] = get_args(Tool)


def device_names(tools: Collection[Tool] = _TOOLS) -> list[str]:
    """Names of the devices that these tools know."""
    return [device.name for device in DEVICES.values() if device.tool in tools]


def find_device(text: str, tools: Collection[Tool] = _TOOLS) -> Device:
    """The device with a name, such as ``ep4ce22``, or a part number, such as ``EP4CE22F17C6``.

    Small and capital letters are the same.

    Raises
    ------
    ValueError
        None of the tools knows such a device.
    """
    names = device_names(tools)
    for device in map(DEVICES.__getitem__, names):
        found = device if text.lower() == device.name else device.with_part(text)
        if found is not None:
            return found
    example = DEVICES[names[0]].part
    raise ValueError(
        f"device is {text!r}; allowed: {', '.join(names)}, or a part number of one of these, such as {example}"
    )


def placed_device(device: Device) -> Device:
    """The device that nextpnr places and routes for this one: itself or its stand-in."""
    return device if device.stand_in is None else DEVICES[device.stand_in]
