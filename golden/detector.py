"""The detector on one image and on a stream of frames, by the steps of ``golden.frame``."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from golden.checks import check_integer, check_type
from golden.corners import ByValue, Corners
from golden.frame import Frame, History
from golden.output_constructor import NO_LIMIT, FrameEnd, Records, decode, encode_frame_end
from golden.parameters import Parameters
from golden.preprocessing import Image
from golden.settings import Settings
from golden.thresholds import Thresholds


def pixel_dtype(parameters: Parameters) -> np.dtype[np.unsignedinteger[Any]]:
    """The dtype of images: uint8, or uint16 for more than 8 pixel bits."""
    return np.dtype(np.uint8 if parameters.pixel_bits <= 8 else np.uint16)


def chosen_parameters(parameters: Parameters | None) -> Parameters:
    """The detector that was asked for, by default the profile ``robust``.

    ``TypeError`` if it is not :class:`Parameters`.
    """
    if parameters is None:
        return Parameters()
    check_type("parameters", parameters, Parameters)
    return parameters


def chosen_settings(settings: Settings | None, parameters: Parameters) -> Settings:
    """The settings that were asked for, by default ``Settings.default``.

    ``TypeError`` or ``ValueError`` if this detector cannot have them.
    """
    if settings is None:
        return Settings.default(parameters)
    check_type("settings", settings, Settings)
    settings.check(parameters)
    return settings


def check_image(image: object, parameters: Parameters) -> Image:
    """The image itself; ``TypeError`` or ``ValueError`` if this detector cannot take it."""
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
    least_width, least_height = parameters.min_width, parameters.algorithm.support
    if not (least_width <= width <= parameters.max_width and least_height <= height <= parameters.max_height):
        raise ValueError(
            f"image is {width}x{height}; allowed: {least_width}x{least_height} "
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
    """Corners of one image, bit by bit as the hardware reports them.

    Parameters
    ----------
    image
        (height, width) uint8 (uint16 for more than 8 pixel bits), each side from
        ``Algorithm.support`` up to the built maximum.
    parameters, settings
        The detector and its settings; by default the profile ``robust`` and ``Settings.default``.
    reference
        Dref. By default it is the constant if the settings say so, else the image's own largest D:
        the hardware has the same Dref from the second frame on while the scene stands still, and
        OpenCV's ``qualityLevel`` refers to it, too. In the same way, ``target_corners`` and
        ``reference_rank`` count the image's own corners.

    Raises
    ------
    TypeError, ValueError
        The image has a wrong type, dtype, rank or size, or this detector cannot have such settings
        or such a reference.
    """
    return detection(image, parameters, settings, reference=reference).corners


class Detection(NamedTuple):
    """The corners of one image, with their reference and thresholds."""

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
    """The same as :func:`detect`, with the reference and the thresholds beside the corners."""
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
    """One frame of a stream, as the hardware delivers it.

    Attributes
    ----------
    records
        (n,) uint64: all records, with the end-of-frame record as the last one.
    corners
        The corners of these records, without the end-of-frame record.
    maximum
        The largest D at which a corner may be, which is the next frame's reference.
    found
        Number of corners, with those that cells, ``max_corners`` or ``max_records`` left out.
    t1, t2, reference
        The thresholds and Dref.
    """

    records: Records
    corners: Corners
    maximum: int
    found: int
    t1: int
    t2: int
    reference: int


class StreamModel:
    """The detector on a stream of frames: the largest D of each frame is the next one's reference.

    Where a target or a rank is set, the corners of each frame decide the next one's T1 or
    reference.

    Parameters
    ----------
    parameters
        The detector, by default the profile ``robust``.

    Attributes
    ----------
    frame
        Number of the next frame, from 0 after a reset.
    """

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = chosen_parameters(parameters)
        self.reset()

    def reset(self) -> None:
        """Forget the previous frame, and count frames from 0 again, as a hardware reset does."""
        self.frame = 0
        self._history = History()

    @property
    def history(self) -> History:
        """What the next frame takes from the last complete one."""
        return self._history

    def process(
        self,
        image: NDArray[np.unsignedinteger[Any]],
        settings: Settings | None = None,
        *,
        max_records: int = NO_LIMIT,
    ) -> FrameResult:
        """Next frame of the stream.

        Parameters
        ----------
        image, settings
            As for :func:`detect`.
        max_records
            Largest number of corners reported, accepted or not, as the register MAX_RECORDS sets
            it.

        Raises
        ------
        TypeError, ValueError
            As for :func:`detect`; or ``max_records`` is not allowed.
        """
        frame = self._begin(image, settings)
        check_integer("max_records", max_records, 0, NO_LIMIT)
        reference, limits = frame.thresholds(self._history)
        found = frame.corners(limits)
        records = frame.within_budget(frame.encoded(frame.chosen(found)))[:max_records]
        end = encode_frame_end(FrameEnd(len(records), self.frame, frame.maximum))
        self._history = frame.next_history(limits, self._history)
        self.frame += 1
        words = np.append(records, np.uint64(end))
        return FrameResult(words, decode(records), frame.maximum, len(found.x), *limits, reference)

    def cut(
        self, image: NDArray[np.unsignedinteger[Any]], settings: Settings | None = None, *, pixels: int
    ) -> Records:
        """Next frame of the stream, which is cut short; the history stays as it is.

        Parameters
        ----------
        image, settings
            As for :func:`detect`; the pixels that did not come can be anything.
        pixels
            Number of pixels that came, in raster order.

        Returns the records of the corners that these pixels decide, without an end-of-frame record.
        Raises what :meth:`process` raises.
        """
        frame = self._begin(image, settings)
        _, limits = frame.thresholds(self._history)
        self.frame += 1
        return frame.within_budget(frame.records(limits, pixels=pixels))

    def _begin(self, image: NDArray[np.unsignedinteger[Any]], settings: Settings | None) -> Frame:
        settings = chosen_settings(settings, self.parameters)
        return Frame(check_image(image, self.parameters), self.parameters, settings)
