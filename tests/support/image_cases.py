"""Every kind of image file with what is right for it: the table behind docs/reference/inputs.md."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

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
from tests.support.image_cases_deep import png_cases, tiff_cases
from tests.support.image_files import (
    bmp,
    by_pillow,
    pgm,
    sgi,
)

PICTURES = Path(__file__).parents[1] / "cornerstream" / "pictures"
"""Files that need encoders of their own, of the same picture."""


def _pnm_cases() -> list[Case]:
    bits = (RAMP8 < 128).astype(np.uint8)
    one = b"P4 20 18\n" + np.packbits(bits, axis=1).tobytes()
    plain = b"P1 20 18\n" + "\n".join(" ".join(map(str, row)) for row in bits.tolist()).encode() + b"\n"
    cases = [
        Case("PGM, PPM", "grey", "1", USED, lambda: one, widened(1 - bits, 1), remarks=("1-bit image",)),
        Case("PGM, PPM", "grey", "1", USED, lambda: plain, widened(1 - bits, 1), remarks=("1-bit image",)),
        Case("PGM, PPM", "RGB", "8", USED, lambda: pgm(COLOUR8, 255), bt601(COLOUR8), remarks=GREYED),
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
            Case("BMP", "palette", str(bits), USED, lambda content=content: content, wide, remarks=LOOKED_UP)
        )
    return [
        *cases,
        Case("BMP", "grey", "8", USED, lambda: by_pillow(RAMP8, "BMP")),
        Case("BMP", "RGB", "8", USED, lambda: by_pillow(COLOUR8, "BMP"), bt601(COLOUR8), remarks=GREYED),
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
            remarks=GREYED,
        ),
        Case(
            *("JPEG", "CMYK", "8", USED),
            lambda **o: by_pillow(
                Image.frombytes("CMYK", (20, 18), cmyk.tobytes()), "JPEG", quality=100, **o
            ),
            within=3,
            remarks=GREYED,
        ),
        Case(
            *("WebP", "RGB", "8", USED),
            lambda **o: by_pillow(COLOUR8, "WEBP", lossless=True, **o),
            bt601(COLOUR8),
            remarks=GREYED,
        ),
        Case(
            *("WebP", "RGB with alpha", "8", USED),
            lambda **o: by_pillow(_alpha(), "WEBP", lossless=True, exact=True, **o),
            over_white(bt601(COLOUR8)),
            remarks=(*LAID, *GREYED),
        ),
        Case("AVIF", "grey", "8", USED, lambda **o: by_pillow(RAMP8, "AVIF", quality=100, **o), within=3),
        Case(
            *("AVIF", "RGB", "8", USED),
            lambda **o: by_pillow(soft, "AVIF", **avif, **o),
            bt601(soft),
            within=4,
            remarks=GREYED,
        ),
        Case(
            *("AVIF", "RGB with alpha", "8", USED),
            lambda **o: by_pillow(np.dstack([soft, ALPHA8]), "AVIF", **avif, **o),
            over_white(bt601(soft)),
            within=4,
            remarks=(*LAID, *GREYED),
        ),
        Case("AVIF", "grey", "10", REFUSED, (PICTURES / "grey10.avif").read_bytes),
        Case("AVIF", "grey", "12", REFUSED, (PICTURES / "grey12.avif").read_bytes),
    ]


def _other_cases() -> list[Case]:
    palette = Image.frombytes("P", (20, 18), (255 - RAMP8).tobytes())
    palette.putpalette(DARKENING)
    key = int(255 - RAMP8[5, 5])
    signed = RAMP.astype(np.int32) - 32768
    return [
        Case("GIF", "palette", "8", USED, lambda: by_pillow(palette, "GIF"), remarks=LOOKED_UP),
        Case(
            *("GIF", "palette, one colour transparent", "8", USED),
            lambda: by_pillow(palette, "GIF", transparency=key, optimize=False),
            without(255 - RAMP8, key, RAMP8),
            remarks=(LOOKED_UP[0], *LAID, *GREYED),
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
            remarks=GREYED,
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
            remarks=(*LAID, *GREYED),
        ),
        Case("SGI", "grey", "8", USED, lambda: sgi(RAMP8)),
        Case("SGI", "grey", "16", REFUSED, lambda: sgi(RAMP)),
    ]


def _deepened(content: bytes, bits: int) -> bytes:
    """A JPEG 2000 of three channels whose codestream says that they are so deep."""
    depths = content.index(b"\xff\x4f\xff\x51") + 42
    return content[:depths] + bytes((bits - 1, 1, 1)) * 3 + content[depths + 9 :]


CASES = [*png_cases(), *tiff_cases(), *_lossy_cases(), *_other_cases(), *_bmp_cases(), *_pnm_cases()]
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
