"""Every kind of image file gives pixels and remarks, or one line: whole, turned, cut, with junk."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import features

from cornerstream.errors import BadInput
from cornerstream.images import Photograph, load
from golden import Parameters
from tests.support.image_case import NORMALIZED, REFUSED, USED, Case
from tests.support.image_cases import CASES, table
from tests.support.image_files import chunk, exif

PAGE = Path(__file__).parents[2] / "docs" / "reference" / "inputs.md"
SIZE = {"max_width": 20, "max_height": 18}

STORED: dict[int, Callable[[Any], Any]] = {
    # how a camera held in that way stores the upright picture
    1: lambda upright: upright,
    2: lambda upright: upright[:, ::-1],
    3: lambda upright: upright[::-1, ::-1],
    4: lambda upright: upright[::-1],
    5: lambda upright: np.swapaxes(upright, 0, 1),
    6: lambda upright: np.rot90(upright),
    7: lambda upright: np.swapaxes(np.rot90(upright, 2), 0, 1),
    8: lambda upright: np.rot90(upright, -1),
}


def readable(case: Case) -> bool:
    """Whether this Pillow can read and write the case's format."""
    return case.format != "AVIF" or ("avif" in features.modules and bool(features.check("avif")))


def cases(*outcomes: str, formats: tuple[str, ...] = ()) -> list[Any]:
    skip = pytest.mark.skip(reason="this Pillow has no AVIF")
    return [
        pytest.param(case, id=str(case), marks=() if case.outcome == REFUSED or readable(case) else skip)
        for case in CASES
        if case.outcome in outcomes and (not formats or case.format in formats)
    ]


def loaded(path: Path, content: bytes, bits: int = 8, *, normalize: bool = False) -> Photograph:
    path.write_bytes(content)
    return load(path, Parameters.profile("paper", pixel_bits=bits, **SIZE), normalize=normalize)


def shifted(grey: NDArray[Any], bits: int, wanted: int) -> NDArray[Any]:
    return grey >> (bits - wanted) if bits >= wanted else grey.astype(np.uint16) << (wanted - bits)


def check_pixels(photograph: Photograph, case: Case, bits: int) -> None:
    right = shifted(case.grey, case.bits, bits)
    assert photograph.pixels.dtype == (np.uint8 if bits <= 8 else np.uint16)
    assert photograph.pixels.shape == right.shape
    # what a lossy format adds is in 8-bit levels
    most = max(shifted(np.array(case.within), 8, bits), min(case.within, 1))
    assert np.abs(photograph.pixels.astype(int) - right.astype(int)).max() <= most


def check_remarks(photograph: Photograph, expected: list[str]) -> None:
    assert len(photograph.remarks) == len(expected), photograph.remarks
    for remark, part in zip(photograph.remarks, expected, strict=True):
        assert part in remark


@pytest.mark.parametrize("bits", [4, 8, 10])
@pytest.mark.parametrize("case", cases(USED))
def test_used(tmp_path: Path, case: Case, bits: int) -> None:
    photograph = loaded(tmp_path / "image", case.make(), bits)
    check_pixels(photograph, case, bits)
    shift = {True: [f"{case.bits}-bit grey: the upper {bits} bits are used"], False: []}[case.bits > bits]
    shift += {True: [f"{case.bits}-bit grey: shifted up by {bits - case.bits} bits"], False: []}[
        case.bits < bits
    ]
    check_remarks(photograph, [*case.remarks, *shift])


@pytest.mark.parametrize("case", cases(NORMALIZED))
def test_normalized_only(tmp_path: Path, case: Case) -> None:
    with pytest.raises(BadInput, match=r"allowed: unsigned numbers of up to 16 bits; with --normalize, any"):
        loaded(tmp_path / "image", case.make())
    photograph = loaded(tmp_path / "image", case.make(), 10, normalize=True)
    grey = case.grey.astype(np.float64)
    right = np.rint((grey - grey.min()) * 1023 / (grey.max() - grey.min()))
    assert np.abs(photograph.pixels - right).max() <= (1 if case.layout == "RGB" else 0)
    check_remarks(photograph, [*case.remarks, "normalized: "])


