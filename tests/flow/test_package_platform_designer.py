"""The component for Platform Designer, as far as it can be checked without it."""

from __future__ import annotations

import shlex
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from amaranth.hdl import Fragment

from flow.package import PackageInterface, package_files
from flow.package.platform_designer import hw_interfaces
from flow.verilog_ports import Port
from hdl.build import Build
from hdl.edges import make_core
from sim.ports import signals

SMALL = {"max_width": 40, "max_height": 32}
VARIANTS: list[tuple[PackageInterface, dict[str, Any]]] = [
    ("axi", {}),
    ("axi", {"video_out": True, "pixel_bits": 10}),
    ("axi", {"video_out": True, "pixels_per_clock": 4, "buffering": "lean"}),
    ("avalon", {}),
    ("avalon", {"pixel_bits": 10}),
    ("avalon", {"pixel_bits": 10, "pixels_per_clock": 2, "buffering": "lean"}),
]
COMMANDS = (
    *("package", "set_module_property", "add_fileset", "set_fileset_property", "add_fileset_file"),
    *("add_interface", "set_interface_property", "add_interface_port"),
)
Calls = list[tuple[str, ...]]
# Roles of each interface, all of them required here
LITE = {
    *(
        "awaddr",
        "awprot",
        "awvalid",
        "awready",
        "wdata",
        "wstrb",
        "wvalid",
        "wready",
        "bresp",
        "bvalid",
        "bready",
    ),
    *("araddr", "arprot", "arvalid", "arready", "rdata", "rresp", "rvalid", "rready"),
}
PACKETS = {"data", "valid", "ready", "startofpacket", "endofpacket"}
STREAM = {"tdata", "tvalid", "tready", "tlast"}
MEMORY_MAPPED = {
    *("address", "read", "readdata", "readdatavalid", "write", "writedata", "byteenable"),
    "waitrequest",
}
ROLES: dict[PackageInterface, dict[tuple[str, str, str], set[str]]] = {
    "axi": {
        ("clock", "clock", "end"): {"clk"},
        ("reset", "reset", "end"): {"reset"},
        ("video", "axi4stream", "end"): STREAM | {"tuser"},
        ("records", "axi4stream", "start"): STREAM,
        ("video_out", "axi4stream", "start"): STREAM | {"tuser"},
        ("registers", "axi4lite", "end"): LITE,
        ("interrupt", "interrupt", "end"): {"irq"},
    },
    "avalon": {
        ("clock", "clock", "end"): {"clk"},
        ("reset", "reset", "end"): {"reset"},
        ("video", "avalon_streaming", "end"): PACKETS,
        ("records", "avalon_streaming", "start"): PACKETS,
        ("registers", "avalon", "end"): MEMORY_MAPPED,
        ("interrupt", "interrupt", "end"): {"irq"},
    },
}


@cache
def _package(interface: PackageInterface, changes: tuple[tuple[str, Any], ...]) -> dict[str, str]:
    return package_files(Build.profile("paper", **SMALL, **dict(changes)), interface)


def package(interface: PackageInterface, changes: dict[str, Any]) -> dict[str, str]:
    return _package(interface, tuple(changes.items()))


def commands(text: str) -> Calls:
    """The script's commands, one per line, as Tcl would read them: it substitutes nothing."""
    lines = [line for line in text.splitlines() if line and not line.startswith("#")]
    assert not any(character in line for line in lines for character in "$[]{};\\")
    return [tuple(shlex.split(line)) for line in lines]


@pytest.mark.parametrize(("interface", "changes"), VARIANTS)
def test_tcl_reads_the_script_alike(interface: PackageInterface, changes: Any, tmp_path: Path) -> None:
    interpreter = pytest.importorskip("tkinter").Tcl()
    calls: Calls = []
    for name in COMMANDS:
        interpreter.createcommand(name, lambda *words, name=name: calls.append((name, *words)))
    text = package(interface, changes)["cornerstream_hw.tcl"]
    path = tmp_path / "cornerstream_hw.tcl"
    path.write_text(text, encoding="utf-8")
    interpreter.call("source", str(path))
    assert calls == commands(text)


