"""The tutorial's steps give what the tutorial shows."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from cornerstream import Build, Settings, StreamModel
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


def test_corners_are_where_the_text_says() -> None:
    told = re.search(r"found, within ([\d.]+) pixel", TUTORIAL)
    assert told
    rows = [line.split(",") for line in blocks("")[1].splitlines()[1:]]
    off = [
        abs(float(value) - edge)
        for x, y, *_ in rows
        for value, edge in zip(
            (x, y), (19.5 if float(x) < 32 else 43.5, 11.5 if float(y) < 24 else 35.5), strict=True
        )
    ]
    assert len(rows) == 4 and max(off) < float(told[1])


def test_python(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    exec(compile(blocks("python")[1], "tutorial.md", "exec"), {})
    assert capsys.readouterr().out.splitlines()[0] == "19.55 11.55"
