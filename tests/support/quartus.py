"""Exported Quartus projects, and a design that depends on what its memory does."""

from __future__ import annotations

import re
from functools import cache
from typing import Any

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from flow.devices import DEFAULT_DEVICE, DEVICES
from flow.quartus import project_files
from hdl.build import Build

SMALL = {"max_width": 40, "max_height": 32}
VARIANTS = [("paper", "banked"), ("paper", "lean"), ("robust", "lean")]


@cache
def exported(name: str, buffering: Any) -> dict[str, str]:
    return project_files(
        Build.profile(name, buffering=buffering, **SMALL), DEVICES[DEFAULT_DEVICE], clock_mhz=125
    )


def sources(files: dict[str, str]) -> dict[str, str]:
    return {name: text for name, text in files.items() if name.endswith(".v")}


def settings(files: dict[str, str]) -> list[tuple[str, str]]:
    """Names and values of the global assignments."""
    found = re.findall(r"^set_global_assignment -name (\w+) (.+)$", files["cornerstream.qsf"], re.MULTILINE)
    return [(name, value.strip('"')) for name, value in found]


class Forgetful(wiring.Component):
    """Reads the very address that it writes: what a memory does then decides what comes out."""

    def __init__(self) -> None:
        super().__init__({"i": In(stream.Signature(8)), "o": Out(stream.Signature(8))})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.line = line = Memory(shape=8, depth=16, init=[])
        write, read = line.write_port(), line.read_port()
        place = Signal(4)
        step = self.i.valid & self.i.ready
        m.d.comb += [
            self.i.ready.eq(~self.o.valid | self.o.ready),
            write.addr.eq(place),
            read.addr.eq(place),
            write.data.eq(self.i.payload),
            write.en.eq(step),
            read.en.eq(step),
            self.o.payload.eq(read.data),
        ]
        with m.If(self.i.ready):
            m.d.sync += self.o.valid.eq(self.i.valid)
        with m.If(step):
            m.d.sync += place.eq(place + 1)
        return m
