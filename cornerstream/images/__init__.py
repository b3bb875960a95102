"""Reading images: grey pixels of the detector's width, with a remark on each conversion made."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from cornerstream.errors import BadInput, one_line, reason
from cornerstream.images.decoders import ALLOWED, Decoded, check_kind, decode, kind
from cornerstream.images.depth import eight_bits, fitted, normalized
from cornerstream.images.headers import read_header
from golden.parameters import Parameters
from hdl.build import Build

_LARGEST_FILE = 1 << 30
"""Bytes; twice what the largest frame takes in 32-bit floating-point numbers, not compressed."""


@dataclass(frozen=True, eq=False)
class Photograph:
    """A grey image with its name and what was done to get it.

    Attributes
    ----------
    pixels
        (height, width) uint8, or uint16 for more than 8 pixel bits.
    name
        For people: the file's path, or the name of the built-in photograph.
    remarks
        One line for each conversion.
    """

    pixels: NDArray[np.unsignedinteger[Any]]
    name: str
    remarks: tuple[str, ...] = ()

    def shown(self, parameters: Parameters) -> NDArray[np.uint8]:
        """The pixels as 8-bit grey, for a picture of them."""
        return eight_bits(self.pixels, parameters.pixel_bits)


@dataclass(frozen=True)
class _Wanted:
    parameters: Parameters
    normalize: bool
    options: bool

    def check_size(self, name: str, size: tuple[int, int], *, turned: bool = False) -> None:
        sizes = [size, size[::-1]] if turned else [size]
        least_width, least_height = self._least
        if not any(
            least_width <= width <= self.parameters.max_width
            and least_height <= height <= self.parameters.max_height
            for width, height in sizes
        ):
            raise BadInput(f"{name} is {size[0]}x{size[1]} pixels; {self.allowed_size}")

    @property
    def _least(self) -> tuple[int, int]:
        return self.parameters.min_width, self.parameters.algorithm.support

    @property
    def allowed_size(self) -> str:
        largest = f"{self.parameters.max_width}x{self.parameters.max_height}"
        width, height = self._least
        lanes = self.parameters.pixels_per_clock if isinstance(self.parameters, Build) else 1
        allowed = f"allowed with {lanes} pixels per clock" if lanes > 1 else "allowed"
        least = f"{allowed}: {width}x{height} up to"
        if self.options:
            return f"{least} the built maximum of {largest} (see --max-width, --max-height)"
        return f"{least} {largest}"

    def pixels(self, decoded: Decoded, name: str) -> Photograph:
        bits = self.parameters.pixel_bits
        if self.normalize:
            try:
                pixels = normalized(decoded.grey, bits, decoded.remarks)
            except ValueError as error:
                raise BadInput(
                    f"{name} cannot be normalized: {one_line(error)}; allowed: two values or more, all finite"
                ) from error
        else:
            hint = " (see --pixel-bits, --normalize)" if self.options else ""
            pixels = fitted(decoded.grey, decoded.bits, bits, decoded.remarks, hint)
        return Photograph(pixels, name, tuple(decoded.remarks))


def default_photograph(parameters: Parameters, *, normalize: bool = False) -> Photograph:
    """scikit-image's ``camera``, 512x512: an installed photograph in the public domain."""
    # importing scikit-image takes a while
    from skimage.data import camera

    wanted = _Wanted(parameters, normalize, options=True)
    grey = np.asarray(camera(), dtype=np.uint8)
    name = "camera (scikit-image)"
    wanted.check_size(name, grey.shape[::-1])
    return wanted.pixels(Decoded(grey, 8), name)


def load(path: Path, parameters: Parameters, *, normalize: bool = False, options: bool = True) -> Photograph:
    """Read an image that this detector can take; :class:`BadInput` for every other file.

    Parameters
    ----------
    path
        Path of the file; its header decides its format, not its name.
    parameters
        The detector: largest size and width of a pixel.
    normalize
        Stretch the image's own range to all of the pixel bits.
    options
        Whether the command has the options for these, so that messages may name them.
    """
    wanted = _Wanted(parameters, normalize, options)
    data = _contents(path)
    try:
        with warnings.catch_warnings():
            # sizes are checked before any pixel is decoded, and damaged files end in an exception
            warnings.simplefilter("ignore")
            decoded = _decoded(data, str(path), wanted)
    except BadInput:
        raise
    except Image.DecompressionBombError as error:
        raise BadInput(
            f"{path} has more than {2 * (Image.MAX_IMAGE_PIXELS or 0)} pixels; {wanted.allowed_size}"
        ) from error
    except Exception as error:
        if "imagecodecs" in str(error):
            raise BadInput(
                f"{path} is packed or compressed in a way that only the package imagecodecs reads (pip install "
                "imagecodecs); allowed without it: numbers of whole bytes, not compressed or plainly deflated"
            ) from error
        # from SyntaxError to struct.error
        raise BadInput(f"{path} is damaged: {one_line(error)}; allowed: a complete image file") from error
    wanted.check_size(str(path), decoded.grey.shape[::-1])
    return wanted.pixels(decoded, str(path))


def _contents(path: Path) -> bytes:
    try:
        with path.open("rb") as file:
            data = file.read(_LARGEST_FILE + 1)
    except FileNotFoundError as error:
        raise BadInput(f"{path} does not exist; allowed: an image file") from error
    except OSError as error:
        raise BadInput(f"{path} cannot be read: {reason(error)}; allowed: a readable image file") from error
    if len(data) > _LARGEST_FILE:
        raise BadInput(f"{path} is larger than {_LARGEST_FILE >> 30} GiB; allowed: image files up to that")
    return data


def _decoded(data: bytes, name: str, wanted: _Wanted) -> Decoded:
    header = read_header(data)
    if header is None:
        raise BadInput(
            f"{name} is not an image that can be read; allowed: PNG, JPEG, TIFF, GIF, WebP, BMP, PGM and PPM, "
            "JPEG 2000, AVIF, SGI"
        )
    hint = "; with --normalize, any numbers" if wanted.options else ""
    check_kind(header, name, normalize=wanted.normalize, hint=hint)
    try:
        return decode(data, header, lambda size: wanted.check_size(name, size, turned=True))
    except UnidentifiedImageError as error:
        raise BadInput(
            f"{name} is damaged, or {kind(header)} that cannot be read; allowed: complete files, {ALLOWED}"
        ) from error
