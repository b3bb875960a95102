"""README's first table, from the figures of the comparison page.

``python docs/tools/readme_table.py`` writes it into the README.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from evaluation.comparison import paper_tables
from evaluation.comparison.page import FIGURES_NAME
from evaluation.comparison.parts import find, of_size, shown
from evaluation.comparison.variants import LANES_SIZE
from evaluation.presentation.numbers import number

ROOT = Path(__file__).parents[2]
README = ROOT / "README.md"
BUILDS = (
    ("paper", "lean", 1),
    ("paper", "banked", 1),
    ("paper", "lean", 4),
    *(("robust", "lean", lanes) for lanes in (1, 2, 4, 8)),
    ("precise", "lean", 1),
    ("precise", "lean", 4),
)
"""Profile, buffers and pixels per clock of each row; one that was not measured is left out."""
HEADINGS = ["", "pixels per clock", "logic elements", "memory bits", "Fmax in MHz", "Mpixel/s"]


def table(builds: list[dict[str, Any]]) -> str:
    """The table, as Markdown."""
    demand = {resource.name: resource.demand for resource in paper_tables.TABLE_1}
    (speed,) = (each for each in paper_tables.TABLE_3 if (each.width, each.height) == LANES_SIZE)
    theirs = [
        *("the paper", "1", number(demand["Total logic elements"]), number(demand["Total memory bits"])),
        *(f"{paper_tables.CLOCK_MHZ} as run", number(speed.pixels_per_second / 1e6)),
    ]
    chosen = [each for each in of_size(builds, LANES_SIZE) if not each["multiplied"]]
    found = [build for each in BUILDS if (build := find(chosen, *each)) is not None]
    return shown(HEADINGS, [theirs, *map(_row, found)])


def _row(build: dict[str, Any]) -> list[str]:
    lanes, fmax = build["pixels_per_clock"], build["fmax_mhz"]
    return [
        f"profile `{build['profile']}`, `{build['buffering']}` buffers",
        *(str(lanes), number(build["le_packed"]), number(build["memory_bits"])),
        *(number(fmax, 1), number(None if fmax is None else lanes * fmax)),
    ]


def committed() -> list[dict[str, Any]]:
    """Figures of the committed page."""
    path = ROOT / "docs" / "results" / FIGURES_NAME
    builds: list[dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["builds"]
    return builds


def replaced(text: str, new: str) -> str:
    """The text with ``new`` in the place of its first table."""
    lines = text.splitlines()
    start = next(k for k, line in enumerate(lines) if "logic elements" in line and line.startswith("|"))
    end = next(k for k in range(start, len(lines)) if not lines[k].startswith("|"))
    return "\n".join([*lines[:start], *new.splitlines(), *lines[end:]]) + "\n"


if __name__ == "__main__":
    README.write_text(replaced(README.read_text(encoding="utf-8"), table(committed())), encoding="utf-8")
