"""What the README states as fact is recomputed here."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from cornerstream.cli import main
from evaluation.comparison import paper_tables
from evaluation.comparison.page import FIGURES_NAME
from golden import Parameters, Settings, detect
from golden.algorithm import DEFAULT_PROFILE
from hdl.build import Build
from hdl.edges import make_core
from tests.support.photographs import photograph
from tests.support.runner import CliRunner

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def row(first_cell: str) -> list[str]:
    """Cells of the one table row that begins with this cell, without it."""
    (line,) = (line for line in README.splitlines() if line.startswith(f"| {first_cell} |"))
    return [cell.strip() for cell in line.strip("|").split("|")][1:]


@pytest.mark.parametrize(
    ("profile", "buffering"),
    [("paper", "lean"), ("paper", "banked"), ("robust", "lean"), ("precise", "lean")],
)
def test_synthesis_figures(profile: str, buffering: str) -> None:
    """Area and clock of the paper's size are those that are committed with the comparison page."""
    wanted = {"profile": profile, "buffering": buffering, "width": 1200, "height": 720}
    wanted["pixels_per_clock"] = 1
    path = ROOT / "docs" / "results" / FIGURES_NAME
    builds = json.loads(path.read_text(encoding="utf-8"))["builds"]
    (build,) = (each for each in builds if wanted.items() <= each.items())
    assert row(f"profile `{profile}`, `{buffering}` buffers") == [
        f"{build['le_packed']:,}",
        f"{build['memory_bits']:,}",
        f"{build['fmax_mhz']:.1f}",
    ]


def test_figures_of_the_paper() -> None:
    demand = {resource.name: resource.demand for resource in paper_tables.TABLE_1}
    assert row("the paper") == [
        f"{demand['Total logic elements']:,}",
        f"{demand['Total memory bits']:,}",
        f"{paper_tables.CLOCK_MHZ} as run",
    ]
    assert demand["Embedded multiplier elements"] == 0


def test_default_profile() -> None:
    assert f"`{DEFAULT_PROFILE}` is the default profile" in README


@pytest.mark.parametrize("profile", ["robust", "paper"])
def test_corner_counts_of_the_example(profile: str) -> None:
    """Both frames of the photograph: the first has a constant reference."""
    for number, reference in enumerate(("constant", "previous")):
        settings = Settings(reference=reference, report_rejected=True)
        found = detect(photograph("camera"), Parameters.profile(profile), settings)
        accepted, rejected = int(found.accepted.sum()), int((~found.accepted).sum())
        line = rf"│ {profile} +│ +{number} │ 512x512 │ 262,144 │ +1\.000 │ +{accepted} │ +{rejected} │ +0 │"
        assert re.search(line, README), line


def test_python_example_runs() -> None:
    example = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert example
    exec(compile(example[1], "README.md", "exec"), {})


def test_commands_are_told_with_examples() -> None:
    """The table has every command that there is, and each shows examples."""
    told = re.findall(r"^\| `cornerstream ([a-z]+(?: [a-z]+)?)", README, re.MULTILINE)
    for command in told:
        result = CliRunner().invoke(main, [*command.split(), "--help"])
        assert result.exit_code == 0 and "Examples" in result.output
    assert {command.split()[0] for command in told} == set(main.commands)


def test_the_axi_ports_are_told() -> None:
    ports = make_core(Build.profile("paper", video_out=True), "axi").signature.members
    for name in ports:
        assert any(str(name).startswith(told) for told in re.findall(r"`([a-z_]+?)\*?`", README)), name
