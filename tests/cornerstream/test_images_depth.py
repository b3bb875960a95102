"""Pixels of 4 to 10 bits from numbers of 8 to 16 bits, normalization, and their remarks."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result
from PIL import Image

from cornerstream.cli import main
from cornerstream.errors import BadInput
from cornerstream.images import default_photograph, load
from cornerstream.images.depth import eight_bits, fitted, normalized
from golden import Parameters, Settings, detect
from tests.support.image_files import FLOAT, png, tiff
from tests.support.runner import CliRunner

Y, X = np.mgrid[:48, :64]
SQUARES = np.where((Y // 12 % 2) & (X // 12 % 2), 3600, 500).astype(np.uint16)
"""What a 12-bit camera writes into 16-bit files."""


@pytest.fixture
def camera(tmp_path: Path) -> Path:
    path = tmp_path / "camera.png"
    path.write_bytes(png(SQUARES, 16))
    return path


def run(*arguments: object) -> Result:
    return CliRunner().invoke(main, [str(argument) for argument in arguments], prog_name="cornerstream")


@pytest.mark.parametrize(
    ("bits", "wanted", "number", "pixel", "remark"),
    [
        (16, 8, 0xFEDC, 0xFE, "16-bit grey: the upper 8 bits are used"),
        (16, 10, 0xFEDC, 0x3FB, "16-bit grey: the upper 10 bits are used"),
        (12, 10, 0xFED, 0x3FB, "12-bit grey: the upper 10 bits are used"),
        (10, 10, 0x3FE, 0x3FE, None),
        (8, 8, 0xFE, 0xFE, None),
        (8, 9, 0xFE, 0x1FC, "8-bit grey: shifted up by 1 bit"),
        (8, 10, 0xFE, 0x3F8, "8-bit grey: shifted up by 2 bits"),
        (8, 4, 0xFE, 0xF, "8-bit grey: the upper 4 bits are used"),
    ],
)
def test_shifts(bits: int, wanted: int, number: int, pixel: int, remark: str | None) -> None:
    remarks: list[str] = []
    pixels = fitted(np.array([[number]], np.uint8 if bits <= 8 else np.uint16), bits, wanted, remarks)
    assert pixels.tolist() == [[pixel]] and pixels.dtype == (np.uint8 if wanted <= 8 else np.uint16)
    assert remarks == ([remark] if remark else [])


def test_empty_upper_bits_are_told(camera: Path) -> None:
    photograph = load(camera, Parameters.profile("paper"))
    assert photograph.pixels.tolist() == (SQUARES >> 8).tolist()
    assert photograph.remarks == (
        "16-bit grey: the upper 8 bits are used, 4 of them empty: the largest number is 3600 "
        "(see --pixel-bits, --normalize)",
    )


@pytest.mark.parametrize("bits", [4, 8, 10])
def test_normalized(camera: Path, bits: int) -> None:
    photograph = load(camera, Parameters.profile("paper", pixel_bits=bits), normalize=True)
    assert photograph.pixels.tolist() == np.where(SQUARES > 2000, (1 << bits) - 1, 0).tolist()
    assert photograph.remarks == (f"normalized: 500 to 3600 become 0 to {(1 << bits) - 1}",)


def test_normalized_is_linear_and_rounded() -> None:
    remarks: list[str] = []
    assert normalized(np.array([[-1.5, 0.0, 1.0, 3.5]]), 8, remarks).tolist() == [[0, 76, 128, 255]]
    assert remarks == ["normalized: -1.5 to 3.5 become 0 to 255"]


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [(np.nan, "finite"), (np.inf, "finite"), (1.7e308, "finite range"), (0.0, "all its pixels are 0")],
)
def test_what_cannot_be_normalized(tmp_path: Path, wrong: float, reason: str) -> None:
    numbers = np.zeros((20, 20))
    numbers[3, 4] = wrong
    if wrong > 1e308:
        numbers[4, 4] = -wrong
    path = tmp_path / "wrong.tif"
    path.write_bytes(tiff(numbers, 64, number=FLOAT))
    with pytest.raises(BadInput, match=f"cannot be normalized: .*{reason}.*; allowed: "):
        load(path, Parameters.profile("paper"), normalize=True)


def test_shown_at_full_scale() -> None:
    for bits in range(4, 11):
        white = (1 << bits) - 1
        shown = eight_bits(np.array([[0, white // 2, white]], np.uint16), bits)
        assert shown.dtype == np.uint8 and shown.tolist() == [[0, white // 2 * 255 // white, 255]]


def test_default_photograph_of_ten_bits() -> None:
    photograph = default_photograph(Parameters.profile("paper", pixel_bits=10))
    assert (
        photograph.pixels.tolist()
        == (default_photograph(Parameters.profile("paper")).pixels.astype(int) * 4).tolist()
    )
    assert photograph.remarks == ("8-bit grey: shifted up by 2 bits",)


@pytest.mark.parametrize("name", ["paper", "robust"])
def test_detect_with_ten_bits(camera: Path, tmp_path: Path, name: str) -> None:
    """Thresholds follow the pixel bits, and the picture is as bright as with 8."""
    options = ("--profile", name, "--pixel-bits", 10, "--reference", "constant", "--normalize")
    result = run("detect", camera, *options, "--json", "-o", tmp_path / "out")
    assert result.exit_code == 0, result.output
    parameters = Parameters.profile(name, pixel_bits=10)
    settings = Settings.default(parameters, reference="constant", report_rejected=True)
    assert (settings.constant, settings.floor) == (8192 * 16, 1024 * 16)
    corners = detect(np.where(SQUARES > 2000, 1023, 0).astype(np.uint16), parameters, settings)
    found = json.loads(result.stdout)["corners"]
    assert [(corner["x"], corner["response"]) for corner in found] == list(
        zip(corners.x.tolist(), corners.response.tolist(), strict=True)
    )
    assert len(found) > 4 and result.stderr.startswith(f"{camera}: normalized: 500 to 3600")
    drawn = np.asarray(Image.open(tmp_path / "out" / "corners.png").convert("L"))
    # below the title, and 16 pixels of the picture for each of the image's: outside of all
    # squares, and within one
    top = drawn.shape[0] - (63 + 48 * 16)
    assert 0 < top < 60
    assert drawn[63 + 136 : 63 + 150, 136:150].max() < 10 and drawn[63 + 280 : 63 + 296, 280:296].min() > 245


def test_simulate_with_ten_bits(camera: Path, tmp_path: Path) -> None:
    camera.write_bytes(png(SQUARES[4:24, 2:26], 16))
    result = run(
        *("simulate", camera, "--pixel-bits", 10, "--normalize", "--max-width", 24, "--max-height", 20),
        *("--profile", "robust", "--engine", "amaranth", "--frames", 1, "-o", tmp_path),
    )
    assert result.exit_code == 0, result.output
    assert (tmp_path / "corners.csv").read_text().count("\n") > 1
