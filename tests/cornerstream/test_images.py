"""Images by hand: colour, transparency, sizes, damage, and data beside the pixels."""

from __future__ import annotations

import importlib.util
import struct
import subprocess
import sys
import zlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import tifffile
from PIL import Image, features
from PIL.TiffImagePlugin import OPEN_INFO

from cornerstream.errors import BadInput
from cornerstream.images import default_photograph, load
from golden import Parameters
from tests.support.image_files import bmp, by_pillow, chunk, exif, pgm, png, tiff

PARAMETERS = Parameters.profile("paper", max_width=64, max_height=48)
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
    photograph = default_photograph(Parameters.profile("paper"))
    assert photograph.pixels.shape == (512, 512)
    with pytest.raises(BadInput, match=r"camera .* is 512x512 pixels"):
        default_photograph(PARAMETERS)


@pytest.mark.parametrize("kind", ["TIFF", "GIF"])
def test_damage_behind_the_first_picture(tmp_path: Path, kind: str) -> None:
    """Cut anywhere: one line, or the first picture, which is whole."""
    frames = [Image.fromarray(np.roll(GRADIENT, shift, axis=1)) for shift in (0, 9, 20)]
    content = by_pillow(frames[0], kind, save_all=True, append_images=frames[1:])
    path, seen = tmp_path / "several", set()
    for length in range(10, len(content) + 10, 10):
        path.write_bytes(content[:length])
        try:
            photograph = load(path, PARAMETERS)
        except BadInput as error:
            assert "\n" not in error.message and "allowed: " in error.message
        else:
            assert photograph.pixels.tolist() == GRADIENT.tolist()
            seen |= {remark for remark in photograph.remarks if "first" in remark}
    assert seen == {
        "more than one picture in the file: the first is used",
        "what follows the first picture of the file is damaged: the first is used",
    }


