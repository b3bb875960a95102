"""The kind of a file, read from its header, where decoders do not tell it reliably.

Pillow silently reads 16-bit colour, 10-bit AVIF and signed bytes as unsigned 8-bit pixels. So depth
and kind of number are taken from the file itself, and only formats whose header is read here are
read at all.
"""

from __future__ import annotations

import io
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from PIL import TiffImagePlugin
from PIL.TiffTags import TAGS_V2

_TAG = {info.name: number for number, info in TAGS_V2.items()}
_NUMBERS = {1: "unsigned", 2: "signed", 3: "floating-point", 4: "unsigned", 5: "complex", 6: "complex"}
"""Sample formats of TIFF; 4 is 'undefined'."""
_TIFF_LAYOUTS = {0: "grey", 1: "grey", 2: "RGB", 3: "palette", 5: "CMYK", 6: "YCbCr", 8: "LAB"}
_PNG_LAYOUTS = {
    0: "grey",
    2: "RGB",
    3: "palette",
    4: "grey with transparency",
    6: "RGB with transparency",
}
_PNG_ESSENTIAL = {b"IHDR", b"PLTE", b"tRNS", b"IDAT", b"eXIf", b"IEND"}


@dataclass(frozen=True)
class Header:
    """A file's kind.

    Attributes
    ----------
    format
        Name of the format, as in Pillow.
    bits
        Bits of a sample; those of the widest, where they differ.
    number
        ``"unsigned"``, ``"signed"``, ``"floating-point"`` or ``"complex"``.
    layout
        ``"grey"`` and ``"RGB"`` are that and nothing else; other words are for people only.
    white_is_zero
        Grey whose largest number is black.
    orientation
        EXIF's number, where the file's header holds it (TIFF).
    transparent
        Grey level, in the file's own numbers, of transparent pixels.
    animated
        A PNG of several pictures; the other formats' decoders tell.
    largest
        The number that is white, where that is not all ones (PGM).
    unspecified
        There are samples beside grey or colours that are not transparency, or whose meaning is not
        given (TIFF).
    """

    format: str
    bits: int = 8
    number: str = "unsigned"
    layout: str = "RGB"
    white_is_zero: bool = False
    orientation: int = 1
    transparent: int | None = None
    animated: bool = False
    largest: int | None = None
    unspecified: bool = False

    @property
    def plain(self) -> bool:
        """Unsigned, all of its bits are in a decoder's 8, and what they stand for is known."""
        # the decoder of JPEG 2000 does not widen samples of fewer bits
        exact = self.bits == 8 or (self.bits < 8 and self.format != "JPEG2000")
        return exact and self.number == "unsigned" and self.layout != "LAB"

    def __str__(self) -> str:
        kind = "" if self.number == "unsigned" else f"{self.number} "
        return f"{self.bits}-bit {kind}{self.layout}"


def read_header(data: bytes) -> Header | None:
    """The header of a file, or None if the format is not known here.

    Damaged headers raise the same exceptions as reading beyond the end, as decoders do.
    """
    for magic, read in _FORMATS:
        if magic.match(data):
            return read(data)
    return None


def without_extras(data: bytes) -> bytes:
    """A PNG without data that pixels do not need: texts, profiles and further pictures.

    The transparent level of grey stays out as well: decoders compare it with pixels that they have
    widened before.
    """
    kept = _PNG_ESSENTIAL - ({b"tRNS"} if data[25] == 0 else set())
    return data[:8] + b"".join(chunk for kind, chunk in _chunks(data) if kind in kept)


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    place = 8
    while place < len(data):
        length = int.from_bytes(data[place : place + 4], "big")
        yield data[place + 4 : place + 8], data[place : place + 12 + length]
        place += 12 + length


def _png(data: bytes) -> Header:
    bits, colour = data[24], data[25]
    chunks = {kind: chunk for kind, chunk in _chunks(data) if kind in (b"tRNS", b"acTL")}
    transparent = None
    if colour == 0 and b"tRNS" in chunks:
        # bits beyond the depth do not count
        transparent = int.from_bytes(chunks[b"tRNS"][8:10], "big") & ((1 << bits) - 1)
    return Header(
        "PNG", bits, layout=_PNG_LAYOUTS[colour], transparent=transparent, animated=b"acTL" in chunks
    )


def _jpeg(data: bytes) -> Header:
    place = 2
    while True:
        marker = data[place + 1]
        if marker == 0xFF:
            place += 1
        elif 0xC0 <= marker <= 0xCF and marker not in (0xC4, 0xC8, 0xCC):
            # start of frame: length, precision, height, width, number of components
            return Header("JPEG", data[place + 4], layout="grey" if data[place + 9] == 1 else "colour")
        else:
            place += 2 + int.from_bytes(data[place + 2 : place + 4], "big")


def _tiff(data: bytes) -> Header:
    tags = TiffImagePlugin.ImageFileDirectory_v2(data[:16] if data[2] == 43 else data[:8])
    file = io.BytesIO(data)
    file.seek(tags.next)
    tags.load(file)

    def tag(name: str, default: Any) -> Any:
        return tags.get(_TAG[name], default)

    channels, photometric = tag("SamplesPerPixel", 1), tag("PhotometricInterpretation", 0)
    layout = _TIFF_LAYOUTS.get(photometric, f"samples of photometric interpretation {photometric}")
    if channels > {"grey": 1, "palette": 1, "CMYK": 4}.get(layout, 3):
        layout += " with further samples"
    _check_strips(tags)
    number = _NUMBERS.get(max(tag("SampleFormat", (1,))), "complex")
    if photometric == 0 and number != "unsigned":
        layout += " with white at zero"
    return Header(
        "TIFF",
        bits=max(tag("BitsPerSample", (1,))),
        number=number,
        layout=layout,
        white_is_zero=photometric == 0,
        orientation=tag("Orientation", 1),
        unspecified=0 in tag("ExtraSamples", ()),
    )


