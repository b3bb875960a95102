"""What the pages on records and on missing corners state as fact is recomputed here."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from cornerstream import Parameters, Settings, detect
from golden.corners import Flag
from golden.output_constructor import (
    COORDINATE_BITS,
    COUNT_BITS,
    FLAG_SHIFT,
    FRAME_BITS,
    RESPONSE_FIELD_BITS,
    RESPONSE_SHIFT,
    TIME_BITS,
    TIME_RECORD,
)

DOCS = Path(__file__).parents[1] / "docs"
RECORD = (DOCS / "reference" / "record.md").read_text(encoding="utf-8")
NO_CORNERS = (DOCS / "howto" / "no-corners.md").read_text(encoding="utf-8")


def bits(low: int, width: int) -> str:
    return f"{low + width - 1}:{low}" if width > 1 else str(low)


def fields(title: str) -> dict[str, str]:
    """Bits and field of each row of the table below that heading."""
    section = RECORD.split(f"# {title}\n")[1].split("\n## ")[0]
    return dict(re.findall(r"^\| ([\d:]+) \| ([a-z ]+) \|", section, re.MULTILINE))


def test_bits_of_the_record() -> None:
    told = fields("The record")
    flags = {bits(FLAG_SHIFT + place, 1): flag.name for place, flag in enumerate(Flag)}
    assert told == {
        bits(0, COORDINATE_BITS): "x",
        bits(COORDINATE_BITS, COORDINATE_BITS): "y",
        bits(RESPONSE_SHIFT, RESPONSE_FIELD_BITS): "response",
        **{place: str(name).lower().replace("_", " ") for place, name in flags.items()},
    }


def test_bits_of_the_end_of_frame() -> None:
    assert fields("The end-of-frame record") == {
        bits(0, COUNT_BITS): "records",
        bits(COUNT_BITS, FRAME_BITS): "frame",
        bits(RESPONSE_SHIFT, RESPONSE_FIELD_BITS): "largest response",
        bits(FLAG_SHIFT, 2): "both set",
        bits(FLAG_SHIFT + 2, 1): "cut",
    }


def test_bits_of_the_time_record() -> None:
    assert TIME_RECORD == 0b1111
    assert fields("The time record") == {bits(0, TIME_BITS): "time", bits(TIME_BITS, 4): "all set"}


@pytest.mark.parametrize(
    ("profile", "sigma2", "accepted"), [("paper", 0.5, 0), ("paper", 4.0, 4), ("robust", 0.5, 4)]
)
def test_a_white_rectangle(profile: str, sigma2: float, accepted: int) -> None:
    """All four corners have a peak; the paper's filter rejects them unless sigma2 is larger."""
    assert "`--sigma2 4`" in NO_CORNERS
    image = np.zeros((100, 100), np.uint8)
    image[30:70, 25:75] = 255
    settings = Settings(sigma2=sigma2, report_rejected=True)
    corners = detect(image, Parameters.profile(profile), settings)
    assert (len(corners), int(corners.accepted.sum())) == (4, accepted)
