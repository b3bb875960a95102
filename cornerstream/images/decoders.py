"""Pixels of a file as upright grey numbers with all their bits, by Pillow or tifffile."""

from __future__ import annotations

import io
import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, features
from PIL.ExifTags import Base

from cornerstream.errors import BadInput
from cornerstream.images.headers import Header, without_extras

Numbers = NDArray[Any]
CheckSize = Callable[[tuple[int, int]], None]

_BT601 = "colour image: converted to grey by BT.601 (0.299 R + 0.587 G + 0.114 B)"
_DEEP = {"PNG": ("grey",), "TIFF": ("grey", "RGB"), "PPM": ("grey",), "JPEG2000": ("grey",)}
"""Layouts that keep all of their bits, where these are not 8."""
_SCALED = ("PPM", "JPEG2000")
"""Formats whose samples a decoder spreads over all of its 8 or 16 bits."""
ALLOWED = (
    "grey of up to 16 bits in PNG, TIFF, PGM and JPEG 2000, RGB of up to 16 bits in TIFF, "
    "and 8-bit grey, RGB, CMYK, palettes and transparency"
)
"""What is read without loss, for messages."""
# what matters is told in exceptions; what goes to the logs besides would come out on stderr
for _decoder in ("PIL", "tifffile"):
    logging.getLogger(_decoder).addHandler(logging.NullHandler())
_KINDS = {"unsigned": "u", "signed": "i", "floating-point": "f"}
"""NumPy's letters."""


@dataclass
class Decoded:
    """One picture.

    Attributes
    ----------
    grey
        (height, width), upright.
    bits
        Bits of a number in ``grey``.
    remarks
        One line for each conversion.
    """

    grey: Numbers
    bits: int
    remarks: list[str] = field(default_factory=list)


def check_kind(header: Header, name: str, *, normalize: bool, hint: str) -> None:
    """:class:`BadInput` for a kind of pixels that would lose bits or meaning."""
    kept = header.layout in _DEEP.get(header.format, ()) and header.number != "complex"
    if not header.plain and not kept:
        raise BadInput(f"{name} is {kind(header)}; allowed: {ALLOWED}")
    if (header.number != "unsigned" or header.bits > 16) and not normalize:
        raise BadInput(f"{name} is {kind(header)}; allowed: unsigned numbers of up to 16 bits{hint}")
    if header.format == "AVIF" and not ("avif" in features.modules and features.check("avif")):
        raise BadInput(f"{name} is AVIF, which needs Pillow 11.3 or newer; allowed here: PNG, JPEG, TIFF ...")


def kind(header: Header) -> str:
    """The kind of a file, for people."""
    return f"{header} ({header.format})"


def decode(data: bytes, header: Header, check_size: CheckSize) -> Decoded:
    """The first picture of a file whose kind is allowed.

    Parameters
    ----------
    data, header
        The file.
    check_size
        Called with (width, height) as stored, before any pixel is decoded.

    Damaged files raise almost anything, from SyntaxError to struct.error.
    """
    # Pillow knows this kind of deep TIFF only; it refuses the others, or reads them with their
    # bytes exchanged
    known = header.layout == "grey" and header.number == "unsigned" and header.bits in (12, 16)
    if header.format == "TIFF" and not header.plain and (not known or header.white_is_zero):
        return _by_tifffile(data, header, check_size)
    return _by_pillow(data, header, check_size)


def _by_tifffile(data: bytes, header: Header, check_size: CheckSize) -> Decoded:
    # importing it takes a while
    import tifffile

    with tifffile.TiffFile(io.BytesIO(data)) as file:
        page = file.pages.first
        check_size((page.imagewidth, page.imagelength))
        numbers = page.asarray()
        decoded = Decoded(numbers, header.bits, _remarks_on_pages(lambda: len(file.pages)))
    if numbers.ndim != (2 if header.layout == "grey" else 3) or numbers.dtype.kind != _KINDS[header.number]:
        raise ValueError(f"its first picture has the shape {numbers.shape} and numbers of {numbers.dtype}")
    if header.layout == "RGB":
        planes = (
            numbers if page.planarconfig == tifffile.PLANARCONFIG.SEPARATE else np.moveaxis(numbers, -1, 0)
        )
        decoded.remarks.append(_BT601)
        decoded.grey = _bt601(planes)
    if header.white_is_zero:
        decoded.grey = (1 << header.bits) - 1 - numbers
    return _upright(decoded, header.orientation)


