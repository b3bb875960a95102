"""Images of every kind that Pillow reads: converted with a remark, or refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from cornerstream.errors import BadInput
from cornerstream.images import default_photograph, load
from golden import Parameters

PARAMETERS = Parameters(max_width=64, max_height=48)
GRADIENT = (np.arange(30 * 40) % 256).astype(np.uint8).reshape(30, 40)


def saved(path: Path, image: Image.Image, **options: object) -> Path:
    image.save(path, **options)
    return path


def test_grey_image_is_taken_as_it_is(tmp_path: Path) -> None:
    photograph = load(saved(tmp_path / "grey.png", Image.fromarray(GRADIENT)), PARAMETERS)
    assert photograph.pixels.dtype == np.uint8
    assert photograph.pixels.tolist() == GRADIENT.tolist()
    assert photograph.remarks == ()


@pytest.mark.parametrize(
    ("colour", "grey"), [((255, 0, 0), 76), ((0, 255, 0), 150), ((0, 0, 255), 29), ((9, 9, 9), 9)]
)
def test_colour_is_converted_by_bt601(tmp_path: Path, colour: tuple[int, int, int], grey: int) -> None:
    photograph = load(saved(tmp_path / "colour.png", Image.new("RGB", (20, 16), colour)), PARAMETERS)
    assert np.unique(photograph.pixels).tolist() == [grey]
    assert len(photograph.remarks) == 1 and "BT.601" in photograph.remarks[0]


def test_palette_is_looked_up(tmp_path: Path) -> None:
    image = Image.new("P", (20, 16), 1)
    image.putpalette([0, 0, 0, 255, 0, 0])
    photograph = load(saved(tmp_path / "palette.png", image), PARAMETERS)
    assert np.unique(photograph.pixels).tolist() == [76]
    assert [remark.split()[0] for remark in photograph.remarks] == ["palette", "colour"]


def test_one_bit_is_black_and_white(tmp_path: Path) -> None:
    image = Image.fromarray(np.indices((16, 20)).sum(0) % 2 == 1)
    photograph = load(saved(tmp_path / "bits.png", image), PARAMETERS)
    assert photograph.pixels[0, :3].tolist() == [0, 255, 0]
    assert "1-bit" in photograph.remarks[0]


@pytest.mark.parametrize(("alpha", "grey", "remarks"), [(0, 255, 2), (128, 127, 2), (255, 0, 1)])
def test_transparency_lies_over_white(tmp_path: Path, alpha: int, grey: int, remarks: int) -> None:
    photograph = load(saved(tmp_path / "a.png", Image.new("RGBA", (20, 16), (0, 0, 0, alpha))), PARAMETERS)
    assert np.unique(photograph.pixels).tolist() == [grey]
    assert len(photograph.remarks) == remarks


def test_transparent_palette_entry(tmp_path: Path) -> None:
    image = Image.new("P", (20, 16), 0)
    image.putpalette([0, 0, 0])
    path = saved(tmp_path / "key.png", image, transparency=0)
    photograph = load(path, PARAMETERS)
    assert np.unique(photograph.pixels).tolist() == [255]
    assert any("white" in remark for remark in photograph.remarks)


def test_first_picture_of_several(tmp_path: Path) -> None:
    frames = [Image.new("L", (20, 16), value) for value in (10, 200)]
    path = saved(tmp_path / "two.tif", frames[0], save_all=True, append_images=frames[1:])
    photograph = load(path, PARAMETERS)
    assert np.unique(photograph.pixels).tolist() == [10]
    assert "first" in photograph.remarks[0]


@pytest.mark.parametrize("orientation", range(1, 9))
def test_exif_orientation_is_obeyed(tmp_path: Path, orientation: int) -> None:
    upright = Image.fromarray(GRADIENT)
    stored = {  # how a camera held in that way stores the upright picture
        1: GRADIENT,
        2: GRADIENT[:, ::-1],
        3: GRADIENT[::-1, ::-1],
        4: GRADIENT[::-1],
        5: GRADIENT.T,
        6: np.rot90(GRADIENT),
        7: np.rot90(GRADIENT, 2).T,
        8: np.rot90(GRADIENT, -1),
    }[orientation]
    exif = Image.Exif()
    exif[0x0112] = orientation
    path = saved(tmp_path / "turned.png", Image.fromarray(np.ascontiguousarray(stored)), exif=exif)
    # 40x30 fits, 30x40 would not: the limit is for the upright picture
    photograph = load(path, Parameters(max_width=40, max_height=30))
    assert photograph.pixels.tolist() == np.asarray(upright).tolist()
    assert len(photograph.remarks) == (orientation != 1)


@pytest.mark.parametrize("suffix", ["png", "tif", "pgm"])
def test_sixteen_bit_grey_is_refused(tmp_path: Path, suffix: str) -> None:
    image = Image.fromarray(np.full((20, 20), 40000, np.uint16))
    with pytest.raises(BadInput, match=r"bits per (channel|pixel).*; allowed: 8-bit"):
        load(saved(tmp_path / f"deep.{suffix}", image), PARAMETERS)


def test_sixteen_bit_colour_is_refused(tmp_path: Path) -> None:
    # Pillow opens these as 8-bit RGB and writes none, hence the raw PPM
    path = tmp_path / "deep.ppm"
    path.write_bytes(b"P6 20 20 65535\n" + bytes(20 * 20 * 6))
    with pytest.raises(BadInput, match="16 bits per channel; allowed: 8-bit"):
        load(path, PARAMETERS)


def test_floating_point_image_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="Pillow mode F"):
        load(saved(tmp_path / "float.tif", Image.new("F", (20, 20))), PARAMETERS)


@pytest.mark.parametrize("size", [(14, 15), (15, 14), (65, 48), (64, 49)])
def test_size_out_of_range(tmp_path: Path, size: tuple[int, int]) -> None:
    path = saved(tmp_path / "size.png", Image.new("L", size))
    with pytest.raises(BadInput, match=rf"is {size[0]}x{size[1]} pixels; allowed: 15x15 up to .* 64x48"):
        load(path, PARAMETERS)


@pytest.mark.parametrize("size", [(15, 15), (64, 48)])
def test_size_at_the_limits(tmp_path: Path, size: tuple[int, int]) -> None:
    assert load(saved(tmp_path / "size.png", Image.new("L", size)), PARAMETERS).pixels.shape == size[::-1]


def test_huge_image_is_refused_by_its_heading(tmp_path: Path) -> None:
    path = tmp_path / "huge.pgm"
    path.write_bytes(b"P5 60000 60000 255\n")
    with pytest.raises(BadInput, match="allowed: 15x15 up to"):
        load(path, PARAMETERS)


def test_damaged_image(tmp_path: Path) -> None:
    path = saved(tmp_path / "whole.png", Image.fromarray(GRADIENT))
    path.write_bytes(path.read_bytes()[:-200])
    with pytest.raises(BadInput, match="damaged"):
        load(path, PARAMETERS)


def test_default_photograph() -> None:
    photograph = default_photograph(Parameters())
    assert photograph.pixels.shape == (512, 512)
    with pytest.raises(BadInput, match=r"camera .* is 512x512 pixels"):
        default_photograph(PARAMETERS)
