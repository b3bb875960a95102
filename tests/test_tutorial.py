"""The tutorial's steps give what the tutorial shows."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image

from cornerstream import Build, Corners, Parameters, Settings, StreamModel, detect
from cornerstream.cli import main
from tests.support.runner import CliRunner

TUTORIAL = (Path(__file__).parents[1] / "docs" / "tutorial.md").read_text(encoding="utf-8")


def blocks(language: str) -> list[str]:
    found = re.findall(r"^```(\w*)\n(.*?)^```$", TUTORIAL, re.MULTILINE | re.DOTALL)
    return [text for name, text in found if name == language]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with the picture that the tutorial makes."""
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks("python")[0], "tutorial.md", "exec"), {})
    return tmp_path


def test_golden_model(folder: Path) -> None:
    (command,) = (line for block in blocks("sh") for line in block.splitlines() if " detect " in line)
    result = CliRunner().invoke(main, command.split()[1:])
    assert result.exit_code == 0
    table, corners, _frames = blocks("")
    assert result.stdout == table
    assert (folder / "square" / "corners.csv").read_text(encoding="utf-8") == corners


def test_hardware(folder: Path) -> None:
    """The shown lines are the golden model's; other tests show that the hardware equals it."""
    model = StreamModel(Build(max_width=64, max_height=48))
    image = np.asarray(Image.open("square.png"))
    for frame in range(2):
        corners = model.process(image, Settings(report_rejected=True)).corners
        accepted = int(corners.accepted.sum())
        counts = f"{accepted:>7} │ {len(corners) - accepted:>8} │ {0:>10} │"
        assert f"│ robust  │ {frame:>5} │ 64x48 │ {image.size:>6,} │        1.000 │ {counts}" in blocks("")[2]


def inside_the_rectangle(corners: Corners) -> NDArray[np.float64]:
    """How far the corners lie inside the nearest edges, in x and in y."""
    across, down = corners.x, corners.y
    return np.concatenate([np.minimum(across - 19.5, 43.5 - across), np.minimum(down - 11.5, 35.5 - down)])


def test_corners_are_where_the_text_says(folder: Path) -> None:
    image = np.asarray(Image.open("square.png"))
    told = re.search(r"about ([\d.]+) pixels inside", TUTORIAL)
    measured = re.search(r"where their edges meet, within ([\d.]+) pixel", TUTORIAL)
    assert told and measured
    found, stepped = detect(image), detect(image, Parameters.profile("precise"))
    assert len(found) == len(stepped) == 4
    assert inside_the_rectangle(found) == pytest.approx([float(told[1])] * 8, abs=0.05)
    assert np.abs(inside_the_rectangle(stepped)).max() < float(measured[1])


def test_python(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(blocks("python")[1], "tutorial.md", "exec"), {})
    assert capsys.readouterr().out.splitlines()[0] == "20.56 12.56"
