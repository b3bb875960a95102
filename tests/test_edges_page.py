# amaranth: UnusedElaboratable=no
"""What docs/reference/edges.md says of ports, latency, events and tests is so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from amaranth.hdl import Shape

from golden.video import Event
from hdl.build import PIXELS_PER_CLOCK, Build
from hdl.detector import Detector
from hdl.edges import Interface, make_core
from hdl.edges.video_detector import VideoDetector

ROOT = Path(__file__).parents[1]
PAGE = (ROOT / "docs" / "reference" / "edges.md").read_text(encoding="utf-8")
PROSE = " ".join(PAGE.split())
"""The page as one line, wherever its lines are broken."""
BENCH = "".join(
    (ROOT / "tests" / "benches" / f"bench_axi_{name}.py").read_text(encoding="utf-8")
    for name in ("malformed", "lanes")
)


def section(title: str) -> str:
    return PAGE.split(f"\n## {title}\n")[1].split("\n## ")[0]


def table(title: str) -> list[list[str]]:
    """Cells of a section's table, without its head."""
    lines = [line for line in section(title).splitlines() if line.startswith("|")][2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_every_malformation_has_a_test_and_its_own_bit() -> None:
    rows = table("Malformed video")
    assert len(rows) > 15
    for what, _, bits, tests in rows:
        for name in re.findall(r"`(\w+)`", tests):
            assert re.search(rf"^async def {name}\(", BENCH, re.MULTILINE), f"{what}: no test {name}"
        for name in re.findall(r"\b[A-Z]+_[A-Z]+\b", bits):
            assert name in Event.__members__
    told = set(re.findall(r"\b[A-Z]+_[A-Z]+\b", section("Malformed video")))
    assert told >= set(Event.__members__)


@pytest.mark.parametrize("buffering", ["lean", "banked"])
def test_latency(buffering: str) -> None:
    detector = VideoDetector(Build.profile("paper", buffering=buffering))
    found = re.search(r"\*\*(\d+)\*\* clocks later with `lean` buffers and \*\*(\d+) \+ 2·width\*\*", PROSE)
    assert found
    lean, banked = (int(number) for number in found.groups())
    for width in (15, 1920):
        told = lean if buffering == "lean" else banked + 2 * width
        assert detector.frame_latency(width) == told
    assert f"{lean} (or {banked} + 2·width) clocks" in PROSE
    assert "three clocks later than that of the [detector alone]" in PROSE
    for lanes in PIXELS_PER_CLOCK[1:]:
        build = Build.profile("paper", buffering=buffering, pixels_per_clock=lanes)
        assert VideoDetector(build).frame_latency(1920) == Detector(build).frame_latency(1920) + 3


@pytest.mark.parametrize(("interface", "title"), [("axi", "AXI"), ("avalon", "Avalon")])
def test_ports(interface: Interface, title: str) -> None:
    """Every port of the core is in the table, with its width, and no other."""
    core = make_core(Build.profile("paper", video_out=interface == "axi"), interface)
    ports = {str(name): Shape.cast(member.shape).width for name, member in core.signature.members.items()}
    told: dict[str, int] = {}
    for names, bits, *_ in table(title):
        if "*" in names:
            continue
        first, *others = re.findall(r"`(\w+)`", names)
        prefix = first.rpartition("_")[0]
        all_names = [first, *(f"{prefix}_{other}" for other in others)]
        told |= dict(zip(all_names, (int(width) for width in bits.split(", ")), strict=True))
    lite = {name for name in ports if name.startswith("s_axil_")}
    assert told == {name: width for name, width in ports.items() if name not in lite}