def _check_strips(tags: TiffImagePlugin.ImageFileDirectory_v2) -> None:
    """Refuse missing strips or tiles, whose pixels decoders would leave black."""
    width, height = (tags.get(_TAG[name], 0) for name in ("ImageWidth", "ImageLength"))
    parts, across, down = "strips", width, tags.get(_TAG["RowsPerStrip"], height)
    offsets = tags.get(_TAG["StripOffsets"], ())
    if _TAG["TileOffsets"] in tags:
        parts, across, down = "tiles", tags[_TAG["TileWidth"]], tags[_TAG["TileLength"]]
        offsets = tags[_TAG["TileOffsets"]]
    planes = tags.get(_TAG["SamplesPerPixel"], 1) if tags.get(_TAG["PlanarConfiguration"]) == 2 else 1
    needed = -(-width // across) * -(-height // down) * planes
    if len(offsets) < needed:
        raise EOFError(f"it has {len(offsets)} {parts} of {needed}")


def _pnm(data: bytes) -> Header:
    kind = data[1:2]
    if kind in b"14":
        return Header("PPM", 1, layout="grey")
    if kind == b"f":
        return Header("PPM", 32, "floating-point", "grey")
    # comments run to the end of their line; as blanks they leave everything at its place
    start = re.sub(rb"#[^\r\n]*", lambda comment: b" " * len(comment[0]), data[:10000])
    words = re.match(rb"P.\s+(\d+)\s+(\d+)\s+(\d+)\s", start)
    if words is None:
        raise ValueError("it has no size and largest number")
    width, height, largest = map(int, words.groups())
    if not 0 < largest < 1 << 16:
        raise ValueError(f"its largest number is {largest}, and can be 1 to 65535")
    if kind in b"56":
        _check_samples(data, words.end(), width * height * (3 if kind == b"6" else 1), largest)
    full = largest == (1 << largest.bit_length()) - 1
    return Header(
        "PPM",
        largest.bit_length() if largest > 255 else 8,
        layout="grey" if kind in b"25" else "RGB",
        largest=None if full else largest,
    )


def _check_samples(data: bytes, start: int, count: int, largest: int) -> None:
    """Refuse numbers larger than the header allows, which decoders would cut."""
    dtype = np.dtype(np.uint8 if largest < 256 else ">u2")
    there = min(count, (len(data) - start) // dtype.itemsize)
    found = int(np.frombuffer(data, dtype, there, start).max(initial=0))
    if found > largest:
        raise ValueError(f"it holds the number {found}, and its heading says {largest} at most")


def _sgi(data: bytes) -> Header:
    return Header("SGI", 8 * data[3], layout="grey" if data[10:12] == b"\0\1" else "colour")


def _jpeg2000(data: bytes) -> Header:
    # the codestream begins with the marker of its size
    start = data.index(b"\xff\x4f\xff\x51")
    if data.find(b"\xff\xd9", start) < 0:
        # no packet holds this pair of bytes
        raise EOFError("its codestream has no end")
    channels = int.from_bytes(data[start + 40 : start + 42], "big")
    depths = data[start + 42 : start + 42 + 3 * channels : 3]
    return Header(
        "JPEG2000",
        bits=max((depth & 0x7F) + 1 for depth in depths),
        number="signed" if any(depth & 0x80 for depth in depths) else "unsigned",
        layout="grey" if channels == 1 else "colour",
    )


def _avif(data: bytes) -> Header:
    # flags in the third byte of each picture's configuration: more than 8 bits, 12 bits, grey
    flags = [found[1][0] for found in re.finditer(rb"av1C..(.)", data, re.DOTALL)]
    bits = max({0x00: 8, 0x20: 8, 0x40: 10, 0x60: 12}[flag & 0x60] for flag in flags)
    return Header("AVIF", bits, layout="grey" if all(flag & 0x10 for flag in flags) else "colour")


def _always_8_bits(name: str) -> Callable[[bytes], Header]:
    return lambda data: Header(name)


_FORMATS: list[tuple[re.Pattern[bytes], Callable[[bytes], Header]]] = [
    (re.compile(magic, re.DOTALL), read)
    for magic, read in (
        (rb"\x89PNG\r\n\x1a\n", _png),
        (rb"\xff\xd8\xff", _jpeg),
        (rb"II[*+]\0|MM\0\*", _tiff),
        (rb"P[1-6f]\s", _pnm),
        (rb"BM", _always_8_bits("BMP")),
        (rb"GIF8[79]a", _always_8_bits("GIF")),
        (rb"RIFF....WEBP", _always_8_bits("WEBP")),
        (rb"\0\0\0\x0cjP  \r\n\x87\n|\xff\x4f\xff\x51", _jpeg2000),
        (rb"....ftyp(avis|.{0,40}avif)", _avif),
        (rb"\x01\xda[\0\1][\1\2]", _sgi),
    )
]