@pytest.mark.parametrize(("interface", "changes"), VARIANTS)
def test_every_port_is_attached_once(interface: PackageInterface, changes: Any) -> None:
    files = package(interface, changes)
    calls = commands(files["cornerstream_hw.tcl"])
    assert {call[0] for call in calls} == set(COMMANDS)

    core = make_core(Build.profile("paper", **SMALL, **changes), interface)
    # Amaranth takes a component that is never elaborated for a mistake
    Fragment.get(core, platform=None)
    expected = {(signal.name, len(signal)) for signal in signals(core)} | {("clk", 1), ("rst", 1)}
    directions = {name: str(member.flow) for name, member in core.signature.members.items()}
    attached = [call[1:] for call in calls if call[0] == "add_interface_port"]
    assert len(attached) == len(expected)
    assert {(port, int(width)) for _, port, _, _, width in attached} == expected
    for _, port, _, direction, _ in attached:
        assert direction == {"In": "Input", "Out": "Output"}[directions.get(port, "In")]

    roles: dict[str, list[str]] = {}
    for name, _, role, _, _ in attached:
        roles.setdefault(name, []).append(role)
    wanted = {key: set(value) for key, value in ROLES[interface].items() if key[0] in roles}
    if "pixels_per_clock" in changes:
        for (name, _, _), allowed in wanted.items():
            if name.startswith("video"):
                allowed.add({"axi": "tkeep", "avalon": "empty"}[interface])
    assert ("video_out" in roles) == bool(changes.get("video_out"))
    added = [call[1:] for call in calls if call[0] == "add_interface"]
    assert set(added) == set(wanted) and len(added) == len(wanted) == len(roles)
    for (name, _, _), allowed in wanted.items():
        assert sorted(roles[name]) == sorted(allowed)


@pytest.mark.parametrize(("interface", "changes"), VARIANTS)
def test_interfaces_say_what_they_need(interface: PackageInterface, changes: Any) -> None:
    files = package(interface, changes)
    calls = commands(files["cornerstream_hw.tcl"])
    properties: dict[str, dict[str, str]] = {}
    for _, name, key, value in (call for call in calls if call[0] == "set_interface_property"):
        assert properties.setdefault(name, {}).setdefault(key, value) == value
    kinds = {call[1]: call[2] for call in calls if call[0] == "add_interface"}
    widths = {call[2]: call[5] for call in calls if call[0] == "add_interface_port"}
    for name, kind in kinds.items():
        found = properties.get(name, {})
        if kind != "clock":
            assert found["associatedClock"] == "clock"
        if kind not in ("clock", "reset"):
            assert found["associatedReset"] == "reset"
    # the reset is sampled, and both its edges must keep to the clock
    assert properties["reset"]["synchronousEdges"] == "BOTH"
    assert properties["interrupt"]["associatedAddressablePoint"] == "registers"
    if interface == "avalon":
        symbols = changes.get("pixels_per_clock", 1)
        video = properties["video"]
        assert int(video["dataBitsPerSymbol"]) * symbols == int(widths["asi_video_data"])
        assert video.get("symbolsPerBeat", "1") == str(symbols)
        assert properties["records"]["dataBitsPerSymbol"] == widths["aso_records_data"] == "64"
        assert properties["video"]["readyLatency"] == properties["records"]["readyLatency"] == "0"
        registers = properties["registers"]
        # where waitrequest is not heeded a read takes one clock, not the two that are the default
        assert (registers["readWaitTime"], registers["addressUnits"]) == ("0", "WORDS")
        assert registers["maximumPendingReadTransactions"] == "2"


@pytest.mark.parametrize(("interface", "changes"), VARIANTS)
def test_files_of_the_component_exist(interface: PackageInterface, changes: Any) -> None:
    files = package(interface, changes)
    calls = commands(files["cornerstream_hw.tcl"])
    sets = {call[1]: call[2] for call in calls if call[0] == "add_fileset"}
    assert set(sets.values()) == {"QUARTUS_SYNTH", "SIM_VERILOG"}
    for _, name, key, value in (call for call in calls if call[0] == "set_fileset_property"):
        assert name in sets and (key, value) == ("TOP_LEVEL", "cornerstream")
    for call in (call for call in calls if call[0] == "add_fileset_file"):
        assert call[2:4] == ("VERILOG", "PATH") and call[4] in files


def test_a_port_that_nobody_knows_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"port is 'led'; allowed: clk, rst, asi_video_"):
        hw_interfaces("avalon", [Port("clk", "input", 1), Port("led", "output", 1)])


def test_several_pixels_in_a_beat_are_several_symbols() -> None:
    """With a port that says how many of them a packet's last beat leaves empty."""
    ports = [Port("asi_video_data", "input", 40), Port("asi_video_empty", "input", 2)]
    (video,) = hw_interfaces("avalon", [*ports, Port("asi_video_valid", "input", 1)])
    assert {role for _, role in video.ports} == {"data", "empty", "valid"}
    found = {key: video.properties[key] for key in ("dataBitsPerSymbol", "symbolsPerBeat")}
    assert found == {"dataBitsPerSymbol": 10, "symbolsPerBeat": 4}
    # as Avalon-ST has it where nothing else is said
    assert video.properties["firstSymbolInHighOrderBits"] == "true"
