"""The user's data for ``cornerstream eval``: folders of photographs, pairs and boards; videos."""

from __future__ import annotations

import os
import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from cornerstream import console
from cornerstream.errors import BadInput, one_line, reason
from cornerstream.images import load
from evaluation.inputs.boards import Board
from evaluation.inputs.hpatches import IMAGES, SEQUENCES, prepared
from evaluation.inputs.packages import opencv
from evaluation.inputs.sources import (
    FRAMES_APART,
    PAIRS_PER_VIDEO,
    Image,
    NamedImage,
    Pair,
    SourceError,
    frame_pairs,
    read_homography,
    shrink,
    video_pairs,
)
from golden import Parameters
from golden.formats import MAX_SIDE

SUFFIXES = (".png", ".jpg", ".jpeg", ".tif", ".tiff", ".bmp", ".pgm", ".ppm", ".webp")
LONGEST_PHOTOGRAPH = 1280
"""Photographs of scenes and boards are shrunk to this: larger ones have no more detail."""
_HOMOGRAPHY = re.compile(r"H_?(\d+)(?:_to_|_|to)(\d+)p?(?:_\w+)?(?:\.txt|\.xml)?")
_ANY_SIZE = Parameters.profile("paper", max_width=MAX_SIDE, max_height=MAX_SIDE)


def _files(folder: Path, what: str) -> list[Path]:
    """Image files of a folder and its subfolders, in order."""
    try:
        if not folder.is_dir():
            raise BadInput(f"{folder} is not a folder; allowed: a folder with {what}")
        found = sorted(path for path in folder.rglob("*") if path.suffix.lower() in SUFFIXES)
    except OSError as error:
        raise BadInput(f"{folder} cannot be read: {reason(error)}; allowed: a folder with {what}") from error
    if not found:
        raise BadInput(f"{folder} has no images; allowed: a folder with {what} ({', '.join(SUFFIXES)})")
    return found


def _pixels(path: Path, said: set[str]) -> Image:
    """Grey pixels; a remark on the conversion is printed once for images that share ``said``."""
    photograph = load(path, _ANY_SIZE, options=False)
    for remark in photograph.remarks:
        if remark not in said:
            console.say(f"{path}, and others alike: {remark}")
    said.update(photograph.remarks)
    return photograph.pixels.astype(np.uint8, copy=False)


def load_images(folder: Path) -> list[NamedImage]:
    """Photographs of a folder, grouped by the folder they are in."""
    said: set[str] = set()
    return [
        NamedImage(
            str(path.relative_to(folder)), shrink(_pixels(path, said), LONGEST_PHOTOGRAPH), path.parent.name
        )
        for path in _files(folder, "photographs")
    ]


def load_boards(folder: Path, size: tuple[int, int] | None) -> list[Board]:
    """Photographs of chessboards."""
    said: set[str] = set()
    return [
        Board(str(path.relative_to(folder)), shrink(_pixels(path, said), LONGEST_PHOTOGRAPH), size=size)
        for path in _files(folder, "photographs of chessboards")
    ]


def load_pairs(folder: Path) -> list[Pair]:
    """Pairs with homographies, of the folder itself and of its subfolders, each a scene.

    Image files end in a number, ``1.png`` or ``img1.ppm``; ``H_1_3.txt``, ``H_1_3``, ``H1to3p`` or
    ``H1to3p.xml`` takes points of image 1 to image 3.
    """
    _files(folder, "images and homographies H_1_2.txt ...")
    pairs = []
    said: set[str] = set()
    for path in sorted(folder.rglob("H*")):
        names = _HOMOGRAPHY.fullmatch(path.name)
        if names and path.is_file():
            first, second = (_numbered(path.parent, int(number), said) for number in names.groups())
            scene = path.parent.name
            name = f"{names[1]} to {names[2]}"
            pairs.append(Pair(name, scene, scene, first, second, _homography(path)))
    if not pairs:
        raise BadInput(
            f"{folder} has no homographies; allowed: 3x3 numbers in files named H_1_2.txt or H1to2p"
        )
    return pairs


def load_hpatches(folder: Path) -> list[Pair]:
    """The pairs of the dataset HPatches, prepared as its published figures were measured.

    Its folders are ``i_NAME``, where the light changes, and ``v_NAME``, where the viewpoint does;
    each has the images ``1.ppm`` to ``6.ppm`` and the homographies ``H_1_2`` to ``H_1_6``.
    """
    allowed = "a folder with i_NAME and v_NAME, the sequences of HPatches"
    try:
        if not folder.is_dir():
            raise BadInput(f"{folder} is not a folder; allowed: {allowed}")
        sequences = sorted(path for path in folder.glob("[iv]_*") if path.is_dir())
    except OSError as error:
        raise BadInput(f"{folder} cannot be read: {reason(error)}; allowed: {allowed}") from error
    if not sequences:
        raise BadInput(f"{folder} has no sequences; allowed: {allowed}")
    said: set[str] = set()
    return [pair for sequence in sequences for pair in _sequence(sequence, said)]


def _sequence(folder: Path, said: set[str]) -> list[Pair]:
    files = [f"{number}.ppm" for number in range(1, IMAGES + 1)]
    files += [f"H_1_{number}" for number in range(2, IMAGES + 1)]
    missing = [name for name in files if not (folder / name).is_file()]
    if missing:
        raise BadInput(
            f"{folder} has no {', '.join(missing)}; allowed: 1.ppm to {IMAGES}.ppm and H_1_2 to H_1_{IMAGES}"
        )
    first = _pixels(folder / "1.ppm", said)
    pairs = []
    for number in range(2, IMAGES + 1):
        second = _pixels(folder / f"{number}.ppm", said)
        homography = _homography(folder / f"H_1_{number}")
        group = SEQUENCES[folder.name[0]]
        pairs.append(Pair(f"1 to {number}", folder.name, group, first, second, homography))
    return prepared(pairs)


def _homography(path: Path) -> NDArray[np.float64]:
    try:
        return read_homography(path)
    except SourceError as error:
        raise BadInput(one_line(error)) from error


def _numbered(folder: Path, number: int, said: set[str]) -> Image:
    for path in sorted(folder.iterdir()):
        digits = re.search(r"(\d+)$", path.stem)
        if path.suffix.lower() in SUFFIXES and digits and int(digits[1]) == number:
            return _pixels(path, said)
    raise BadInput(
        f"{folder} has no image {number}, which a homography there names; allowed: {number}.png etc."
    )


def load_video(path: Path) -> list[Pair]:
    """Pairs of frames of a video file, or of a folder of frames in order of their names."""
    if path.is_dir():
        said: set[str] = set()
        frames = [shrink(_pixels(each, said)) for each in _files(path, "frames of a video")]
        if len(frames) <= FRAMES_APART or len({frame.shape for frame in frames}) > 1:
            raise BadInput(f"{path} is not a video; allowed: {FRAMES_APART + 1} or more frames of one size")
        return frame_pairs(frames, path.name, path.name, pairs=PAIRS_PER_VIDEO, apart=FRAMES_APART)
    # OpenCV and FFmpeg, which it calls, write complaints of their own on stderr
    os.environ.setdefault("OPENCV_FFMPEG_LOGLEVEL", "-8")
    opencv().utils.logging.setLogLevel(0)
    try:
        return video_pairs(path, path.stem)
    except SourceError as error:
        raise BadInput(one_line(error)) from error
