"""What the README states as fact is recomputed here."""

from __future__ import annotations

import re
import runpy
from pathlib import Path

import pytest

from cornerstream.cli import main
from golden import Parameters, Settings, detect
from golden.algorithm import DEFAULT_PROFILE
from hdl.build import Build
from hdl.edges import make_core
from tests.support.photographs import photograph
from tests.support.runner import CliRunner

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TABLE = runpy.run_path(str(ROOT / "docs" / "tools" / "readme_table.py"))


def test_first_table_is_that_of_the_comparison_page() -> None:
    """Figures as committed, or: run ``python docs/tools/readme_table.py``."""
    assert TABLE["table"](TABLE["committed"]()) in README


def test_first_table() -> None:
    """The paper's figures; pixels per second are pixels per clock times the clock."""
    build = {
        **{"profile": "robust", "buffering": "lean", "width": 1200, "height": 720, "multiplied": 0},
        **{"pixels_per_clock": 4, "le_packed": 1234, "memory_bits": 5678, "fmax_mhz": 150.3},
    }
    lines = TABLE["table"]([build, {**build, "width": 512}, {**build, "multiplied": 6}]).splitlines()
    assert lines[2:] == [
        "| the paper | 1 | 6,507 | 803,104 | 100 as run | 91 |",
        "| profile `robust`, `lean` buffers | 4 | 1,234 | 5,678 | 150.3 | 601 |",
    ]
    new = TABLE["replaced"](README, "| new |")
    assert new.count("| new |") == 1 and "the paper |" not in new and new.endswith(README[-500:])


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
