"""The files of rules by which Yosys maps to a device: in ``flow/cyclone4`` and ``flow/ecp5``."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path


def rule_text(device: str, name: str) -> str:
    """One file of rules, such as ``"cyclone4"``, ``"cells.v"``."""
    return (files("flow") / device / name).read_text(encoding="utf-8")


def write_rules(device: str, names: Iterable[str], folder: Path) -> None:
    """Put files of rules into a folder, where Yosys runs."""
    for name in names:
        (folder / name).write_text(rule_text(device, name), encoding="utf-8")
