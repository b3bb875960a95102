"""The 64-bit record, bit by bit."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.output_constructor import (
    Corners,
    Flag,
    FrameEnd,
    decode,
    decode_frame_end,
    decode_frame_time,
    encode,
    encode_frame_end,
    encode_frame_time,
)
from golden.subpixel import Offset


def record(
    x: int = 0,
    y: int = 0,
    response: int = 0,
    dx: int = 0,
    dy: int = 0,
    clamped: bool = False,
    not_maximum: bool = False,
    textured: bool = False,
) -> int:
    offset = Offset(np.array([dx]), np.array([dy]), np.array([clamped]), np.array([not_maximum]))
    words = encode(np.array([x]), np.array([y]), np.array([response]), offset, np.array([textured]))
    assert words.dtype == np.uint64
    return int(words[0])


def bits(word: int, high: int, low: int) -> int:
    return (word >> low) & ((1 << (high - low + 1)) - 1)


def test_by_hand() -> None:
    word = record(x=9, y=8, response=0x1ABCD, dx=-64, dy=33, clamped=True)
    # x = 9 - 1/2 = 1088/128 = 0x00440, y = 8 + 33/128 = 1057/128 = 0x00421, bit 61 set, D in bits
    # 60:40
    assert word == 0b001 << 61 | 0x1ABCD << 40 | 0x00421 << 20 | 0x00440


@pytest.mark.parametrize("bit", range(13))
def test_each_coordinate_bit_has_its_place(bit: int) -> None:
    assert record(x=1 << bit) == 1 << (bit + 7)
    assert record(y=1 << bit) == 1 << (bit + 27)


@pytest.mark.parametrize("bit", range(7))
def test_each_offset_bit_has_its_place(bit: int) -> None:
    assert record(dx=1 << bit) == 1 << bit
    assert record(dy=1 << bit) == 1 << (bit + 20)


@pytest.mark.parametrize("bit", range(21))
def test_each_response_bit_has_its_place(bit: int) -> None:
    assert record(response=1 << bit) == 1 << (bit + 40)


def test_each_flag_has_its_place() -> None:
    assert record(clamped=True) == 1 << 61
    assert record(not_maximum=True) == 1 << 62
    assert record(textured=True) == 1 << 63
    assert record(not_maximum=True, textured=True) == 0b11 << 62


def test_fields_at_their_largest_do_not_touch() -> None:
    # the last pixel of the largest frame that can hold a corner, at full scale of 10-bit pixels
    word = record(x=8191 - 7, y=8191 - 7, response=2093058, dx=64, dy=64, textured=True)
    assert bits(word, 19, 0) == bits(word, 39, 20) == 8184 * 128 + 64
    assert bits(word, 60, 40) == 2093058
    assert bits(word, 63, 61) == 0b100


CornerFields = st.fixed_dictionaries(
    {
        "x": st.integers(7, 8184),
        "y": st.integers(7, 8184),
        "response": st.integers(0, 2093058),
        "dx": st.integers(-64, 64),
        "dy": st.integers(-64, 64),
        "fit": st.sampled_from([(False, False), (True, False), (False, True)]),
        "textured": st.booleans(),
    }
)


@given(st.lists(CornerFields, max_size=8))
def test_round_trip(fields: list[dict]) -> None:
    words = []
    for field in fields:
        clamped, not_maximum = field["fit"]
        rest = {name: value for name, value in field.items() if name != "fit"}
        words.append(record(clamped=clamped, not_maximum=not_maximum, **rest))
    corners = decode(np.array(words, dtype=np.uint64))
    assert len(corners) == len(fields)
    assert corners.x.tolist() == [field["x"] + field["dx"] / 128 for field in fields]
    assert corners.y.tolist() == [field["y"] + field["dy"] / 128 for field in fields]
    assert corners.response.tolist() == [field["response"] for field in fields]
    assert corners.accepted.tolist() == [not field["textured"] for field in fields]
    for flag, field in zip(corners.flags.tolist(), fields, strict=True):
        assert (bool(flag & Flag.CLAMPED), bool(flag & Flag.NOT_MAXIMUM)) == field["fit"]
    assert (corners.x.dtype, corners.response.dtype, corners.flags.dtype) == (np.float64, np.int64, np.uint8)


def test_end_of_frame_by_hand() -> None:
    word = encode_frame_end(FrameEnd(records=0x00ABCD, frame=0x1234, maximum=0x1FC02))
    assert word == 0b011 << 61 | 0x1FC02 << 40 | 0x1234 << 24 | 0x00ABCD
    assert encode_frame_end(FrameEnd(0xAB, 1, 0, cut=True)) == 0b111 << 61 | 1 << 24 | 0xAB
    assert decode_frame_end(word) == (0x00ABCD, 0x1234, 0x1FC02, False)
    assert decode_frame_end(np.uint64(word)) == (0x00ABCD, 0x1234, 0x1FC02, False)


@given(st.integers(0, 2**24 - 1), st.integers(0, 2**40), st.integers(0, 2093058), st.booleans())
def test_end_of_frame_round_trip(records: int, frame: int, maximum: int, cut: bool) -> None:
    end = FrameEnd(records, frame, 0 if cut else maximum, cut)
    word = encode_frame_end(end)
    assert decode_frame_end(word) == end._replace(frame=frame % 65536)
    assert len(decode(np.array([word], dtype=np.uint64))) == 0


@pytest.mark.parametrize("flags", [0b000, 0b001, 0b010, 0b100, 0b101, 0b110])
def test_corner_record_is_no_end_of_frame(flags: int) -> None:
    with pytest.raises(ValueError, match=r"record 0x[0-9a-f]{16} is not an end-of-frame record"):
        decode_frame_end(flags << 61 | 5)


def test_time_record_by_hand() -> None:
    assert encode_frame_time(0) == 0xF000_0000_0000_0000
    assert encode_frame_time(0x123_4567_89AB_CDEF) == 0xF123_4567_89AB_CDEF
    assert encode_frame_time(1 << 60 | 7) == 0xF000_0000_0000_0007
    assert decode_frame_time(np.uint64(0xF123_4567_89AB_CDEF)) == 0x123_4567_89AB_CDEF


@given(st.integers(0, 2**64 - 1))
def test_each_word_is_of_one_kind(word: int) -> None:
    """A corner, an end of frame or a time; and whatever is none of the latter two says so."""
    kinds = {decode_frame_end: "an end-of-frame record", decode_frame_time: "a time record"}
    taken = len(decode(np.array([word], np.uint64)))
    for function, kind in kinds.items():
        try:
            function(word)
            taken += 1
        except ValueError as error:
            assert f"record {word:#018x} is not {kind} (bits 6" in str(error)
    assert taken == 1


def test_no_end_of_frame_looks_like_a_time() -> None:
    """A cut frame's has no largest response, and a complete frame's lacks bit 63."""
    for end in (FrameEnd(2**24 - 1, 2**16 - 1, 0, cut=True), FrameEnd(0, 0, 2**21 - 1)):
        assert decode_frame_end(encode_frame_end(end)) == end


def test_decode_leaves_other_records_out_and_keeps_the_order() -> None:
    end, time = encode_frame_end(FrameEnd(2, 0, 9)), encode_frame_time(1 << 59 | 5)
    corners = [record(x=x, y=8) for x in (9, 8, 10)]
    words = np.array([*corners[:2], end, time, corners[2], end, time], dtype=np.uint64)
    assert decode(words).x.tolist() == [9, 8, 10]


def test_no_corners() -> None:
    corners = decode(np.array([], dtype=np.uint64))
    assert len(corners) == 0 and corners.accepted.shape == (0,)
    assert corners.points().shape == (0, 1, 2) and corners.points().dtype == np.float32


def test_points_are_what_opencv_takes() -> None:
    corners = Corners(
        x=np.array([7.5, 8.0, 9.25]),
        y=np.array([10.0, 11.5, 12.0]),
        response=np.array([1, 2, 3]),
        flags=np.array([Flag.CLAMPED, Flag.TEXTURED, Flag.NOT_MAXIMUM], dtype=np.uint8),
    )
    points = corners.points()
    assert points.dtype == np.float32
    # OpenCV refines in place, and refuses what NumPy calls contiguous but has a stride of 0
    image = np.random.default_rng(0).integers(0, 256, (40, 40), dtype=np.uint8)
    assert cv2.cornerSubPix(image, corners.points(), (3, 3), (-1, -1), (3, 9, 0.1)).shape == (2, 1, 2)
    assert points.tolist() == [[[7.5, 10.0]], [[9.25, 12.0]]]
