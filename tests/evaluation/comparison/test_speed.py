"""The measurements measure what they say; how fast things are is not tested here."""

from __future__ import annotations

import io
import json
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from amaranth.lib import wiring
from rich.console import Console

from evaluation.comparison import speed
from hdl.build import Build
from sim import Engine, make_engine

SMALLEST = Build.profile("paper", max_width=32, max_height=32, buffering="lean")


def test_frame_is_the_photograph_and_its_mirror_images() -> None:
    frame = speed.mirrored_photograph(speed.FULL_HD)
    assert frame.shape == (1080, 1920) and frame.dtype == np.uint8 and frame.flags.c_contiguous
    assert (frame[:512, 512:1024] == frame[:512, 511::-1]).all()
    assert (frame[512:1024, :512] == frame[511::-1, :512]).all()
    assert (speed.mirrored_photograph((48, 64)) == frame[:48, :64]).all()


def test_ratio_is_golden_over_opencv(monkeypatch: pytest.MonkeyPatch) -> None:
    # clock readings: 30 ms and 10 ms, then 20 ms and 16 ms
    readings = iter([0.0, 0.030, 1.0, 1.010, 2.0, 2.020, 3.0, 3.016])
    monkeypatch.setattr(speed, "FULL_HD", (40, 40))
    monkeypatch.setattr(speed.time, "perf_counter", lambda: next(readings))
    result = speed.golden_speed(repeats=2)
    assert (result.golden.minimum, result.golden.median) == pytest.approx((0.020, 0.025))
    assert (result.opencv.minimum, result.opencv.median) == pytest.approx((0.010, 0.013))
    assert result.ratio == pytest.approx(2.0)
    assert result.median_ratio == pytest.approx((3 + 1.25) / 2)


def in_amaranth(name: str, component: wiring.Component, **_: Any) -> Engine:
    """Stands in for both engines, so that nothing is compiled."""
    return make_engine("amaranth", component)


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed, "FULL_HD", (16, 20))
    monkeypatch.setattr(speed, "SMALL", (15, 15))
    monkeypatch.setattr(speed, "make_engine", in_amaranth)
    monkeypatch.setattr(speed, "PIXELS_PER_CLOCK", (1, 2))
    monkeypatch.setattr(
        speed, "Build", SimpleNamespace(profile=lambda name, **changes: SMALLEST.changed(**changes))
    )


def test_everything_as_json_and_as_tables(small: None) -> None:
    text = io.StringIO()
    printed = Console(file=text, width=100)
    result = speed.main(repeats=1, turns=1, console=printed)
    assert json.loads(json.dumps(result)) == result
    engines = result["engines"]
    assert engines["compiled"]["frame"] == "20x16" and engines["amaranth"]["frame"] == "15x15"
    assert engines["compiled"]["mismatches"] == engines["amaranth"]["mismatches"] == 0
    assert engines["compiled"]["clocks"] > 320 and engines["compiled"]["median"] > 0
    one, two = result["pixels_per_clock"]
    assert (one["pixels_per_clock"], two["pixels_per_clock"]) == (1, 2)
    assert (one["clocks_per_pixel"], two["clocks_per_pixel"]) == (1, 0.5)
    assert one["ratio"] == 1 and two["ratio"] == pytest.approx(
        two["frames_per_second"] / one["frames_per_second"]
    )
    assert one["engine"]["mismatches"] == two["engine"]["mismatches"] == 0
    assert len(speed.rates(result)) == 4
    for words in ("golden.detect", "goodFeaturesToTrack", "clocks per second", "goal", "clocks/pixel"):
        assert words in text.getvalue()

    text.truncate(0)
    text.seek(0)
    result = speed.main(as_json=True, repeats=1, engines=False, console=printed)
    assert json.loads(text.getvalue()) == result
    assert "engines" not in result


def test_missing_opencv_is_said_in_a_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cv2", None)
    with pytest.raises(speed.MissingPackageError) as caught:
        speed.run()
    assert str(caught.value) == "OpenCV is not installed; get it with: pip install 'cornerstream[eval]'"
