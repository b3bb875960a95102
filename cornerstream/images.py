"""Reading images: whatever Pillow reads, as 8-bit grey pixels, with a remark on each conversion made."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError
from PIL.ExifTags import Base

from cornerstream.errors import BadInput, one_line, reason
from golden.parameters import SUPPORT, Parameters

_ALLOWED_DEPTH = "allowed: 8-bit grey, colour, palette or 1-bit images"
_TRANSPOSE = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}


@dataclass(frozen=True)
class Photograph:
    """A grey image with its name and what was done to get it.

    Attributes
    ----------
    pixels
        (height, width) uint8.
    name
        For people: the file's path, or what the built-in photograph is called.
    remarks
        One line for each conversion.
    """

    pixels: NDArray[np.uint8]
    name: str
    remarks: tuple[str, ...] = ()


def default_photograph(parameters: Parameters) -> Photograph:
    """scikit-image's ``camera``, 512x512: a public-domain photograph that comes with the installation."""
    # importing scikit-image takes a while
    from skimage.data import camera

    pixels = np.asarray(camera(), dtype=np.uint8)
    photograph = Photograph(pixels, "camera (scikit-image)")
    size = (pixels.shape[1], pixels.shape[0])
    if not _fits(size, parameters):
        raise BadInput(_wrong_size(photograph.name, size, parameters))
    return photograph


def load(path: Path, parameters: Parameters) -> Photograph:
    """Read an image that this detector can take; :class:`BadInput` for every other file."""
    try:
        with warnings.catch_warnings():
            # size is checked below, before any pixel is decoded
            warnings.simplefilter("ignore", Image.DecompressionBombWarning)
            with Image.open(path) as image:
                return _read(image, path, parameters)
    except UnidentifiedImageError as error:
        raise BadInput(
            f"{path} is not an image that can be read; allowed: PNG, JPEG, TIFF, BMP, PGM and the like"
        ) from error
    except Image.DecompressionBombError as error:
        raise BadInput(
            f"{path} has more than {2 * (Image.MAX_IMAGE_PIXELS or 0)} pixels; {_allowed_size(parameters)}"
        ) from error
    except FileNotFoundError as error:
        raise BadInput(f"{path} does not exist; allowed: an image file") from error
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {reason(error)}; allowed: a readable image file") from error


def _allowed_size(parameters: Parameters) -> str:
    largest = f"{parameters.max_width}x{parameters.max_height}"
    return (
        f"allowed: {SUPPORT}x{SUPPORT} up to the built maximum of {largest} (see --max-width, --max-height)"
    )


def _fits(size: tuple[int, int], parameters: Parameters) -> bool:
    width, height = size
    return SUPPORT <= width <= parameters.max_width and SUPPORT <= height <= parameters.max_height


def _wrong_size(name: str, size: tuple[int, int], parameters: Parameters) -> str:
    return f"{name} is {size[0]}x{size[1]} pixels; {_allowed_size(parameters)}"


def _read(image: Image.Image, path: Path, parameters: Parameters) -> Photograph:
    _check_depth(image, path)
    if not (_fits(image.size, parameters) or _fits(image.size[::-1], parameters)):
        # without decoding what may be gigabytes
        raise BadInput(_wrong_size(str(path), image.size, parameters))
    remarks = []
    if getattr(image, "n_frames", 1) > 1:
        remarks.append("more than one picture in the file: the first is used")
    try:
        image.load()
        orientation = image.getexif().get(Base.Orientation, 1)
    except Exception as error:
        # damaged files raise almost anything, from SyntaxError to struct.error
        raise BadInput(f"{path} is damaged: {one_line(error)}; allowed: a complete image file") from error
    if orientation in _TRANSPOSE:
        image = image.transpose(_TRANSPOSE[orientation])
        remarks.append("turned upright as its EXIF orientation says")
    if not _fits(image.size, parameters):
        raise BadInput(_wrong_size(str(path), image.size, parameters))
    grey = _to_grey(image, path, remarks)
    return Photograph(np.asarray(grey, dtype=np.uint8), str(path), tuple(remarks))


def _check_depth(image: Image.Image, path: Path) -> None:
    # Pillow reads 16-bit colour as 8-bit without a word; only the decoder's raw mode tells
    decoders = [(tile[0], tile[3]) for tile in getattr(image, "tile", [])]
    if image.mode.startswith("I;16") or any(_is_16_bit(*decoder) for decoder in decoders):
        raise BadInput(f"{path} has 16 bits per channel; {_ALLOWED_DEPTH}")
    if image.mode in ("I", "F"):
        raise BadInput(f"{path} has more than 8 bits per pixel (Pillow mode {image.mode}); {_ALLOWED_DEPTH}")


def _is_16_bit(codec: str, arguments: Any) -> bool:
    if codec.startswith("ppm") and isinstance(arguments, tuple):
        return bool(arguments[1] > 255)
    return ";16" in str(arguments)


def _to_grey(image: Image.Image, path: Path, remarks: list[str]) -> Image.Image:
    if image.mode == "1":
        remarks.append("1-bit image: black becomes 0 and white 255")
        return image.convert("L")
    grey = image.mode in ("L", "LA", "La")
    if image.mode == "P":
        remarks.append("palette looked up")
        image = image.convert("RGBA" if "transparency" in image.info else "RGB")
    elif image.mode in ("L", "RGB") and "transparency" in image.info:
        image = image.convert("RGBA")
    if image.has_transparency_data:
        image = _over_white(image, remarks)
    if grey:
        return image.convert("L")
    try:
        colour = image.convert("RGB")
    except ValueError as error:
        raise BadInput(f"{path} has the colour space {image.mode}; {_ALLOWED_DEPTH}") from error
    remarks.append("colour image: converted to grey by BT.601 (0.299 R + 0.587 G + 0.114 B)")
    return colour.convert("L")


def _over_white(image: Image.Image, remarks: list[str]) -> Image.Image:
    image = image.convert("RGBA")
    if image.getchannel("A").getextrema() != (255, 255):
        remarks.append("transparent pixels: laid over white")
        return Image.alpha_composite(Image.new("RGBA", image.size, "white"), image)
    return image
