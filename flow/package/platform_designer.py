"""The ports of a core as interfaces of Intel's Platform Designer.

Kinds, roles and properties are those of the Avalon interface specifications and of the Component
Interface Tcl Reference. Which ports there are, and how wide they are, is read from the Verilog
itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

from flow.verilog_ports import Port
from hdl.edges import Interface

_DATA, _EMPTY = "data", "empty"


@dataclass(frozen=True)
class HwInterface:
    """One interface of a component.

    Parameters
    ----------
    name, kind, direction
        Arguments of ``add_interface``.
    prefix
        Ports that begin with it belong to the interface; the rest of a port's name is its role.
    roles
        Roles of ports whose names do not contain them.
    properties
        Arguments of ``set_interface_property``.
    ports
        The ports, each with its role.
    """

    name: str
    kind: str
    direction: str
    prefix: str
    roles: dict[str, str] = field(default_factory=dict)
    properties: dict[str, str | int] = field(default_factory=dict)
    ports: tuple[tuple[Port, str], ...] = ()

    def role(self, port: Port) -> str:
        return self.roles.get(port.name) or port.name.removeprefix(self.prefix)


_SYNCHRONOUS: dict[str, str | int] = {"associatedClock": "clock", "associatedReset": "reset"}
_CLOCK = HwInterface("clock", "clock", "end", "clk", {"clk": "clk"})
_RESET = HwInterface(
    "reset",
    "reset",
    "end",
    "rst",
    {"rst": "reset"},
    # the reset is a synchronous one
    {"associatedClock": "clock", "synchronousEdges": "BOTH"},
)
_INTERRUPT = HwInterface(
    *("interrupt", "interrupt", "end", "ins_irq_"),
    {"irq": "irq"},
    {"associatedAddressablePoint": "registers", **_SYNCHRONOUS},
)
# One symbol is a whole pixel or record. With several symbols per beat a signal says how many of
# them are empty in a packet's last beat.
_PACKETS: dict[str, str | int] = {**_SYNCHRONOUS, "readyLatency": 0, "maxChannel": 0}
# One read per clock, answered two clocks later; accesses wait in reset only.
_MEMORY_MAPPED: dict[str, str | int] = {
    **_SYNCHRONOUS,
    "addressUnits": "WORDS",
    "bitsPerSymbol": 8,
    "maximumPendingReadTransactions": 2,
    "readLatency": 0,
    "readWaitTime": 0,
    "writeWaitTime": 0,
    "setupTime": 0,
    "holdTime": 0,
    "timingUnits": "Cycles",
}
_INTERFACES: dict[Interface, tuple[HwInterface, ...]] = {
    "avalon": (
        _CLOCK,
        _RESET,
        HwInterface("video", "avalon_streaming", "end", "asi_video_", properties=_PACKETS),
        HwInterface("records", "avalon_streaming", "start", "aso_records_", properties=_PACKETS),
        HwInterface("registers", "avalon", "end", "avs_registers_", properties=_MEMORY_MAPPED),
        _INTERRUPT,
    ),
    "axi": (
        _CLOCK,
        _RESET,
        HwInterface("video", "axi4stream", "end", "s_axis_", properties=_SYNCHRONOUS),
        HwInterface("records", "axi4stream", "start", "m_axis_", properties=_SYNCHRONOUS),
        HwInterface("video_out", "axi4stream", "start", "m_axis_video_", properties=_SYNCHRONOUS),
        HwInterface("registers", "axi4lite", "end", "s_axil_", properties=_SYNCHRONOUS),
        replace(_INTERRUPT, prefix="irq"),
    ),
}


def hw_interfaces(interface: Interface, ports: Sequence[Port]) -> list[HwInterface]:
    """The interfaces of a core with such edges, each with its ports; empty ones are left out.

    ``ValueError`` if a port belongs to none.
    """
    known = _INTERFACES[interface]
    found: dict[str, list[tuple[Port, str]]] = {}
    for port in ports:
        homes = [each for each in known if port.name.startswith(each.prefix)]
        if not homes:
            raise ValueError(f"port is {port.name!r}; allowed: {', '.join(each.prefix for each in known)}")
        home = max(homes, key=lambda each: len(each.prefix))
        found.setdefault(home.name, []).append((port, home.role(port)))
    return [
        replace(each, ports=tuple(found[each.name]), properties=_with_symbols(each, found[each.name]))
        for each in known
        if each.name in found
    ]


def _with_symbols(interface: HwInterface, ports: list[tuple[Port, str]]) -> dict[str, str | int]:
    if interface.kind != "avalon_streaming":
        return interface.properties
    widths = {role: port.width for port, role in ports}
    if _EMPTY not in widths:
        return {**interface.properties, "dataBitsPerSymbol": widths[_DATA]}
    symbols = 1 << widths[_EMPTY]
    return {
        **interface.properties,
        "dataBitsPerSymbol": widths[_DATA] // symbols,
        "symbolsPerBeat": symbols,
        "firstSymbolInHighOrderBits": "true",
    }