def _bt601(planes: Numbers) -> Numbers:
    grey = np.tensordot((0.299, 0.587, 0.114), planes.astype(np.float64), axes=1)
    return grey if planes.dtype.kind == "f" else np.rint(grey).astype(planes.dtype)


def _by_pillow(data: bytes, header: Header, check_size: CheckSize) -> Decoded:
    if header.format == "PNG":
        data = without_extras(data)
    # from memory: Pillow cuts a mapped file into rows of the wrong length, where rows become
    # columns
    with Image.open(io.BytesIO(data), formats=[header.format]) as image:
        check_size(image.size)
        image.load()
        # a TIFF has been turned by now
        turned = header.format == "TIFF"
        orientation = header.orientation if turned else image.getexif().get(Base.Orientation, 1)
        remarks: list[str] = []
        grey = _grey(image, header, remarks)
        # only now, because looking for further pictures may leave the first
        pages = _remarks_on_pages(lambda: 2 if header.animated else getattr(image, "n_frames", 1))
    decoded = Decoded(grey, 8 if header.plain else header.bits, pages)
    decoded = _upright(decoded, orientation, turned=turned)
    decoded.remarks += remarks
    return decoded


def _remarks_on_pages(count: Callable[[], int]) -> list[str]:
    try:
        return ["more than one picture in the file: the first is used"] if count() > 1 else []
    except Exception:
        # the first picture is whole
        return ["what follows the first picture of the file is damaged: the first is used"]


def _upright(decoded: Decoded, orientation: int, *, turned: bool = False) -> Decoded:
    turns: dict[int, Callable[[Numbers], Numbers]] = {
        2: np.fliplr,
        3: lambda grey: np.rot90(grey, 2),
        4: np.flipud,
        5: np.transpose,
        6: lambda grey: np.rot90(grey, -1),
        7: lambda grey: np.rot90(grey, 2).T,
        8: np.rot90,
    }
    turn = turns.get(orientation)
    if turn is None:
        return decoded
    grey = decoded.grey if turned else np.ascontiguousarray(turn(decoded.grey))
    return Decoded(grey, decoded.bits, [*decoded.remarks, "turned upright as its EXIF orientation says"])


def _grey(image: Image.Image, header: Header, remarks: list[str]) -> Numbers:
    if header.unspecified:
        remarks.append("samples beside grey or colours whose meaning is not said: ignored")
    if header.largest is not None:
        remarks.append(f"grey of 0 to {header.largest}: stretched to full scale")
    if image.mode == "1":
        remarks.append("1-bit image: black becomes 0 and white 255")
        grey = np.where(np.asarray(image), 255, 0).astype(np.uint8)
    elif header.plain:
        grey = np.asarray(_eight_bits(image, remarks))
    else:
        grey = _deep(image, header)
    if header.transparent is not None:
        grey = _without_key(grey, header, remarks)
    return grey


def _deep(image: Image.Image, header: Header) -> Numbers:
    numbers = np.asarray(image)
    if image.mode == "F":
        return numbers
    numbers = numbers.astype(np.uint16)
    if header.format in _SCALED:
        numbers >>= (8 if image.mode == "L" else 16) - header.bits
    return numbers.astype(np.int32) - (1 << header.bits - 1) if header.number == "signed" else numbers


def _without_key(grey: Numbers, header: Header, remarks: list[str]) -> Numbers:
    assert header.transparent is not None
    white = np.iinfo(grey.dtype).max
    # narrow samples have been widened, all ones to all ones
    level = header.transparent * (white // ((1 << header.bits) - 1))
    if not (grey == level).any():
        return grey
    remarks.append("transparent pixels: laid over white")
    return np.where(grey == level, white, grey).astype(grey.dtype)


def _eight_bits(image: Image.Image, remarks: list[str]) -> Image.Image:
    grey = image.mode in ("L", "LA", "La")
    if image.mode == "P":
        remarks.append("palette looked up")
        image = image.convert("RGBA" if "transparency" in image.info else "RGB")
    elif image.mode == "RGB" and "transparency" in image.info:
        image = image.convert("RGBA")
    if image.has_transparency_data:
        image = _over_white(image, remarks)
    if grey:
        return image.convert("L")
    colour = image.convert("RGB")
    remarks.append(_BT601)
    return colour.convert("L")


def _over_white(image: Image.Image, remarks: list[str]) -> Image.Image:
    image = image.convert("RGBA")
    if image.getchannel("A").getextrema() != (255, 255):
        remarks.append("transparent pixels: laid over white")
        return Image.alpha_composite(Image.new("RGBA", image.size, "white"), image)
    return image
