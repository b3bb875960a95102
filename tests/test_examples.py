"""The examples of the documentation run as they are, and agree with the golden model."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import pytest

from cornerstream import StreamModel

EXAMPLE = Path(__file__).parents[1] / "docs" / "examples" / "corner_counter.py"


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
