"""The examples of the documentation run as they are, and agree with the golden model."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import pytest

from cornerstream import StreamModel

EXAMPLES = Path(__file__).parents[1] / "docs" / "examples"
EXAMPLE = EXAMPLES / "corner_counter.py"
WIDE = EXAMPLES / "wide_video.py"


def test_counter_counts_what_the_golden_model_counts(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE)])
    example = runpy.run_path(str(EXAMPLE), run_name="__main__")
    model = StreamModel(example["BUILD"])
    found = [len(model.process(image, example["SETTINGS"]).corners) for image in example["frames"](3)]
    # four corners to each square
    assert found == [4, 8, 12]
    assert capsys.readouterr().out.splitlines() == [f"frame {k}: {n} corners" for k, n in enumerate(found)]


def test_counter_as_verilog(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "counter.v"
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE), str(target)])
    runpy.run_path(str(EXAMPLE), run_name="__main__")
    (ports,) = re.findall(r"^module corner_counter\((.*?)\);", target.read_text(), re.MULTILINE)
    assert set(ports.split(", ")) == {
        *("clk", "rst", "count", "done"),
        *(f"pixels__{name}" for name in ("payload", "valid", "ready")),
    }


def test_strongest_corner_is_that_of_the_golden_model(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", [str(WIDE)])
    example = runpy.run_path(str(WIDE), run_name="__main__")
    assert example["WIDTH"] % example["LANES"]
    model, lines = StreamModel(example["BUILD"]), []
    for number, image in enumerate(example["frames"](3)):
        corners = model.process(image, example["SETTINGS"]).corners
        k = corners.response.argmax()
        place = f"({corners.x[k]:.2f}, {corners.y[k]:.2f})"
        lines.append(f"frame {number}: corner at {place}, response {corners.response[k]}")
    assert len(set(lines)) == 3
    assert capsys.readouterr().out.splitlines() == lines


def test_strongest_corner_as_verilog(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    target = tmp_path / "strongest.v"
    monkeypatch.setattr(sys, "argv", [str(WIDE), str(target)])
    runpy.run_path(str(WIDE), run_name="__main__")
    assert re.search(r"^ *input \[31:0\] beats__payload;", target.read_text(), re.MULTILINE)
