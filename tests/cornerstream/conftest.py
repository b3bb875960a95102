"""Folder of images for the tests of what commands refuse."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
from PIL import Image


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory with a good image and several bad ones."""
    Image.fromarray(np.random.default_rng(0).integers(0, 256, (24, 32), np.uint8)).save(tmp_path / "good.png")
    Image.new("L", (12, 30)).save(tmp_path / "narrow.png")
    Image.new("L", (30, 12)).save(tmp_path / "low.png")
    Image.new("L", (33, 24)).save(tmp_path / "wide.png")
    Image.new("L", (32, 25)).save(tmp_path / "high.png")
    (tmp_path / "deep.png").write_bytes(b"P6 32 24 65535\n" + bytes(32 * 24 * 6))
    (tmp_path / "text.png").write_text("not an image at all")
    (tmp_path / "empty.png").touch()
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "folder.vcd").mkdir()
    os.mkfifo(tmp_path / "pipe.vcd")
    (tmp_path / "kept").mkdir()
    shutil.copy(tmp_path / "good.png", tmp_path / "kept" / "corners.png")
    (tmp_path / "link.png").symlink_to("kept/corners.png")
    for name, text in (("none", "3"), ("empty", "{}"), ("other", '{"builds": 3, "about": {}}')):
        (tmp_path / name).mkdir()
        for figures in ("comparison.json", "evaluation.json"):
            (tmp_path / name / figures).write_text(text)
    (tmp_path / "cut.png").write_bytes((tmp_path / "good.png").read_bytes()[:300])
    monkeypatch.chdir(tmp_path)
    return tmp_path
