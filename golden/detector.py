"""The detector on images and on streams of frames; what it does with each is ``golden.frame``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from golden.checks import check_integer, check_type
from golden.corners import ByValue, Corners
from golden.formats import SUPPORT
from golden.frame import Frame, History
from golden.output_constructor import NO_LIMIT, FrameEnd, Records, decode, encode_frame_end
from golden.parameters import Parameters
from golden.preprocessing import Image
from golden.settings import Settings
from golden.thresholds import Thresholds


def pixel_dtype(parameters: Parameters) -> np.dtype[np.unsignedinteger[Any]]:
    """What an image consists of: uint8, or uint16 for more than 8 pixel bits."""
    return np.dtype(np.uint8 if parameters.pixel_bits <= 8 else np.uint16)


def chosen_parameters(parameters: Parameters | None) -> Parameters:
    """The detector that was asked for, by default the profile ``robust``; ``TypeError`` if it is
    something else.
    """
    if parameters is None:
        return Parameters()
    check_type("parameters", parameters, Parameters)
    return parameters


def chosen_settings(settings: Settings | None, parameters: Parameters) -> Settings:
    """The thresholds that were asked for; ``TypeError`` or ``ValueError`` if this detector cannot
    have them.
    """
    if settings is None:
        return Settings.default(parameters)
    check_type("settings", settings, Settings)
    settings.check(parameters)
    return settings


def check_image(image: object, parameters: Parameters) -> Image:
    """The image itself if this detector can take it, else ``TypeError`` or ``ValueError`` saying
    why.
    """
    check_type("parameters", parameters, Parameters)
    if not isinstance(image, np.ndarray) or isinstance(image, (np.ma.MaskedArray, np.matrix)):
        raise TypeError(f"image is a {type(image).__name__}; allowed: a plain NumPy array")
    dtype = pixel_dtype(parameters)
    if image.dtype != dtype:
        raise TypeError(
            f"image has dtype {image.dtype}; allowed: {dtype} ({parameters.pixel_bits}-bit pixels)"
        )
    if image.ndim != 2:
        raise ValueError(f"image has shape {image.shape}; allowed: (height, width), one channel")
    height, width = image.shape
    if not (SUPPORT <= width <= parameters.max_width and SUPPORT <= height <= parameters.max_height):
        raise ValueError(
            f"image is {width}x{height}; allowed: {SUPPORT}x{SUPPORT} "
            f"to {parameters.max_width}x{parameters.max_height} (the built maximum)"
        )
    if parameters.pixel_bits != 8 * dtype.itemsize and image.max() > parameters.pixel_max:
        raise ValueError(f"image has a pixel of {image.max()}; allowed: 0 to {parameters.pixel_max}")
    return image


def detect(
    image: NDArray[np.unsignedinteger[Any]],
    parameters: Parameters | None = None,
    settings: Settings | None = None,
    *,
    reference: int | None = None,
) -> Corners:
    """Corners of one image, bit by bit what the hardware reports.

    Parameters
    ----------
    image
        (height, width) uint8 (uint16 for more than 8 pixel bits), 15x15 up to the built maximum.
    parameters, settings
        The detector and its thresholds; by default the profile ``robust`` and ``Settings.default``.
    reference
        Dref. By default the constant if the settings say so, else the image's own largest D: what
        the hardware uses from the second frame on while the scene stands still, and OpenCV's
        ``qualityLevel``. ``target_corners`` and ``reference_rank`` are likewise those of the
        image's own corners.

    Raises
    ------
    TypeError, ValueError
        Wrong type, dtype, rank or size; thresholds or reference that this detector cannot have.
    """
    return detection(image, parameters, settings, reference=reference).corners


class Detection(NamedTuple):
    """The corners of one image, and the reference and thresholds that they were found with."""

    corners: Corners
    reference: int
    limits: Thresholds


def detection(
    image: NDArray[np.unsignedinteger[Any]],
    parameters: Parameters | None = None,
    settings: Settings | None = None,
    *,
    reference: int | None = None,
) -> Detection:
    """As :func:`detect`, with reference and thresholds."""
    parameters = chosen_parameters(parameters)
    settings = chosen_settings(settings, parameters)
    image = check_image(image, parameters)
    if reference is not None:
        check_integer("reference", reference, 0, parameters.response_max)
        reference = int(reference)
    frame = Frame(image, parameters, settings)
    reference, limits = frame.own_thresholds(reference)
    records = frame.within_budget(frame.records(limits))
    return Detection(decode(records), reference, limits)


@dataclass(frozen=True, eq=False)
class FrameResult(ByValue):
    """One frame as the hardware delivers it: all its records, the last one marking its end.

    ``found`` counts the corners that ``max_corners`` left out, too; ``t1`` is the threshold they
    are above, ``t2`` that of the texture filter, and ``reference`` Dref.
    """

    records: Records
    corners: Corners
    maximum: int
    found: int
    t1: int
    t2: int
    reference: int


class StreamModel:
    """The detector on a stream of frames: each frame's largest D is the next one's reference.

    Likewise, where a target or a rank is set, a frame's corners decide about the next one's T1 or
    reference. ``frame`` is the number of the next frame since reset.
    """

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = chosen_parameters(parameters)
        self.reset()

    def reset(self) -> None:
        """Forget the previous frame and start counting from 0, as a hardware reset does."""
        self.frame = 0
        self._history = History()

    @property
    def history(self) -> History:
        """What the next frame follows."""
        return self._history

    def process(
        self,
        image: NDArray[np.unsignedinteger[Any]],
        settings: Settings | None = None,
        *,
        max_records: int = NO_LIMIT,
    ) -> FrameResult:
        """Next frame of the stream; raises what :func:`detect` raises.

        Parameters
        ----------
        image, settings
            As for :func:`detect`.
        max_records
            Corners reported, at most, accepted or not, as the register MAX_RECORDS has it.
        """
        frame = self._begin(image, settings)
        check_integer("max_records", max_records, 0, NO_LIMIT)
        reference, limits = frame.thresholds(self._history)
        found = frame.records(limits)
        records = frame.within_budget(found)[:max_records]
        end = encode_frame_end(FrameEnd(len(records), self.frame, frame.maximum))
        self._history = frame.following(limits, self._history)
        self.frame += 1
        words = np.append(records, np.uint64(end))
        return FrameResult(words, decode(records), frame.maximum, len(found), *limits, reference)

    def cut(
        self, image: NDArray[np.unsignedinteger[Any]], settings: Settings | None = None, *, pixels: int
    ) -> Records:
        """Next frame of the stream, of which only the first so many pixels came, in raster order.

        Returns the records of the corners that these decide, without an end. The next frame follows
        the same history as this one.
        """
        frame = self._begin(image, settings)
        _, limits = frame.thresholds(self._history)
        self.frame += 1
        return frame.within_budget(frame.records(limits, pixels=pixels))

    def _begin(self, image: NDArray[np.unsignedinteger[Any]], settings: Settings | None) -> Frame:
        settings = chosen_settings(settings, self.parameters)
        return Frame(check_image(image, self.parameters), self.parameters, settings)
