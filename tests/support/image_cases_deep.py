"""PNG and TIFF of every kind."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tests.support.image_case import (
    ALPHA8,
    COLOUR,
    COLOUR8,
    DARKENING,
    GREYED,
    LAID,
    LOOKED_UP,
    NORMALIZED,
    RAMP,
    RAMP8,
    REFUSED,
    USED,
    Case,
    bt601,
    levels,
    over_white,
    widened,
    without,
)
from tests.support.image_files import (
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
    chunk,
    png,
    tiff,
)


def png_cases() -> list[Case]:
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
                remarks=(*one, *LAID),
            ),
        ]
        if bits < 16:
            inverse = ((1 << bits) - 1 - narrow).astype(np.uint8)
            table = chunk(b"PLTE", DARKENING[: 3 << bits] if bits == 8 else _grey_palette(bits))
            hidden = int(inverse[5, 5])
            absent = chunk(b"tRNS", b"\xff" * hidden + b"\0")
            cases += [
                Case(
                    "PNG",
                    "palette",
                    depth,
                    USED,
                    _PNG(inverse, bits, PALETTE, table),
                    wide,
                    remarks=LOOKED_UP,
                ),
                Case(
                    *("PNG", "palette, one colour transparent", depth, USED),
                    _PNG(inverse, bits, PALETTE, table + absent),
                    without(inverse, hidden, wide),
                    remarks=(LOOKED_UP[0], *LAID, *GREYED),
                ),
            ]
    key8 = COLOUR8[5, 5]
    hole = np.where((COLOUR8 == key8).all(2), 255, bt601(COLOUR8)).astype(np.uint8)
    cases += [
        Case("PNG", "RGB", "8", USED, _PNG(COLOUR8, 8, RGB), bt601(COLOUR8), remarks=GREYED),
        Case("PNG", "RGB", "16", REFUSED, _PNG(COLOUR, 16, RGB)),
        Case(
            *("PNG", "RGB, one colour transparent", "8", USED),
            _PNG(COLOUR8, 8, RGB, chunk(b"tRNS", struct.pack(">3H", *key8.tolist()))),
            hole,
            remarks=(*LAID, *GREYED),
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
            remarks=LAID,
        ),
        Case("PNG", "grey with alpha", "16", REFUSED, _PNG(COLOUR[..., :2], 16, GREY_ALPHA)),
        Case(
            *("PNG", "RGB with alpha", "8", USED),
            _PNG(np.dstack([COLOUR8, ALPHA8]), 8, RGB_ALPHA),
            over_white(bt601(COLOUR8)),
            remarks=(*LAID, *GREYED),
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


def tiff_cases() -> list[Case]:
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
            cases.append(Case("TIFF", "palette", str(bits), USED, make, wide, remarks=LOOKED_UP))
    deep = np.rint(np.tensordot((0.299, 0.587, 0.114), COLOUR.astype(float), (0, 2))).astype(np.uint16)
    black = np.dstack([COLOUR8[..., 0], RAMP8 // 3, RAMP8 * 0, 255 - RAMP8])
    ink = [np.rint((255.0 - black[..., 3]) * (255 - black[..., k]) / 255) for k in range(3)]
    cases += [
        Case("TIFF", "grey", "10", REFUSED, _TIFF(levels(10), 10)),
        Case("TIFF", "grey", "12", USED, _TIFF(levels(12), 12), levels(12), 12),
        Case("TIFF", "RGB", "10", REFUSED, _TIFF(COLOUR >> 6, 10, TIFF_RGB)),
        Case("TIFF", "RGB", "12", REFUSED, _TIFF(COLOUR >> 4, 12, TIFF_RGB)),
        Case("TIFF", "RGB", "8", USED, _TIFF(COLOUR8, 8, TIFF_RGB), bt601(COLOUR8), remarks=GREYED),
        Case("TIFF", "RGB", "16", USED, _TIFF(COLOUR, 16, TIFF_RGB), deep, 16, remarks=GREYED),
        Case(
            *("TIFF", "grey with alpha", "8", USED),
            _TIFF(np.dstack([RAMP8, ALPHA8]), 8, extra=2),
            over_white(RAMP8),
            remarks=LAID,
        ),
        Case("TIFF", "grey with alpha", "16", REFUSED, _TIFF(COLOUR[..., :2], 16, extra=2)),
        Case(
            *("TIFF", "RGB with alpha", "8", USED),
            _TIFF(np.dstack([COLOUR8, ALPHA8]), 8, TIFF_RGB, extra=2),
            over_white(bt601(COLOUR8)),
            remarks=(*LAID, *GREYED),
        ),
        Case(
            "TIFF", "RGB with alpha", "16", REFUSED, _TIFF(np.dstack([COLOUR, RAMP]), 16, TIFF_RGB, extra=2)
        ),
        Case(
            "TIFF", "CMYK", "8", USED, _TIFF(black, 8, CMYK), bt601(np.dstack(ink)), within=1, remarks=GREYED
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
            remarks=GREYED,
        ),
        Case(
            "TIFF",
            "RGB",
            "float",
            NORMALIZED,
            _TIFF(planes[1], 32, TIFF_RGB, number=FLOAT),
            luma[1],
            remarks=GREYED,
        ),
    ]
    return cases
