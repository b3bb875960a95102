"""Every kind of image file with what is right for it: the table behind docs/inputs.md."""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from tests.image_files import (
    CMYK,
    FLOAT,
    GREY,
    GREY_ALPHA,
    PALETTE,
    RGB,
    RGB_ALPHA,
    SIGNED,
    TIFF_PALETTE,
    TIFF_RGB,
    WHITE_IS_ZERO,
    bmp,
    by_pillow,
    chunk,
    pgm,
    png,
    sgi,
    tiff,
)

PICTURES = Path(__file__).parent / "cornerstream" / "pictures"
"""Files that need encoders of their own, of the same picture."""

_Y, _X = np.mgrid[:18, :20]
RAMP = (_Y * 1721 + _X * 1613).astype(np.uint16)
"""18 rows of 20 pixels, no two alike however they are turned; all of its 16 bits count."""
RAMP8 = (RAMP >> 8).astype(np.uint8)
COLOUR = np.dstack([RAMP, 65535 - RAMP[::-1], RAMP[:, ::-1]])
COLOUR8 = (COLOUR >> 8).astype(np.uint8)
ALPHA8 = np.where(_X < 10, 255, 0).astype(np.uint8)

USED, NORMALIZED, REFUSED = "yes", "N", "no"
"""As it is or by its upper bits; with --normalize only; never."""


@dataclass(frozen=True)
class Case:
    """One file.

    ``grey`` are the right numbers, upright and of ``bits``, within ``within``; ``make`` takes what the format's
    writer takes beyond the picture, such as ``orientation``.
    """

    format: str
    layout: str
    depth: str
    outcome: str
    make: Callable[..., bytes]
    grey: NDArray[Any] = field(default_factory=lambda: RAMP8)
    bits: int = 8
    within: int = 0
    remarks: tuple[str, ...] = ()

    def __str__(self) -> str:
        return f"{self.format}-{self.layout}-{self.depth}".replace(" ", "_")


def levels(bits: int) -> NDArray[Any]:
    """The picture in fewer bits."""
    return RAMP >> (16 - bits)


