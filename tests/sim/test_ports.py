"""Ports found in signatures, and what no engine takes."""

from __future__ import annotations

from typing import Any

import pytest
from amaranth.hdl import Module, unsigned
from amaranth.lib import data, enum, stream, wiring
from amaranth.lib.wiring import In, Out

from sim import make_engine
from sim.ports import LevelPort, StreamPort, discover


class Mode(enum.Enum, shape=2):  # type: ignore[call-arg]
    """A shape that is no plain number."""

    OFF = 0
    ON = 3


class Anything(wiring.Component):
    """Whatever signature it is given; never elaborated."""

    _MustUse__silence = True

    def elaborate(self, platform: Any) -> Module:
        return Module()


def test_all_kinds_of_ports() -> None:
    pair = data.StructLayout({"a": 40, "b": 40})
    component = Anything(
        {
            "mode": In(Mode, init=Mode.ON),
            "first": In(stream.Signature(unsigned(8))),
            "o": Out(stream.Signature(pair, always_ready=True)),
            "level": In(range(100), init=7),
            "status": Out(4),
            "second": In(stream.Signature(data.StructLayout({"x": 1}))),
            "offset": In(8, init=200),
        }
    )
    ports = discover(component)
    assert ports.inputs == (StreamPort("first", 8, True), StreamPort("second", 1, True))
    assert ports.outputs == (StreamPort("o", 80, False),)
    assert ports.levels == (LevelPort("mode", 2, 3), LevelPort("level", 7, 7), LevelPort("offset", 8, 200))
    assert [port.words for port in (*ports.inputs, *ports.outputs)] == [1, 1, 2]


@pytest.mark.parametrize(
    ("members", "message"),
    [
        ({"i": In(stream.Signature(8)).array(2)}, "member i is an array"),
        ({"i": In(stream.Signature(8, always_valid=True))}, "member i is always valid"),
        ({"i": In(wiring.Signature({"a": In(1)}))}, "member i is an interface, but no stream"),
        ({"i": In(65)}, "input i is 65 bits wide; allowed: up to 64"),
    ],
)
def test_ports_no_engine_takes(members: dict[str, wiring.Member], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        make_engine("amaranth", Anything(members))


def test_unknown_engine() -> None:
    with pytest.raises(ValueError, match="engine is 'gem5'; allowed: compiled, amaranth, verilog"):
        make_engine("gem5", Anything({}))  # type: ignore[arg-type]


def test_the_verilog_engine_needs_verilog() -> None:
    with pytest.raises(ValueError, match="needs the file with the emitted Verilog"):
        make_engine("verilog", Anything({}))
