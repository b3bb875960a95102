"""The photograph with its corners drawn: one panel for each profile, side by side, and a legend.

Markers are at subpixel positions and antialiased. The stronger a corner is, the larger is its
marker; where corners are dense, all markers are smaller.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from golden import Corners, Flag, Settings

Colour = tuple[int, int, int]
Floats = NDArray[np.float64]

ACCEPTED: Colour = (0, 214, 143)
CLAMPED: Colour = (86, 180, 233)
NOT_MAXIMUM: Colour = (240, 228, 66)
REJECTED: Colour = (255, 140, 0)
"""Colours after Okabe and Ito, distinct for every kind of colour vision; shapes differ as well."""
_HALO: Colour = (0, 0, 0)
_HALO_OPACITY = 0.6
_GROUND: Colour = (24, 24, 24)
_TEXT: Colour = (235, 235, 235)
_SHADE = 0.55
"""Brightness of the border, in which no corner can be."""

_COMFORTABLE_SIDE = 1000
_LARGEST_SCALE = 24
_STROKE = 1.5
_HALO_STROKE = 3.3
_SMALLEST_RADIUS, _LARGEST_RADIUS = 2.5, 9.0
_LEGEND_RADIUS = 6.4
_GAP = 12
_TITLE, _LINE = 24, 17
"""Sizes of type, in pixels, for a panel of the comfortable side; wider ones have larger type."""


@dataclass(frozen=True)
class Panel:
    """Corners that one profile has found with these settings."""

    profile: str
    settings: Settings
    corners: Corners
    margin: int
    """Pixels at each edge in which it looks for no corner."""


@dataclass(frozen=True)
class _Mark:
    text: str
    colour: Colour
    distance: Callable[[Floats, Floats, float], Floats]
    """Distance in pixels of a point (dx, dy) from the stroke's middle, for a marker's radius."""


def _to_ring(dx: Floats, dy: Floats, radius: float) -> Floats:
    return np.abs(np.hypot(dx, dy) - radius)


def _to_square(dx: Floats, dy: Floats, radius: float) -> Floats:
    return np.abs(np.maximum(np.abs(dx), np.abs(dy)) - 0.9 * radius)


def _to_diamond(dx: Floats, dy: Floats, radius: float) -> Floats:
    return np.abs(np.abs(dx) + np.abs(dy) - 1.25 * radius) / np.sqrt(2)


def _to_cross(dx: Floats, dy: Floats, radius: float) -> Floats:
    arm = radius * 0.8
    nearest = []
    for sign in (-1, 1):
        along = np.clip((dx + sign * dy) / 2, -arm, arm)
        nearest.append(np.hypot(dx - along, dy - sign * along))
    return np.minimum(*nearest)


_MARKS = {
    0: _Mark("corner; the stronger, the larger", ACCEPTED, _to_ring),
    Flag.CLAMPED: _Mark("corner, position approximate (clamped)", CLAMPED, _to_square),
    Flag.NOT_MAXIMUM: _Mark("corner, whole pixel (not a maximum)", NOT_MAXIMUM, _to_diamond),
    Flag.TEXTURED: _Mark("rejected by the texture filter", REJECTED, _to_cross),
}
"""Markers by flag; a rejected corner is shown as rejected, with any other flags."""


def _kinds(corners: Corners) -> NDArray[np.uint8]:
    """For each corner the key of its marker."""
    return np.where(corners.accepted, corners.flags, np.uint8(Flag.TEXTURED)).astype(np.uint8)


def scale_for(width: int, height: int) -> int:
    """Whole factor that makes markers legible: 2 for 512x512, 1 for Full HD."""
    return min(-(-_COMFORTABLE_SIDE // max(width, height)), _LARGEST_SCALE)


def draw_panels(pixels: NDArray[np.uint8], panels: Sequence[Panel]) -> Image.Image:
    """Picture of a (height, width) grey image with the corners of each panel, side by side."""
    height, width = pixels.shape
    size = f"{width}x{height} pixels"
    drawn = [_with_title(draw_corners(pixels, panel.corners, panel.margin), panel, size) for panel in panels]
    row = Image.new(
        "RGB", (sum(part.width for part in drawn) + _GAP * (len(drawn) - 1), drawn[0].height), _GROUND
    )
    x = 0
    for part in drawn:
        row.paste(part, (x, 0))
        x += part.width + _GAP
    present = set(np.concatenate([_kinds(panel.corners) for panel in panels]).tolist())
    line = _type_size(_LINE, drawn[0].width)
    marks = [mark for flag, mark in _MARKS.items() if flag in present or not flag]
    return _with_legend(row, line, marks, sorted({panel.margin for panel in panels}))


def _type_size(usual: int, panel_width: int) -> int:
    return round(usual * max(1.0, panel_width / _COMFORTABLE_SIDE))


def draw_corners(pixels: NDArray[np.uint8], corners: Corners, margin: int) -> Image.Image:
    """The image enlarged, with a marker at each corner, and with its border shaded."""
    height, width = pixels.shape
    scale = scale_for(width, height)
    photo = Image.fromarray(pixels).resize((scale * width, scale * height), Image.Resampling.BICUBIC)
    canvas = np.asarray(photo.convert("RGB"), dtype=np.float32).copy()
    inside = slice(margin * scale, -margin * scale)
    inner = (inside, inside)
    bright = canvas[inner].copy()
    canvas *= _SHADE
    canvas[inner] = bright
    radii, kinds = _radii(corners, canvas.shape[0] * canvas.shape[1], scale), _kinds(corners)
    # rejected ones first, and then the accepted ones, the strongest last: these stay in sight
    for index in np.lexsort((corners.response, corners.accepted)):
        # pixel centres are at whole numbers, before and after the enlargement
        x, y = ((value[index] + 0.5) * scale - 0.5 for value in (corners.x, corners.y))
        _stamp(canvas, _MARKS[kinds[index]], x, y, radii[index])
    return Image.fromarray(np.rint(canvas).astype(np.uint8))


def _radii(corners: Corners, area: int, scale: int) -> Floats:
    """Radii of the markers in pixels of the picture: by their density and by the responses."""
    if not len(corners):
        return np.empty(0)
    # a pixel of the image at most, where it is enlarged so far
    largest = max(_LARGEST_RADIUS, scale)
    usual = np.clip(0.28 * np.sqrt(area / len(corners)), _SMALLEST_RADIUS + 1, largest - 1)
    strong = max(float(np.percentile(corners.response, 95)), 1.0)
    strength = np.sqrt(np.clip(corners.response / strong, 0, 1.5))
    return np.clip(usual * (0.4 + 0.8 * strength), _SMALLEST_RADIUS, largest)


def _stamp(canvas: NDArray[np.float32], mark: _Mark, x: float, y: float, radius: float) -> None:
    reach = round(1.3 * radius) + 3
    left, top = max(round(x) - reach, 0), max(round(y) - reach, 0)
    part = canvas[top : round(y) + reach + 1, left : round(x) + reach + 1]
    dy, dx = np.ogrid[: part.shape[0], : part.shape[1]]
    distance = mark.distance(dx + (left - x), dy + (top - y), radius)[..., None]
    for colour, stroke, opacity in ((_HALO, _HALO_STROKE, _HALO_OPACITY), (mark.colour, _STROKE, 1.0)):
        # the part of a pixel that the stroke covers, to a good approximation
        coverage = opacity * np.clip((stroke + 1) / 2 - distance, 0, 1)
        part += coverage * (np.array(colour, dtype=np.float32) - part)


def _with_title(picture: Image.Image, panel: Panel, size: str) -> Image.Image:
    accepted = int(panel.corners.accepted.sum())
    found = f"{accepted} corners, {len(panel.corners) - accepted} rejected"
    thresholds = f"sigma1 {panel.settings.sigma1:g}, sigma2 {panel.settings.sigma2:g}"
    lines = [
        (
            _type_size(_TITLE, picture.width),
            f"{panel.profile}: {found}",
        ),
        (
            _type_size(_LINE, picture.width),
            f"{thresholds}, {size}",
        ),
    ]
    fonts = [ImageFont.load_default(size=size) for size, _ in lines]
    widest = max(font.getlength(text) for font, (_, text) in zip(fonts, lines, strict=True))
    height = sum(size + 8 for size, _ in lines) + 6
    canvas = Image.new(
        "RGB", (max(picture.width, round(widest) + 2 * _GAP), picture.height + height), _GROUND
    )
    canvas.paste(picture, (0, height))
    text, y = ImageDraw.Draw(canvas), 6
    for font, (line, words) in zip(fonts, lines, strict=True):
        text.text((_GAP, y + line // 2), words, fill=_TEXT, font=font, anchor="lm")
        y += line + 8
    return canvas


def _with_legend(
    picture: Image.Image, size: int, marks: Sequence[_Mark], margins: Sequence[int]
) -> Image.Image:
    font = ImageFont.load_default(size=size)
    entries: list[tuple[_Mark | None, str]] = [(mark, mark.text) for mark in marks]
    entries.append(
        (None, f"border of {' or '.join(map(str, margins))} pixels, in which no corner is looked for")
    )
    indent, line = 28, size + 11
    places, x, y = [], _GAP, picture.height + 6
    width = picture.width
    for _, words in entries:
        wide = indent + round(font.getlength(words))
        if x > _GAP and x + wide > picture.width:
            x, y = _GAP, y + line
        places.append((x, y + line // 2))
        width = max(width, x + wide + _GAP)
        x += wide + 2 * _GAP
    canvas = Image.new("RGB", (width, y + line + 6), _GROUND)
    canvas.paste(picture, (0, 0))
    text = ImageDraw.Draw(canvas)
    for (mark, words), (x, y) in zip(entries, places, strict=True):
        text.text((x + indent, y), words, fill=_TEXT, font=font, anchor="lm")
        if mark is None:
            text.rectangle((x + 3, y - 7, x + 18, y + 7), fill=(90, 90, 90))
    pixels = np.asarray(canvas, dtype=np.float32).copy()
    for (mark, _), (x, y) in zip(entries, places, strict=True):
        if mark is not None:
            _stamp(pixels, mark, x + 10, y, _LEGEND_RADIUS)
    return Image.fromarray(np.rint(pixels).astype(np.uint8))
