"""Image files made on the fly: every depth, layout and tag that Pillow itself cannot write."""

from __future__ import annotations

import io
import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

Samples = NDArray[Any]

GREY, RGB, PALETTE, GREY_ALPHA, RGB_ALPHA = 0, 2, 3, 4, 6
"""Colour types of PNG."""
WHITE_IS_ZERO, BLACK_IS_ZERO, TIFF_RGB, TIFF_PALETTE, CMYK = 0, 1, 2, 3, 5
"""Photometric interpretations of TIFF."""
UNSIGNED, SIGNED, FLOAT = 1, 2, 3
"""Sample formats of TIFF."""


def packed(samples: Samples, bits: int, order: str = ">") -> bytes:
    """Rows of samples, each from a whole byte; ``order`` is the byte order of large samples.

    ``samples`` is (height, samples per row).
    """
    if bits % 8 == 0:
        return samples.astype(samples.dtype.newbyteorder(order)).tobytes()
    places = np.arange(bits)[::-1]
    row = (samples[..., None].astype(np.uint32) >> places & 1).reshape(len(samples), -1)
    return np.packbits(row.astype(np.uint8), axis=1).tobytes()


def chunk(kind: bytes, content: bytes) -> bytes:
    """A chunk of a PNG file."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def png(samples: Samples, bits: int, colour: int = GREY, before: bytes = b"", after: bytes = b"") -> bytes:
    """PNG of (height, width[, channels]) samples, with chunks before and after the pixels'."""
    height, width = samples.shape[:2]
    rows = packed(samples.reshape(height, -1).astype(np.uint16 if bits == 16 else np.uint8), bits)
    stride = len(rows) // height
    lines = b"".join(b"\0" + rows[place : place + stride] for place in range(0, len(rows), stride))
    heading = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, 0)
    content = chunk(b"IHDR", heading) + before + chunk(b"IDAT", zlib.compress(lines)) + after
    return b"\x89PNG\r\n\x1a\n" + content + chunk(b"IEND", b"")


def exif(orientation: int) -> bytes:
    """The least EXIF there is: one tag."""
    return b"MM\0*\0\0\0\x08" + struct.pack(">HHHIHHI", 1, 0x112, 3, 1, orientation, 0, 0)


def tiff(
    samples: Samples,
    bits: int,
    photometric: int = BLACK_IS_ZERO,
    *,
    number: int = UNSIGNED,
    order: str = "<",
    planar: bool = False,
    strips: int = 1,
    deflate: bool = False,
    orientation: int = 1,
    extra: int | None = None,
    palette: list[int] | None = None,
) -> bytes:
    """TIFF of (height, width[, channels]) samples, the pixels behind the directory.

    ``number`` is the sample format; ``extra`` what the samples beyond the colour's are; ``palette``
    all reds, greens and blues, 16 bits each.
    """
    samples = samples.reshape(*samples.shape[:2], -1)
    height, width, channels = samples.shape
    planes = [samples[..., [k]] for k in range(channels)] if planar else [samples]
    rows = -(-height // strips)
    parts = [
        packed(plane[top : top + rows].reshape(len(plane[top : top + rows]), -1), bits, order)
        for plane in planes
        for top in range(0, height, rows)
    ]
    if deflate:
        parts = [zlib.compress(part) for part in parts]
    tags: dict[int, list[int]] = {
        256: [width],
        257: [height],
        258: [bits] * channels,
        259: [8 if deflate else 1],
        262: [photometric],
        273: [0] * len(parts),
        274: [orientation],
        277: [channels],
        278: [rows],
        279: [len(part) for part in parts],
        284: [2 if planar else 1],
    }
    if palette:
        tags[320] = palette
    if extra is not None:
        tags[338] = [extra]
    tags[339] = [number] * channels
    place = 8 + 2 + 12 * len(tags) + 4
    pixels = place + sum(4 * len(values) for values in tags.values() if len(values) > 1)
    tags[273] = [pixels + sum(map(len, parts[:number_])) for number_ in range(len(parts))]
    entries, beyond = b"", b""
    for tag, values in sorted(tags.items()):
        # numbers of 16 bits and of 32 are both allowed in sizes and offsets; those of bits and
        # palette are 16
        kind, letter = (4, "I") if tag in (256, 257, 273, 278, 279) else (3, "H")
        content = struct.pack(f"{order}{len(values)}{letter}", *values)
        if len(content) > 4:
            content += bytes(4 * len(values) - len(content))
            value = struct.pack(f"{order}I", place + len(beyond))
            beyond += content
        else:
            value = content.ljust(4, b"\0")
        entries += struct.pack(f"{order}HHI", tag, kind, len(values)) + value
    beyond = beyond.ljust(pixels - place, b"\0")
    head = (b"II*\0" if order == "<" else b"MM\0*") + struct.pack(f"{order}IH", 8, len(tags))
    return head + entries + bytes(4) + beyond + b"".join(parts)


def pgm(samples: Samples, largest: int, *, plain: bool = False) -> bytes:
    """PGM, or PPM of three channels, with a comment in its heading."""
    height, width = samples.shape[:2]
    kind = (2 if plain else 5) + (samples.ndim == 3)
    heading = f"P{kind}\n# made by hand\n{width} {height}\n{largest}\n".encode()
    if plain:
        return heading + " ".join(map(str, samples.ravel().tolist())).encode() + b"\n"
    return heading + samples.astype(">u2" if largest > 255 else "u1").tobytes()


def sgi(samples: Samples) -> bytes:
    """SGI, grey, not compressed, of uint8 or uint16."""
    height, width = samples.shape
    heading = struct.pack(">HBBHHHHII", 474, 0, samples.itemsize, 2, width, height, 1, 0, samples.max())
    return heading.ljust(512, b"\0") + samples[::-1].astype(samples.dtype.newbyteorder(">")).tobytes()


def by_pillow(image: Image.Image | Samples, kind: str, **options: Any) -> bytes:
    """What Pillow writes."""
    file = io.BytesIO()
    (image if isinstance(image, Image.Image) else Image.fromarray(image)).save(file, kind, **options)
    return file.getvalue()


def bmp(rows: bytes, size: tuple[int, int], bits: int, palette: list[int], masks: bytes = b"") -> bytes:
    """BMP, not compressed; ``rows`` from the lowest one up, of a multiple of 4 bytes each.

    ``palette`` is of greys; ``masks`` are those of red, green and blue, where 16 bits hold all
    three.
    """
    colours = b"".join(bytes((level, level, level, 0)) for level in palette)
    place = 14 + 40 + len(masks) + len(colours)
    heading = struct.pack(
        "<IiiHHIIiiII", 40, *size, 1, bits, 3 if masks else 0, len(rows), 0, 0, len(palette), 0
    )
    return struct.pack("<2sIHHI", b"BM", place + len(rows), 0, 0, place) + heading + masks + colours + rows
