"""Arguments of the wrong kind are refused in one clear line, by every public function."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from golden import (
    Parameters,
    Settings,
    StreamModel,
    check_image,
    decode,
    decode_frame_end,
    decode_frame_time,
    detect,
    reference_detect,
)
from golden.video import VideoModel, VideoSettings

IMAGE = np.zeros((20, 20), np.uint8)
VIDEO = VideoSettings(20, 20, Settings())
PLAIN: Any = Parameters.profile("paper")
SET: Any = Settings()
ANY: Any = VideoModel(PLAIN)

PARAMETERS = "parameters is a {}; allowed: Parameters"
SETTINGS = "settings is a {}; allowed: Settings"
WORDS = "records have dtype {}; allowed: uint64"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: detect(IMAGE, SET), PARAMETERS.format("Settings")),
        (lambda: detect(IMAGE, "robust"), PARAMETERS.format("str")),
        (lambda: detect(IMAGE, {}), PARAMETERS.format("dict")),
        (lambda: detect(IMAGE, None, PLAIN), SETTINGS.format("Parameters")),
        (lambda: detect(IMAGE, settings=0), SETTINGS.format("int")),
        (lambda: reference_detect(IMAGE, SET), PARAMETERS.format("Settings")),
        (lambda: reference_detect(IMAGE, PLAIN, False), SETTINGS.format("bool")),
        (
            lambda: reference_detect(IMAGE, reference="9"),
            "reference is a str; allowed: a number or None",
        ),
        (lambda: check_image(IMAGE, SET), PARAMETERS.format("Settings")),
        (lambda: check_image(None, PLAIN), "image is a NoneType; allowed: a plain NumPy array"),
        (lambda: SET.check("robust"), PARAMETERS.format("str")),
        (lambda: Settings.default(SET), PARAMETERS.format("Settings")),
        (lambda: VIDEO.check(None), PARAMETERS.format("NoneType")),
        (lambda: StreamModel(SET), PARAMETERS.format("Settings")),
        (lambda: StreamModel(0), PARAMETERS.format("int")),
        (lambda: StreamModel().process(IMAGE, PLAIN), SETTINGS.format("Parameters")),
        (lambda: VideoModel(None), PARAMETERS.format("NoneType")),
        (lambda: ANY.feed([], SET), "video is a Settings; allowed: VideoSettings"),
        (lambda: ANY.feed([], VideoSettings(20, 20, PLAIN)), SETTINGS.format("Parameters")),
        (lambda: ANY.feed([], VideoSettings(20, 20, SET, 1)), "enabled is a int; allowed: bool"),
        (lambda: Parameters.profile(5), "profile is a int; allowed: str"),
        (lambda: Parameters.profile(["paper"]), "profile is a list; allowed: str"),
        (lambda: decode([1]), "records are a list; allowed: a NumPy array of uint64"),
        (lambda: decode(np.zeros(2)), WORDS.format("float64")),
        (lambda: decode(np.array([-1])), WORDS.format("int64")),
        (lambda: decode(np.zeros(2, np.uint32)), WORDS.format("uint32")),
        (lambda: decode_frame_time("5"), "record is a str; allowed: a whole number"),
        (lambda: decode_frame_end("5"), "record is a str; allowed: a whole number"),
        (lambda: decode_frame_end(6.9e18), "record is a float; allowed: a whole number"),
    ],
)
def test_types(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(TypeError) as caught:
        call()
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Settings(report_rejected="no"), "report_rejected is 'no'; allowed: True or False"),
        (lambda: decode(np.zeros((2, 3), np.uint64)), r"records have shape \(2, 3\); allowed: \(n,\)"),
        (lambda: decode(np.zeros((), np.uint64)), r"records have shape \(\); allowed: \(n,\)"),
        (lambda: decode_frame_time(1 << 64), "record is 18446744073709551616; allowed: whole numbers from 0"),
        (lambda: decode_frame_end(-1), "record is -1; allowed: whole numbers from 0 to 18446744073709551615"),
        (lambda: decode_frame_end(1 << 64), "record is 18446744073709551616; allowed: whole numbers from 0"),
        (lambda: reference_detect(IMAGE, reference=-1), "reference is -1; allowed: 0 to 130050"),
        (lambda: reference_detect(IMAGE, reference=float("nan")), "reference is nan; allowed: 0 to 130050"),
        (lambda: ANY.feed([(256, True, False)], VIDEO), "pixel is 256; allowed: whole numbers from 0 to 255"),
        (lambda: ANY.feed([(1.5, True, False)], VIDEO), "pixel is 1.5; allowed: whole numbers from 0 to 255"),
        (
            lambda: Parameters.profile("paper", fit=np.array(["six", "nine"])),
            "fit is array.*; allowed: nine, six",
        ),
    ],
)
def test_values(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(ValueError, match=f"^{message}"):
        call()


def test_a_refused_pixel_leaves_no_trace() -> None:
    model = VideoModel(PLAIN)
    with pytest.raises(ValueError, match=r"^pixel is -1; allowed: whole numbers from 0 to 255$"):
        model.feed([(7, True, False), (-1, False, False)], VIDEO)
    assert not model.active and model.feed([], VIDEO) == []


def test_words_of_either_byte_order_and_any_stride_are_decoded() -> None:
    words = np.array([5 << 40 | 9 << 27 | 8 << 7, 7 << 40], np.uint64)
    for same in (words.astype(">u8"), np.repeat(words, 2)[::2]):
        assert decode(same) == decode(words) and decode(same).response.tolist() == [5, 7]
