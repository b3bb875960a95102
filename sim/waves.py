"""GTKWave save files: what is worth looking at, the streams' handshakes first."""

from __future__ import annotations

from pathlib import Path

from vcd.gtkw import GTKWSave

from sim.ports import Ports


def save_path(vcd: Path) -> Path:
    """The save file that belongs to a VCD file."""
    return vcd.with_suffix(".gtkw")


def write_save_file(vcd: Path, ports: Ports, scope: str, clock: str | None) -> None:
    """Write a save file that shows each stream as a group, then the plain inputs.

    Parameters
    ----------
    vcd
        Waveform file that exists.
    scope
        Dotted path in the VCD under which the ports are found.
    clock
        Name of the clock there, None if there is none.
    """

    def trace(save: GTKWSave, name: str, width: int) -> None:
        if width > 0:
            save.trace(f"{scope}.{name}" + (f"[{width - 1}:0]" if width > 1 else ""))

    with save_path(vcd).open("w", encoding="utf-8") as file:
        save = GTKWSave(file)
        save.dumpfile(str(vcd.resolve()))
        save.dumpfile_size(vcd.stat().st_size)
        save.treeopen(f"{scope}.")
        if clock is not None:
            trace(save, clock, 1)
        for port in (*ports.inputs, *ports.outputs):
            with save.group(port.name):
                trace(save, port.flat("valid"), 1)
                if port.has_ready:
                    trace(save, port.flat("ready"), 1)
                trace(save, port.flat("payload"), port.width)
        for level in ports.levels:
            trace(save, level.name, level.width)
