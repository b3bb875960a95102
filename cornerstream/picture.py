"""The photograph with its corners drawn: marks at subpixel positions, antialiased, and a legend
below.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from golden import Corners

Colour = tuple[int, int, int]

ACCEPTED: Colour = (0, 214, 143)
REJECTED: Colour = (255, 140, 0)
"""Green towards blue and orange (after Okabe and Ito): told apart with every kind of colour vision;
the marks differ in shape as well.
"""
_HALO: Colour = (0, 0, 0)
_HALO_OPACITY = 0.65

_COMFORTABLE_SIDE = 1000
_LARGEST_SCALE = 8
_RADIUS = 5.0
_STROKE = 1.8
_HALO_STROKE = 4.2
_REACH = 9
"""Pixels from a mark's centre to the edge of the square it is drawn in."""


@dataclass(frozen=True)
class _Mark:
    colour: Colour
    distance: Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]
    """Distance of a point (dx, dy) from the middle of the mark's stroke, in pixels."""


def _distance_to_ring(dx: NDArray[np.float64], dy: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.abs(np.hypot(dx, dy) - _RADIUS)


def _distance_to_cross(dx: NDArray[np.float64], dy: NDArray[np.float64]) -> NDArray[np.float64]:
    arm = _RADIUS * 0.8
    nearest = []
    for sign in (-1, 1):
        along = np.clip((dx + sign * dy) / 2, -arm, arm)
        nearest.append(np.hypot(dx - along, dy - sign * along))
    return np.minimum(*nearest)


_RING = _Mark(ACCEPTED, _distance_to_ring)
_CROSS = _Mark(REJECTED, _distance_to_cross)


def scale_for(width: int, height: int) -> int:
    """Whole factor that enlarges a picture until its marks are legible: 2 for 512x512, 1 for Full
    HD.
    """
    return min(-(-_COMFORTABLE_SIDE // max(width, height)), _LARGEST_SCALE)


def draw_corners(pixels: NDArray[np.uint8], corners: Corners) -> Image.Image:
    """Picture of a (height, width) grey image: rings at accepted corners, crosses at rejected ones."""
    height, width = pixels.shape
    scale = scale_for(width, height)
    photo = Image.fromarray(pixels).resize((scale * width, scale * height), Image.Resampling.BICUBIC)
    canvas = np.asarray(photo.convert("RGB"), dtype=np.float32).copy()
    # accepted ones on top
    for mark, chosen in ((_CROSS, ~corners.accepted), (_RING, corners.accepted)):
        # pixel centres are at whole numbers, before and after the enlargement
        x = (corners.x[chosen] + 0.5) * scale - 0.5
        y = (corners.y[chosen] + 0.5) * scale - 0.5
        for centre in zip(x, y, strict=True):
            _stamp(canvas, mark, *centre)
    drawn = Image.fromarray(np.rint(canvas).astype(np.uint8))
    return _with_legend(drawn, int(corners.accepted.sum()), int((~corners.accepted).sum()))


def _stamp(canvas: NDArray[np.float32], mark: _Mark, x: float, y: float) -> None:
    left, top = max(round(x) - _REACH, 0), max(round(y) - _REACH, 0)
    part = canvas[top : round(y) + _REACH + 1, left : round(x) + _REACH + 1]
    dy, dx = np.ogrid[: part.shape[0], : part.shape[1]]
    distance = mark.distance(dx + (left - x), dy + (top - y))[..., None]
    for colour, stroke, opacity in ((_HALO, _HALO_STROKE, _HALO_OPACITY), (mark.colour, _STROKE, 1.0)):
        # the part of a pixel that the stroke covers, to a good approximation
        coverage = opacity * np.clip((stroke + 1) / 2 - distance, 0, 1)
        part += coverage * (np.array(colour, dtype=np.float32) - part)


def _with_legend(picture: Image.Image, accepted: int, rejected: int) -> Image.Image:
    entries = [(_RING, f"accepted: {accepted}"), (_CROSS, f"rejected by the texture filter: {rejected}")]
    font = ImageFont.load_default(size=16)
    line, gap, indent = 26, 24, 28
    widths = [indent + round(font.getlength(text)) for _, text in entries]
    one_line = sum(widths) + 3 * gap <= picture.width
    lines = 1 if one_line else len(entries)
    width = max(picture.width, max(widths) + 2 * gap)
    canvas = Image.new("RGB", (width, picture.height + lines * line + 8), (24, 24, 24))
    canvas.paste(picture, (0, 0))
    text = ImageDraw.Draw(canvas)
    positions = []
    x, y = gap // 2, picture.height + 4 + line // 2
    for (_, words), wide in zip(entries, widths, strict=True):
        positions.append((x + 10, y))
        text.text((x + indent, y), words, fill=(235, 235, 235), font=font, anchor="lm")
        x, y = (x + wide + gap, y) if one_line else (x, y + line)
    pixels = np.asarray(canvas, dtype=np.float32).copy()
    for (mark, _), position in zip(entries, positions, strict=True):
        _stamp(pixels, mark, *position)
    return Image.fromarray(np.rint(pixels).astype(np.uint8))