def widened(narrow: NDArray[Any], bits: int) -> NDArray[Any]:
    """All ones become 255."""
    return (narrow.astype(np.uint16) * (255 // ((1 << bits) - 1))).astype(np.uint8)


def bt601(rgb: NDArray[Any]) -> NDArray[Any]:
    """Luma of 8-bit colour, rounded as by 16-bit weights."""
    weights = np.array([19595, 38470, 7471])
    return ((rgb.astype(np.uint32) @ weights + 32768) >> 16).astype(np.uint8)


def over_white(grey: NDArray[Any]) -> NDArray[Any]:
    """With the right half transparent."""
    return np.where(ALPHA8 == 0, 255, grey).astype(np.uint8)


def without(narrow: NDArray[Any], key: int, wide: NDArray[Any], white: int = 255) -> NDArray[Any]:
    """Pixels of one level become white."""
    return np.where(narrow == key, white, wide).astype(wide.dtype)


_BT601 = ("BT.601",)
_PALETTE = ("palette looked up", *_BT601)
_WHITE = ("laid over white",)
_PALETTE8 = bytes(np.dstack([np.arange(256)[::-1]] * 3).astype(np.uint8))
"""Greys, lightest first."""


def _png_cases() -> list[Case]:
    cases = []
    for bits in (1, 2, 4, 8, 16):
        narrow = levels(bits)
        wide = narrow if bits >= 8 else widened(narrow, bits)
        wide = wide.astype(np.uint16 if bits == 16 else np.uint8)
        depth, white = str(bits), 65535 if bits == 16 else 255
        one = ("1-bit image",) if bits == 1 else ()
        key = int(narrow[5, 5])
        alpha = chunk(b"tRNS", struct.pack(">H", key))
        cases += [
            Case("PNG", "grey", depth, USED, _PNG(narrow, bits), wide, max(bits, 8), remarks=one),
            Case(
                *("PNG", "grey, one level transparent", depth, USED),
                _PNG(narrow, bits, GREY, alpha),
                without(narrow, key, wide, white),
                max(bits, 8),
                remarks=(*one, *_WHITE),
            ),
        ]
        if bits < 16:
            inverse = ((1 << bits) - 1 - narrow).astype(np.uint8)
            table = chunk(b"PLTE", _PALETTE8[: 3 << bits] if bits == 8 else _grey_palette(bits))
            hidden = int(inverse[5, 5])
            absent = chunk(b"tRNS", b"\xff" * hidden + b"\0")
            cases += [
                Case(
                    "PNG", "palette", depth, USED, _PNG(inverse, bits, PALETTE, table), wide, remarks=_PALETTE
                ),
                Case(
                    *("PNG", "palette, one colour transparent", depth, USED),
                    _PNG(inverse, bits, PALETTE, table + absent),
                    without(inverse, hidden, wide),
                    remarks=(_PALETTE[0], *_WHITE, *_BT601),
                ),
            ]
    key8 = COLOUR8[5, 5]
    hole = np.where((COLOUR8 == key8).all(2), 255, bt601(COLOUR8)).astype(np.uint8)
    cases += [
        Case("PNG", "RGB", "8", USED, _PNG(COLOUR8, 8, RGB), bt601(COLOUR8), remarks=_BT601),
        Case("PNG", "RGB", "16", REFUSED, _PNG(COLOUR, 16, RGB)),
        Case(
            *("PNG", "RGB, one colour transparent", "8", USED),
            _PNG(COLOUR8, 8, RGB, chunk(b"tRNS", struct.pack(">3H", *key8.tolist()))),
            hole,
            remarks=(*_WHITE, *_BT601),
        ),
        Case(
            "PNG",
            "RGB, one colour transparent",
            "16",
            REFUSED,
            _PNG(COLOUR, 16, RGB, chunk(b"tRNS", bytes(6))),
        ),
        Case(
            *("PNG", "grey with alpha", "8", USED),
            _PNG(np.dstack([RAMP8, ALPHA8]), 8, GREY_ALPHA),
            over_white(RAMP8),
            remarks=_WHITE,
        ),
        Case("PNG", "grey with alpha", "16", REFUSED, _PNG(COLOUR[..., :2], 16, GREY_ALPHA)),
        Case(
            *("PNG", "RGB with alpha", "8", USED),
            _PNG(np.dstack([COLOUR8, ALPHA8]), 8, RGB_ALPHA),
            over_white(bt601(COLOUR8)),
            remarks=(*_WHITE, *_BT601),
        ),
        Case("PNG", "RGB with alpha", "16", REFUSED, _PNG(np.dstack([COLOUR, RAMP]), 16, RGB_ALPHA)),
    ]
    return cases


def _grey_palette(bits: int) -> bytes:
    most = (1 << bits) - 1
    return b"".join(bytes([(most - level) * (255 // most)] * 3) for level in range(most + 1))


class _PNG:
    """Makes a PNG; ``before`` of the call comes ahead of the case's own chunks."""

    def __init__(self, samples: NDArray[Any], bits: int, colour: int = GREY, chunks: bytes = b"") -> None:
        self._arguments = samples, bits, colour
        self._chunks = chunks

    def __call__(self, turned: Callable[[Any], Any] = lambda samples: samples, before: bytes = b"") -> bytes:
        samples, bits, colour = self._arguments
        return png(turned(samples), bits, colour, before + self._chunks)


class _TIFF:
    """Makes a TIFF with what the call says of its layout."""

    def __init__(self, samples: NDArray[Any], bits: int, photometric: int = 1, **fixed: Any) -> None:
        self._arguments = samples, bits, photometric
        self._fixed = fixed

    def __call__(self, turned: Callable[[Any], Any] = lambda samples: samples, **how: Any) -> bytes:
        samples, bits, photometric = self._arguments
        return tiff(turned(samples), bits, photometric, **self._fixed, **how)


def _tiff_cases() -> list[Case]:
    cases = []
    for bits in (1, 2, 4, 8, 16):
        narrow = levels(bits).astype(np.uint16 if bits == 16 else np.uint8)
        wide = narrow if bits >= 8 else widened(narrow, bits)
        inverse = ((1 << bits) - 1 - narrow).astype(narrow.dtype)
        one = ("1-bit image",) if bits == 1 else ()
        for layout, samples, photometric in (
            ("grey", narrow, 1),
            ("grey, white is zero", inverse, WHITE_IS_ZERO),
        ):
            make = _TIFF(samples, bits, photometric)
            cases.append(Case("TIFF", layout, str(bits), USED, make, wide, max(bits, 8), remarks=one))
        if bits < 16:
            table = [level * 65535 // ((1 << bits) - 1) for level in range(1 << bits)][::-1] * 3
            make = _TIFF(inverse, bits, TIFF_PALETTE, palette=table)
            cases.append(Case("TIFF", "palette", str(bits), USED, make, wide, remarks=_PALETTE))
    deep = np.rint(np.tensordot((0.299, 0.587, 0.114), COLOUR.astype(float), (0, 2))).astype(np.uint16)
    black = np.dstack([COLOUR8[..., 0], RAMP8 // 3, RAMP8 * 0, 255 - RAMP8])
    ink = [np.rint((255.0 - black[..., 3]) * (255 - black[..., k]) / 255) for k in range(3)]
    cases += [
        Case("TIFF", "grey", "10", REFUSED, _TIFF(levels(10), 10)),
        Case("TIFF", "grey", "12", USED, _TIFF(levels(12), 12), levels(12), 12),
        Case("TIFF", "RGB", "10", REFUSED, _TIFF(COLOUR >> 6, 10, TIFF_RGB)),
        Case("TIFF", "RGB", "12", REFUSED, _TIFF(COLOUR >> 4, 12, TIFF_RGB)),
        Case("TIFF", "RGB", "8", USED, _TIFF(COLOUR8, 8, TIFF_RGB), bt601(COLOUR8), remarks=_BT601),
        Case("TIFF", "RGB", "16", USED, _TIFF(COLOUR, 16, TIFF_RGB), deep, 16, remarks=_BT601),
        Case(
            *("TIFF", "grey with alpha", "8", USED),
            _TIFF(np.dstack([RAMP8, ALPHA8]), 8, extra=2),
            over_white(RAMP8),
            remarks=_WHITE,
        ),
        Case("TIFF", "grey with alpha", "16", REFUSED, _TIFF(COLOUR[..., :2], 16, extra=2)),
        Case(
            *("TIFF", "RGB with alpha", "8", USED),
            _TIFF(np.dstack([COLOUR8, ALPHA8]), 8, TIFF_RGB, extra=2),
            over_white(bt601(COLOUR8)),
            remarks=(*_WHITE, *_BT601),
        ),
        Case(
            "TIFF", "RGB with alpha", "16", REFUSED, _TIFF(np.dstack([COLOUR, RAMP]), 16, TIFF_RGB, extra=2)
        ),
        Case(
            "TIFF", "CMYK", "8", USED, _TIFF(black, 8, CMYK), bt601(np.dstack(ink)), within=1, remarks=_BT601
        ),
        Case("TIFF", "CMYK", "16", REFUSED, _TIFF(np.dstack([COLOUR, RAMP]), 16, CMYK)),
    ]
    signed = RAMP.astype(np.int32) - 32768
    real = (RAMP / 977 - 20).astype(np.float32)
    planes = [COLOUR.astype(np.int32) - 32768, (COLOUR / 977 - 20).astype(np.float32)]
    luma = [np.tensordot((0.299, 0.587, 0.114), plane.astype(float), (0, 2)) for plane in planes]
    long = RAMP.astype(np.uint32) * 65537
    cases += [
        Case("TIFF", "grey", "32", NORMALIZED, _TIFF(long, 32), long),
        Case(
            "TIFF",
            "grey",
            "signed",
            NORMALIZED,
            _TIFF((signed >> 8).astype(np.int8), 8, number=SIGNED),
            signed >> 8,
        ),
        Case("TIFF", "grey", "signed", NORMALIZED, _TIFF(signed.astype(np.int16), 16, number=SIGNED), signed),
        Case("TIFF", "grey", "signed", NORMALIZED, _TIFF(signed * 65536, 32, number=SIGNED), signed * 65536),
        Case(
            "TIFF",
            "grey",
            "float",
            NORMALIZED,
            _TIFF(real.astype(np.float16), 16, number=FLOAT),
            real.astype("f2"),
        ),
        Case("TIFF", "grey", "float", NORMALIZED, _TIFF(real, 32, number=FLOAT), real),
        Case("TIFF", "grey", "float", NORMALIZED, _TIFF(real.astype(float), 64, number=FLOAT), real),
        Case("TIFF", "grey, white is zero", "float", REFUSED, _TIFF(real, 32, WHITE_IS_ZERO, number=FLOAT)),
        Case(
            "TIFF", "grey, white is zero", "signed", REFUSED, _TIFF(signed, 32, WHITE_IS_ZERO, number=SIGNED)
        ),
        Case(
            *("TIFF", "RGB", "signed", NORMALIZED),
            _TIFF(planes[0].astype(np.int16), 16, TIFF_RGB, number=SIGNED),
            np.rint(luma[0]),
            remarks=_BT601,
        ),
        Case(
            "TIFF",
            "RGB",
            "float",
            NORMALIZED,
            _TIFF(planes[1], 32, TIFF_RGB, number=FLOAT),
            luma[1],
            remarks=_BT601,
        ),
    ]
    return cases


def _pnm_cases() -> list[Case]:
    bits = (RAMP8 < 128).astype(np.uint8)
    one = b"P4 20 18\n" + np.packbits(bits, axis=1).tobytes()
    plain = b"P1 20 18\n" + "\n".join(" ".join(map(str, row)) for row in bits.tolist()).encode() + b"\n"
    cases = [
        Case("PGM, PPM", "grey", "1", USED, lambda: one, widened(1 - bits, 1), remarks=("1-bit image",)),
        Case("PGM, PPM", "grey", "1", USED, lambda: plain, widened(1 - bits, 1), remarks=("1-bit image",)),
        Case("PGM, PPM", "RGB", "8", USED, lambda: pgm(COLOUR8, 255), bt601(COLOUR8), remarks=_BT601),
        Case("PGM, PPM", "RGB", "16", REFUSED, lambda: pgm(COLOUR, 65535)),
        Case("PGM, PPM", "RGB", "10", REFUSED, lambda: pgm(COLOUR >> 6, 1023)),
        Case("PGM, PPM", "RGB", "12", REFUSED, lambda: pgm(COLOUR >> 4, 4095)),
    ]
    for depth in (2, 4, 8, 10, 12, 16):
        narrow, largest = levels(depth), (1 << depth) - 1
        wide = narrow if depth >= 8 else widened(narrow, depth)
        for as_text in (False, True):
            cases.append(
                Case(
                    *("PGM, PPM", "grey", str(depth), USED),
                    lambda narrow=narrow, largest=largest, as_text=as_text: pgm(
                        narrow, largest, plain=as_text
                    ),
                    wide,
                    max(depth, 8),
                )
            )
    real = (RAMP / 977 - 20).astype("<f4")
    cases.append(
        Case(
            "PGM, PPM", "grey", "float", NORMALIZED, lambda: b"Pf\n20 18\n-1.0\n" + real[::-1].tobytes(), real
        )
    )
    return cases


def _bmp_cases() -> list[Case]:
    def rows(samples: NDArray[Any], bits: int) -> bytes:
        padded = np.pad(samples, ((0, 0), (0, -20 * bits % 32 // bits)))[::-1]
        places = np.arange(bits)[::-1]
        return np.packbits(
            (padded[..., None] >> places & 1).reshape(18, -1).astype(np.uint8), axis=1
        ).tobytes()

    cases = []
    for bits in (1, 4, 8):
        inverse = ((1 << bits) - 1 - levels(bits)).astype(np.uint8)
        table = [level * (255 // ((1 << bits) - 1)) for level in range(1 << bits)][::-1]
        content = bmp(rows(inverse, bits), (20, 18), bits, table)
        wide = widened(levels(bits), bits) if bits < 8 else RAMP8
        cases.append(
            Case("BMP", "palette", str(bits), USED, lambda content=content: content, wide, remarks=_PALETTE)
        )
    return [
        *cases,
        Case("BMP", "grey", "8", USED, lambda: by_pillow(RAMP8, "BMP")),
        Case("BMP", "RGB", "8", USED, lambda: by_pillow(COLOUR8, "BMP"), bt601(COLOUR8), remarks=_BT601),
    ]


def _alpha(grey: bool = False) -> NDArray[np.uint8]:
    return np.dstack([RAMP8, ALPHA8] if grey else [COLOUR8, ALPHA8])


def _lossy_cases() -> list[Case]:
    """What Pillow writes best; JPEG and AVIF come back a little different."""
    soft = np.dstack([RAMP8, 255 - RAMP8, RAMP8 // 2])
    whole = {"quality": 100, "subsampling": 0}
    avif = {"quality": 100, "subsampling": "4:4:4"}
    cmyk = np.dstack([RAMP8 * 0] * 3 + [255 - RAMP8])

    def twelve(picture: NDArray[Any], channels: int) -> bytes:
        # a start of frame that says 12 bits
        start = b"\xff\xc0\x00" + bytes((8 + 3 * channels,))
        return by_pillow(picture, "JPEG").replace(start + b"\x08", start + b"\x0c")

    return [
        Case("JPEG", "grey", "8", USED, lambda **o: by_pillow(RAMP8, "JPEG", **whole, **o), within=3),
        Case("JPEG", "grey", "12", REFUSED, lambda: twelve(RAMP8, 1)),
        Case("JPEG", "RGB", "12", REFUSED, lambda: twelve(soft, 3)),
        Case(
            *("JPEG", "RGB", "8", USED),
            lambda **o: by_pillow(soft, "JPEG", **whole, **o),
            bt601(soft),
            within=3,
            remarks=_BT601,
        ),
        Case(
            *("JPEG", "CMYK", "8", USED),
            lambda **o: by_pillow(
                Image.frombytes("CMYK", (20, 18), cmyk.tobytes()), "JPEG", quality=100, **o
            ),
            within=3,
            remarks=_BT601,
        ),
        Case(
            *("WebP", "RGB", "8", USED),
            lambda **o: by_pillow(COLOUR8, "WEBP", lossless=True, **o),
            bt601(COLOUR8),
            remarks=_BT601,
        ),
        Case(
            *("WebP", "RGB with alpha", "8", USED),
            lambda **o: by_pillow(_alpha(), "WEBP", lossless=True, exact=True, **o),
            over_white(bt601(COLOUR8)),
            remarks=(*_WHITE, *_BT601),
        ),
        Case("AVIF", "grey", "8", USED, lambda **o: by_pillow(RAMP8, "AVIF", quality=100, **o), within=3),
        Case(
            *("AVIF", "RGB", "8", USED),
            lambda **o: by_pillow(soft, "AVIF", **avif, **o),
            bt601(soft),
            within=4,
            remarks=_BT601,
        ),
        Case(
            *("AVIF", "RGB with alpha", "8", USED),
            lambda **o: by_pillow(np.dstack([soft, ALPHA8]), "AVIF", **avif, **o),
            over_white(bt601(soft)),
            within=4,
            remarks=(*_WHITE, *_BT601),
        ),
        Case("AVIF", "grey", "10", REFUSED, (PICTURES / "grey10.avif").read_bytes),
        Case("AVIF", "grey", "12", REFUSED, (PICTURES / "grey12.avif").read_bytes),
    ]


def _other_cases() -> list[Case]:
    palette = Image.frombytes("P", (20, 18), (255 - RAMP8).tobytes())
    palette.putpalette(_PALETTE8)
    key = int(255 - RAMP8[5, 5])
    signed = RAMP.astype(np.int32) - 32768
    return [
        Case("GIF", "palette", "8", USED, lambda: by_pillow(palette, "GIF"), remarks=_PALETTE),
        Case(
            *("GIF", "palette, one colour transparent", "8", USED),
            lambda: by_pillow(palette, "GIF", transparency=key, optimize=False),
            without(255 - RAMP8, key, RAMP8),
            remarks=(_PALETTE[0], *_WHITE, *_BT601),
        ),
        Case("JPEG 2000", "grey", "4", USED, (PICTURES / "grey4.j2k").read_bytes, levels(4), 4),
        Case("JPEG 2000", "grey", "8", USED, lambda: by_pillow(RAMP8, "JPEG2000")),
        Case("JPEG 2000", "grey", "10", USED, (PICTURES / "grey10.j2k").read_bytes, levels(10), 10),
        Case("JPEG 2000", "grey", "12", USED, (PICTURES / "grey12.j2k").read_bytes, levels(12), 12),
        Case("JPEG 2000", "grey", "16", USED, lambda: by_pillow(RAMP, "JPEG2000"), RAMP, 16),
        Case("JPEG 2000", "grey", "signed", NORMALIZED, (PICTURES / "signed8.j2k").read_bytes, signed >> 8),
        Case("JPEG 2000", "grey", "signed", NORMALIZED, (PICTURES / "signed16.j2k").read_bytes, signed),
        Case(
            "JPEG 2000",
            "RGB",
            "8",
            USED,
            lambda: by_pillow(COLOUR8, "JPEG2000"),
            bt601(COLOUR8),
            remarks=_BT601,
        ),
        *(
            Case(
                "JPEG 2000",
                "RGB",
                str(bits),
                REFUSED,
                lambda bits=bits: _deepened(by_pillow(COLOUR8, "JPEG2000"), bits),
            )
            for bits in (10, 12, 16)
        ),
        Case(
            *("JPEG 2000", "RGB with alpha", "8", USED),
            lambda: by_pillow(_alpha(), "JPEG2000"),
            over_white(bt601(COLOUR8)),
            remarks=(*_WHITE, *_BT601),
        ),
        Case("SGI", "grey", "8", USED, lambda: sgi(RAMP8)),
        Case("SGI", "grey", "16", REFUSED, lambda: sgi(RAMP)),
    ]


def _deepened(content: bytes, bits: int) -> bytes:
    """A JPEG 2000 of three channels whose codestream says that they are so deep."""
    depths = content.index(b"\xff\x4f\xff\x51") + 42
    return content[:depths] + bytes((bits - 1, 1, 1)) * 3 + content[depths + 9 :]


CASES = [*_png_cases(), *_tiff_cases(), *_lossy_cases(), *_other_cases(), *_bmp_cases(), *_pnm_cases()]
DEPTHS = ("1", "2", "4", "8", "10", "12", "16", "32", "signed", "float")


def table() -> list[str]:
    """The page's table: what becomes of each depth, by format and layout."""
    found: dict[tuple[str, str], dict[str, str]] = {}
    for case in CASES:
        kinds = found.setdefault((case.format, case.layout), {})
        assert kinds.setdefault(case.depth, case.outcome) == case.outcome, case
    head = f"| format | pixels | {' | '.join(DEPTHS)} |"
    rows = [
        f"| {name} | {layout} | {' | '.join(kinds.get(depth, '–') for depth in DEPTHS)} |"
        for (name, layout), kinds in found.items()
    ]
    return [head, "|---|---|" + ":---:|" * len(DEPTHS), *rows]
