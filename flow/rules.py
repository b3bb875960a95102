"""The files of rules by which Yosys maps to a family of devices: each in the family's folder."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.resources import files
from pathlib import Path


def rule_text(family: str, name: str) -> str:
    """One file of rules, such as ``"cells.v"`` of the family ``"cyclone4"``."""
    return (files(f"flow.{family}") / name).read_text(encoding="utf-8")


def write_rules(family: str, names: Iterable[str], folder: Path) -> None:
    """Put files of rules into a folder, where Yosys runs."""
    for name in names:
        (folder / name).write_text(rule_text(family, name), encoding="utf-8")