def test_pages_of_different_kinds(tmp_path: Path) -> None:
    colour = Image.fromarray(np.dstack([GRADIENT, GRADIENT // 2, 255 - GRADIENT]))
    pages = [Image.fromarray(GRADIENT).convert("P"), Image.fromarray(GRADIENT).convert("1")]
    photograph = load(saved(tmp_path / "pages.tif", colour, save_all=True, append_images=pages), PARAMETERS)
    assert photograph.pixels.tolist() == np.asarray(colour.convert("L")).tolist()
    assert photograph.remarks[0] == "more than one picture in the file: the first is used"


@pytest.mark.parametrize(
    "extra",
    [
        chunk(b"zTXt", b"Comment\0\0" + zlib.compress(bytes(2 << 20))),
        chunk(b"iTXt", b"Comment\0\1\0\0\0" + zlib.compress(b"a" * (2 << 20))),
        chunk(b"iCCP", b"profile\0\0" + zlib.compress(bytes(2 << 20))),
        chunk(b"tEXt", b"Comment\0" + b"a" * (66 << 20)),
    ],
    ids=["zTXt", "iTXt", "iCCP", "tEXt"],
)
@pytest.mark.parametrize("where", ["before", "after"])
def test_long_texts_in_a_png(tmp_path: Path, extra: bytes, where: str) -> None:
    path = tmp_path / "text.png"
    path.write_bytes(png(GRADIENT, 8, **{where: extra}))
    assert load(path, PARAMETERS).pixels.tolist() == GRADIENT.tolist()


def test_animated_png(tmp_path: Path) -> None:
    first, second = Image.fromarray(GRADIENT), Image.fromarray(GRADIENT[::-1])
    photograph = load(saved(tmp_path / "two.png", first, save_all=True, append_images=[second]), PARAMETERS)
    assert photograph.pixels.tolist() == GRADIENT.tolist()
    assert photograph.remarks == ("more than one picture in the file: the first is used",)


def test_orientation_behind_the_pixels_of_a_png(tmp_path: Path) -> None:
    path = tmp_path / "turned.png"
    path.write_bytes(png(GRADIENT, 8, after=chunk(b"eXIf", exif(3))))
    assert load(path, PARAMETERS).pixels.tolist() == GRADIENT[::-1, ::-1].tolist()


def test_bmp_of_five_and_six_bits(tmp_path: Path) -> None:
    red, green, blue = GRADIENT >> 3, GRADIENT[::-1] >> 2, GRADIENT[:, ::-1] >> 3
    word = (red.astype(np.uint16) << 11) | (green.astype(np.uint16) << 5) | blue
    path = tmp_path / "565.bmp"
    masks = struct.pack("<III", 0xF800, 0x07E0, 0x001F)
    path.write_bytes(bmp(word[::-1].astype("<u2").tobytes(), (40, 30), 16, [], masks))
    wide = np.dstack([red * (255 / 31), green * (255 / 63), blue * (255 / 31)])
    assert np.abs(load(path, PARAMETERS).pixels - wide @ (0.299, 0.587, 0.114)).max() <= 1.5


@pytest.mark.parametrize(("largest", "bits"), [(100, 8), (1000, 10)])
def test_pgm_whose_white_is_no_power_of_two(tmp_path: Path, largest: int, bits: int) -> None:
    numbers = np.arange(30 * 40).reshape(30, 40) % (largest + 1)
    path = tmp_path / "white.pgm"
    path.write_bytes(pgm(numbers, largest))
    photograph = load(path, replace(PARAMETERS, pixel_bits=bits))
    exact = numbers * ((1 << bits) - 1) / largest
    assert np.abs(photograph.pixels - exact).max() < 1 and photograph.pixels.max() == (1 << bits) - 1
    assert photograph.remarks == (f"grey of 0 to {largest}: stretched to full scale",)


@pytest.mark.parametrize("plain", [False, True])
@pytest.mark.parametrize(("channels", "largest"), [(1, 100), (1, 1000), (1, 1023), (3, 100)])
def test_numbers_beyond_the_largest(tmp_path: Path, channels: int, largest: int, plain: bool) -> None:
    """The last number is too large; behind the pixels of a binary file it does not count."""
    numbers = np.full((15, 15, 3) if channels == 3 else (15, 15), largest // 3)
    path = tmp_path / "beyond.pnm"
    if not plain:
        path.write_bytes(pgm(numbers, largest) + b"\xff\xff")
        assert len(set(load(path, PARAMETERS).pixels.flat)) == 1
    numbers.flat[-1] = largest + 1
    path.write_bytes(pgm(numbers, largest, plain=plain))
    with pytest.raises(BadInput, match=f"is damaged: .*{largest + 1}"):
        load(path, PARAMETERS)


@pytest.mark.parametrize("largest", [0, 65536])
def test_largest_number_that_there_is_not(tmp_path: Path, largest: int) -> None:
    path = tmp_path / "largest.pgm"
    path.write_bytes(pgm(np.zeros((15, 15), int), largest))
    with pytest.raises(
        BadInput, match=f"is damaged: its largest number is {largest}, and can be 1 to 65535;"
    ):
        load(path, PARAMETERS)


@pytest.mark.parametrize("colour", [False, True])
def test_samples_that_nobody_explains(tmp_path: Path, colour: bool) -> None:
    """They are no transparency, and are said to be left out."""
    channels = [GRADIENT] * (3 if colour else 1)
    path = tmp_path / "more.tif"
    path.write_bytes(tiff(np.dstack([*channels, GRADIENT // 2]), 8, 2 if colour else 1, extra=0))
    if not colour and (b"II", 1, (1,), 1, (8, 8), (0,)) not in OPEN_INFO:
        # early Pillow
        with pytest.raises(BadInput, match=r"8-bit grey with further samples \(TIFF\) that cannot be read"):
            load(path, PARAMETERS)
        return
    photograph = load(path, PARAMETERS)
    assert photograph.pixels.tolist() == GRADIENT.tolist()
    assert photograph.remarks[0] == "samples beside grey or colours whose meaning is not said: ignored"
    assert len(photograph.remarks) == (2 if colour else 1)


@pytest.mark.parametrize("compression", ["packbits", "tiff_lzw", "tiff_adobe_deflate", "group4", "jpeg"])
def test_compressed_tiff(tmp_path: Path, compression: str) -> None:
    image = Image.fromarray(GRADIENT)
    image = image.convert("1") if compression == "group4" else image
    photograph = load(saved(tmp_path / "c.tif", image, compression=compression), PARAMETERS)
    assert np.abs(photograph.pixels - np.asarray(image.convert("L")).astype(int)).max() <= (
        60 if compression == "jpeg" else 0
    )


@pytest.mark.parametrize("predictor", [1, 2])
def test_deep_tiff_by_lzw(tmp_path: Path, predictor: int) -> None:
    deep = GRADIENT.astype(np.uint16) * 251
    path = saved(
        tmp_path / "deep.tif", Image.fromarray(deep), compression="tiff_lzw", tiffinfo={317: predictor}
    )
    photograph = load(path, replace(PARAMETERS, pixel_bits=10))
    assert photograph.pixels.tolist() == (deep >> 6).tolist()


def test_floating_point_tiff_by_lzw(tmp_path: Path) -> None:
    image = Image.fromarray(GRADIENT.astype(np.float32))
    path = saved(tmp_path / "float.tif", image, compression="tiff_lzw")
    if importlib.util.find_spec("imagecodecs"):
        assert load(path, PARAMETERS, normalize=True).pixels.tolist() == GRADIENT.tolist()
        return
    with pytest.raises(BadInput, match=r"only the package imagecodecs reads .*; allowed without it: "):
        load(path, PARAMETERS, normalize=True)


@pytest.mark.parametrize("big", [False, True], ids=["plain", "big"])
@pytest.mark.parametrize("deep", [False, True], ids=["8 bits", "16 bits"])
def test_tiles(tmp_path: Path, deep: bool, big: bool) -> None:
    picture = np.dstack([GRADIENT] * 3) * (np.uint16(257) if deep else np.uint8(1))
    path = tmp_path / "tiles.tif"
    tifffile.imwrite(path, picture, photometric="rgb", tile=(16, 32), bigtiff=big)
    assert load(path, PARAMETERS).pixels.tolist() == GRADIENT.tolist()
    whole = path.read_bytes()
    offsets = struct.pack("<HHQ", 324, 16, 4) if big else struct.pack("<HHI", 324, 4, 4)
    assert whole.count(offsets) == 1
    path.write_bytes(whole.replace(offsets, offsets[:4] + b"\3" + offsets[5:]))
    with pytest.raises(BadInput, match="damaged: it has 3 tiles of 4"):
        load(path, PARAMETERS)


@pytest.mark.parametrize("layout", ["chunky", "planar"])
def test_tiff_that_lacks_a_strip(tmp_path: Path, layout: str) -> None:
    planar = layout == "planar"
    picture = np.dstack([GRADIENT] * 3) if planar else GRADIENT
    whole = tiff(picture, 8, 2 if planar else 1, planar=planar, strips=3)
    path = tmp_path / "strips.tif"
    path.write_bytes(whole)
    assert load(path, PARAMETERS).pixels.tolist() == GRADIENT.tolist()
    strips = 9 if planar else 3
    heading = struct.pack("<HHI", 273, 4, strips)
    assert whole.count(heading) == 1
    path.write_bytes(whole.replace(heading, struct.pack("<HHI", 273, 4, strips - 1)))
    with pytest.raises(BadInput, match=f"damaged: it has {strips - 1} strips of {strips}"):
        load(path, PARAMETERS)


def test_what_decoders_log_is_not_shown(tmp_path: Path) -> None:
    whole = tiff(np.dstack([GRADIENT] * 3), 8, 2)
    count = struct.pack("<HHIH", 277, 3, 1, 3)
    assert whole.count(count) == 1
    path = tmp_path / "many.tif"
    path.write_bytes(whole.replace(count, count[:-2] + b"\xff\xff"))
    script = f"from cornerstream.cli import main; main(['detect', {str(path)!r}, '--json'])"
    result = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert result.returncode == 2 and result.stderr.count("\n") == 1, result.stderr


def test_colour_space_that_is_not_known(tmp_path: Path) -> None:
    path = saved(tmp_path / "lab.tif", Image.new("LAB", (20, 16)))
    with pytest.raises(BadInput, match=r"8-bit LAB \(TIFF\); allowed: "):
        load(path, PARAMETERS)


def test_avif_without_its_decoder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(features.modules, "avif", raising=False)
    path = tmp_path / "a.avif"
    # heading of 8 bits
    path.write_bytes(b"\0\0\0\x14ftypavif\0\0\0\0avif....av1C\x81\x00\x00\x00")
    with pytest.raises(BadInput, match=r"AVIF, which needs Pillow 11\.3"):
        load(path, PARAMETERS)


def test_file_without_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cornerstream.images._LARGEST_FILE", 1 << 30 >> 20)
    with pytest.raises(BadInput, match="is larger than"):
        load(saved(tmp_path / "grey.bmp", Image.fromarray(GRADIENT)), PARAMETERS)
