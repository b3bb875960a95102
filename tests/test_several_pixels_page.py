# amaranth: UnusedElaboratable=no
"""What the page on several pixels per clock states as fact is recomputed here."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from hdl.build import PIXELS_PER_CLOCK, Build
from hdl.edges.axi import AxiCore
from sim.beats import beat_count

PAGE = (Path(__file__).parents[1] / "docs" / "howto" / "several-pixels.md").read_text(encoding="utf-8")
SEVERAL = PIXELS_PER_CLOCK[1:]


def cells(first: str) -> list[str]:
    """The other cells of the one row that begins with this cell."""
    (line,) = (line for line in PAGE.splitlines() if line.startswith(f"| {first} |"))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


def videos() -> list[Any]:
    """Width, height, frames per second, and the cells of each video."""
    found = re.findall(r"^\| (\d+)×(\d+), (\d+) frames/s \| (.*) \|$", PAGE, re.MULTILINE)
    assert len(found) == 5
    return [pytest.param(*map(int, size), row.split(" | "), id="x".join(size)) for *size, row in found]


@pytest.mark.parametrize(("width", "height", "rate", "row"), videos())
def test_clocks_of_videos(width: int, height: int, rate: int, row: list[str]) -> None:
    """The total sizes are those of CTA-861."""
    pixels, blanked, lanes, clock = row
    total = {1080: (2200, 1125), 2160: (4400, 2250), 4320: (8800, 4500)}[height]
    whole = total[0] * total[1] * rate / 1e6
    assert pixels == f"{width * height * rate / 1e6:.0f} million"
    assert blanked == f"{whole:g} MHz"
    assert int(lanes) in PIXELS_PER_CLOCK and clock == f"{whole / int(lanes):g} MHz"


def test_beats_without_blanking() -> None:
    beats = beat_count((2160, 3840), Build(max_width=3840, max_height=2160, pixels_per_clock=4))
    assert f"{beats * 60 / 1e6:.1f} million beats per second" in " ".join(PAGE.split())


@pytest.mark.parametrize("bits", [8, 10])
def test_width_of_tdata(bits: int) -> None:
    ports = [AxiCore(Build(pixel_bits=bits, pixels_per_clock=lanes)).s_axis_tdata for lanes in SEVERAL]
    assert cells(f"bits of TDATA, {bits}-bit pixels") == [str(len(port)) for port in ports]


@pytest.mark.parametrize(
    ("profile", "named"),
    [("robust", "`robust`"), *((name, "`paper` and `precise`") for name in ("paper", "precise"))],
)
def test_narrowest_frames(profile: str, named: str) -> None:
    widths = [Build.profile(profile, pixels_per_clock=lanes).min_width for lanes in SEVERAL]
    assert cells(f"narrowest frame, {named}") == [str(width) for width in widths]


def test_a_line_in_beats() -> None:
    width, lanes = 10, 4
    assert f"A line of {width} pixels with P = {lanes}:" in PAGE
    for beat, columns in enumerate(np.array_split(np.arange(width), range(lanes, width, lanes))):
        told = [f"pixel {column}" for column in columns] + [""] * (lanes - len(columns))
        keep, last = f"{(1 << len(columns)) - 1:0{lanes}b}", columns[-1] == width - 1
        assert cells(str(beat)) == [*told, keep, str(int(last))]
