# amaranth: UnusedElaboratable=no
"""Emitted Verilog, read again."""

from __future__ import annotations

from flow.verilog import END_OF_WAIVERS, convert
from flow.verilog_ports import split_modules
from tests.support.quartus import Forgetful


def test_modules_are_complete() -> None:
    text = convert(Forgetful(), "forgetful", ["A remark."])
    heading, modules = split_modules(text)
    assert list(modules) == ["forgetful"]
    assert heading + modules["forgetful"] + END_OF_WAIVERS == text
