"""The user's images for ``eval``: any size, and one remark for conversions that are alike."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from cornerstream.errors import BadInput
from cornerstream.own_data import load_images, load_pairs
from evaluation.methods.detectors import USUAL, Ours
from golden import Parameters, Settings, detect

TALL = np.kron(np.indices((60, 8)).sum(0) % 2, np.full((20, 12), 200)).astype(np.uint8)
"""1200 rows, more than a detector is built for unless it is asked to."""


def test_pairs_of_any_size(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for number in (1, 2):
        Image.fromarray(np.dstack([TALL] * 3)).save(tmp_path / f"{number}.png")
    np.savetxt(tmp_path / "H_1_2.txt", np.eye(3))
    (pair,) = load_pairs(tmp_path)
    assert np.array_equal(pair.first, TALL) and np.array_equal(pair.second, TALL)
    assert capsys.readouterr().err.count("BT.601") == 1
    found = Ours("robust", Parameters.profile("robust")).at(pair.first, USUAL)
    parameters = Parameters.profile("robust", max_height=1200)
    corners = detect(TALL, parameters, Settings.default(parameters))
    assert len(found) == len(corners) > 100
    assert {tuple(place) for place in found} == set(zip(corners.x.tolist(), corners.y.tolist(), strict=True))


def test_message_names_no_option_of_other_commands(tmp_path: Path) -> None:
    Image.new("L", (14, 20)).save(tmp_path / "small.png")
    with pytest.raises(BadInput) as caught:
        load_images(tmp_path)
    assert caught.value.message == f"{tmp_path / 'small.png'} is 14x20 pixels; allowed: 15x15 up to 8192x8192"
    Image.new("F", (20, 20)).save(tmp_path / "small.tif")
    (tmp_path / "small.png").unlink()
    with pytest.raises(BadInput) as caught:
        load_images(tmp_path)
    assert "floating-point" in caught.value.message and "--" not in caught.value.message
