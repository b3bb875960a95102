"""Frames as beats of several pixels: where each pixel is, and what a row's last beat has beyond."""

from __future__ import annotations

import numpy as np
import pytest

from golden import Settings, check_image
from hdl.build import Build
from sim import Stalls, frame_stimulus
from sim.beats import beat_count, beats

HEIGHT = 16


def build(lanes: int, pixel_bits: int = 8) -> Build:
    return Build.profile(
        "paper", pixels_per_clock=lanes, pixel_bits=pixel_bits, max_width=64, max_height=HEIGHT
    )


def image(p: Build, width: int, seed: int = 0) -> np.ndarray:
    dtype = np.uint8 if p.pixel_bits <= 8 else np.uint16
    random = np.random.default_rng(seed)
    return random.integers(0, p.pixel_max, (HEIGHT, width), dtype, endpoint=True)


def numbers(words: np.ndarray) -> list[int]:
    rows = words.reshape(len(words), -1).astype("<u8")
    return [int.from_bytes(row.tobytes(), "little") for row in rows]


@pytest.mark.parametrize("pixel_bits", [4, 8, 10])
@pytest.mark.parametrize("lanes", [1, 2, 4, 8])
@pytest.mark.parametrize("width", [25, 29, 32, 33])
def test_pixels_lie_side_by_side_from_the_lowest_bits(lanes: int, pixel_bits: int, width: int) -> None:
    """Ten bits times eight is more than a word, and one pixel lies in both."""
    p = build(lanes, pixel_bits)
    pixels = image(p, width)
    payloads = numbers(beats(pixels, p, np.random.default_rng(1)))
    per_row = (width + lanes - 1) // lanes
    assert len(payloads) == beat_count(pixels.shape, p) == per_row * HEIGHT
    assert max(payloads) < 1 << lanes * pixel_bits
    for y in range(HEIGHT):
        row = sum(
            beat << k * lanes * pixel_bits for k, beat in enumerate(payloads[y * per_row : (y + 1) * per_row])
        )
        assert [row >> x * pixel_bits & p.pixel_max for x in range(width)] == pixels[y].tolist()


def test_what_lies_beyond_the_width_is_never_the_same() -> None:
    p, frame = build(4), image(build(4), 29)
    frames = [(frame, Settings.default(p))] * 2
    given = frame_stimulus(frames, p, Stalls()).beats["i"]
    first, second = np.split(given, 2)
    # the last beat of each row has one pixel that counts
    assert np.array_equal(first & np.uint64(0xFF), second & np.uint64(0xFF))
    last = np.s_[7::8]
    assert np.array_equal(np.delete(first, last), np.delete(second, last))
    beyond = np.concatenate([first[last], second[last]]) >> np.uint64(8)
    assert len(np.unique(beyond)) == 2 * HEIGHT
    other = frame_stimulus(frames, p, Stalls(seed=1)).beats["i"]
    assert (other[last] != given[last]).all()


def test_settings_come_with_the_first_beat_of_a_frame() -> None:
    p = build(8)
    frames = [(image(p, width), Settings.default(p)) for width in (25, 33, 64)]
    levels = frame_stimulus(frames, p, Stalls()).levels
    assert [(beat, values["width"]) for beat, values in levels] == [(0, 25), (64, 33), (144, 64)]


@pytest.mark.parametrize(("lanes", "least"), [(1, 15), (2, 17), (4, 19), (8, 25)])
def test_a_frame_is_at_least_as_wide_as_the_build_says(lanes: int, least: int) -> None:
    p = build(lanes)
    frame = image(p, least)
    assert check_image(frame, p) is frame
    with pytest.raises(ValueError, match=f"image is {least - 1}x16; allowed: {least}x15 to 64x16"):
        frame_stimulus([(image(p, least - 1), Settings.default(p))], p, Stalls())
    with pytest.raises(ValueError, match=f"max_width is {least - 1}; allowed: whole numbers from {least}"):
        p.changed(max_width=least - 1)