@pytest.mark.parametrize("case", cases(REFUSED))
def test_refused(tmp_path: Path, case: Case) -> None:
    packed = case.format == "TIFF" and case.depth in ("10", "12")
    if packed and importlib.util.find_spec("imagecodecs"):
        pytest.skip("imagecodecs reads it")
    depth = case.depth if case.depth.isdigit() else f"-bit {case.depth}"
    for normalize in (False, True):
        with pytest.raises(BadInput, match=r"; allowed") as caught:
            loaded(tmp_path / "image", case.make(), normalize=normalize)
        assert "\n" not in caught.value.message
        assert ("imagecodecs" if packed else depth) in caught.value.message


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("case", cases(USED, formats=("PNG",)))
def test_turned_png(tmp_path: Path, case: Case, orientation: int) -> None:
    content = case.make(STORED[orientation], chunk(b"eXIf", exif(orientation)))
    check_turned(loaded(tmp_path / "image", content), case, orientation)


@pytest.mark.parametrize("orientation", range(1, 9))
@pytest.mark.parametrize("case", cases(USED, formats=("JPEG", "WebP", "AVIF")))
def test_turned_photograph(tmp_path: Path, case: Case, orientation: int) -> None:
    # these writers turn nothing: the picture is stored as it is, and comes back turned the other
    # way
    photograph = loaded_any_size(tmp_path / "image", case.make(exif=b"Exif\0\0" + exif(orientation)))
    back = {6: 8, 8: 6}.get(orientation, orientation)
    check_turned(photograph, replace(case, grey=STORED[back](case.grey)), orientation)


def loaded_any_size(path: Path, content: bytes) -> Photograph:
    path.write_bytes(content)
    return load(path, Parameters.profile("paper", max_width=20, max_height=20))


def check_turned(photograph: Photograph, case: Case, orientation: int) -> None:
    check_pixels(photograph, case, 8)
    assert ("turned upright as its EXIF orientation says" in photograph.remarks) == (orientation != 1)


@pytest.mark.parametrize("case", cases(USED, NORMALIZED, formats=("TIFF",)))
def test_layouts_of_tiff(tmp_path: Path, case: Case) -> None:
    """All layouts give the same: turned, strips, planes, order of bytes, compression."""
    normalize = case.outcome == NORMALIZED
    right = loaded(tmp_path / "image", case.make(), normalize=normalize).pixels
    planes = (False, True) if case.layout in ("RGB", "RGB with alpha", "CMYK") else (False,)
    for orientation in range(1, 9):
        for order in "<" if case.depth == "12" else "<>":
            for planar in planes:
                for strips, deflate in ((1, False), (3, False), (2, True)):
                    how = {"orientation": orientation, "order": order, "planar": planar}
                    content = case.make(STORED[orientation], **how, strips=strips, deflate=deflate)
                    photograph = loaded(tmp_path / "image", content, normalize=normalize)
                    assert np.array_equal(photograph.pixels, right), (how, strips, deflate)
                    turned = any("turned upright" in remark for remark in photograph.remarks)
                    assert turned == (orientation != 1)


@pytest.mark.parametrize("case", cases(USED, NORMALIZED))
def test_cut_and_with_junk(tmp_path: Path, case: Case, capfd: pytest.CaptureFixture[str]) -> None:
    """Cut anywhere: one line, or the right picture, where no more than its end is missing."""
    content = case.make()
    normalize = case.outcome == NORMALIZED
    right = loaded(tmp_path / "image", content, normalize=normalize).pixels
    as_text = content[:2] in (b"P1", b"P2", b"P3")
    # what follows numbers as text is text
    for junk in (b" \n",) if as_text else (bytes(64), b"\xff" * 64, bytes(range(256))):
        assert np.array_equal(loaded(tmp_path / "image", content + junk, normalize=normalize).pixels, right)
    end = len(content)
    if as_text:
        # the last number, cut, is a number
        end -= 8
    for length in range(0, end, 10):
        try:
            photograph = loaded(tmp_path / "image", content[:length], normalize=normalize)
        except BadInput as error:
            assert "allowed: " in error.message and "\n" not in error.message
        else:
            assert np.array_equal(photograph.pixels, right), length
    assert capfd.readouterr() == ("", "")


def test_page() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert "\n".join(table()) in text, "\n".join(table())
