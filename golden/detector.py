"""The whole detector: an image in, corners out, by the blocks of Fig. 9 in their order."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden.adaptation import adapted_threshold, histogram, smoothed
from golden.adaptive_threshold import adaptive_threshold
from golden.checks import check_integer, check_type
from golden.convolution import smooth
from golden.corner_detection import corner_detection
from golden.corners import ByValue, Corners
from golden.formats import MARGIN, SUPPORT, WINDOW_SIZE
from golden.normal_equations import PIXEL_SIZE
from golden.output_constructor import FrameEnd, Records, decode, encode, encode_frame_end
from golden.parameters import Parameters
from golden.preprocessing import Image, IntArray, gradients, products
from golden.response import response
from golden.response_filter import response_filter
from golden.settings import Settings
from golden.subpixel import subpixel
from golden.texture_filter import texture_filter
from golden.thresholds import Thresholds, choose_reference, thresholds

RESPONSE_MARGIN = 3
"""Pixels at each edge of a frame that have no response: gradient 1 and smoothing 2."""
_STRIP_ROWS = 32


def pixel_dtype(parameters: Parameters) -> np.dtype[np.unsignedinteger[Any]]:
    """What an image consists of: uint8, or uint16 for more than 8 pixel bits."""
    return np.dtype(np.uint8 if parameters.pixel_bits <= 8 else np.uint16)


def chosen_parameters(parameters: Parameters | None) -> Parameters:
    """The detector that was asked for, by default the profile ``paper``; ``TypeError`` if it is
    something else.
    """
    if parameters is None:
        return Parameters.profile("paper")
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


def response_map(image: Image, parameters: Parameters) -> IntArray:
    """D of every pixel that has one: (height, width) in, (height-6, width-6) int32 out.

    Worked off in strips of rows, so that the intermediate arrays stay in the processor's cache.
    """
    height, width = image.shape
    result = np.empty((height - 2 * RESPONSE_MARGIN, width - 2 * RESPONSE_MARGIN), dtype=np.int32)
    for top in range(0, len(result), _STRIP_ROWS):
        strip = image[top : top + _STRIP_ROWS + 2 * RESPONSE_MARGIN]
        gx, gy = gradients(strip, parameters.algorithm.derivative)
        a, b, c = (smooth(product) for product in products(gx, gy, parameters.algorithm.gradient))
        result[top : top + _STRIP_ROWS] = response(a, b, c)
    return result


def peak_responses(responses: IntArray, parameters: Parameters) -> IntArray:
    """The responses whose peaks are corners: of all pixels that can be reported, and as far around
    as that needs.

    (height, width) in, (height - 8 + 2·suppression, width - 8 + 2·suppression) out.
    """
    edge = WINDOW_SIZE // 2 - parameters.algorithm.suppression
    if parameters.algorithm.response_filter == "binomial":
        edge -= 1
    height, width = responses.shape
    inside = responses[edge : height - edge, edge : width - edge]
    return response_filter(inside) if parameters.algorithm.response_filter == "binomial" else inside


def largest_response(responses: IntArray, parameters: Parameters) -> int:
    """The largest response of the pixels that can be reported, of which thresholds are fractions."""
    radius = parameters.algorithm.suppression
    return int(peak_responses(responses, parameters)[radius:-radius, radius:-radius].max())


def corner_map(responses: IntArray, t1: int, parameters: Parameters) -> NDArray[np.bool_]:
    """E of all pixels that can be reported, from all responses: (height, width) in, (height-8,
    width-8) out.
    """
    return corner_detection(
        peak_responses(responses, parameters), t1, parameters.algorithm.ties, parameters.algorithm.suppression
    )


def frame_records(
    image: Image,
    responses: IntArray,
    limits: Thresholds,
    parameters: Parameters,
    report_rejected: bool,
    *,
    pixels: int | None = None,
) -> Records:
    """Records of one frame's corners, in raster order, from its pixels and their response map.

    With ``pixels``, only of those whose whole support lies in the frame's first so many pixels, in
    raster order.
    """
    radius = parameters.algorithm.suppression
    peaks = peak_responses(responses, parameters)
    rows, columns = np.nonzero(corner_detection(peaks, limits.t1, parameters.algorithm.ties, radius))
    if pixels is not None:
        width = responses.shape[1] + 2 * RESPONSE_MARGIN
        decided = (rows + 2 * MARGIN) * width + columns + 2 * MARGIN < pixels
        rows, columns = rows[decided], columns[decided]
    windows = sliding_window_view(responses, (WINDOW_SIZE, WINDOW_SIZE))[rows, columns]
    values = peaks[rows + radius, columns + radius]
    if parameters.algorithm.texture == "mean":
        accepted, values = adaptive_threshold(values, windows, limits.t1, limits.t2)
    else:
        accepted = texture_filter(windows, limits.t2, parameters.algorithm.patches)
    if not report_rejected:
        rows, columns, values = rows[accepted], columns[accepted], values[accepted]
        accepted = accepted[accepted]
    around = MARGIN - PIXEL_SIZE // 2
    pixel_windows = None
    if parameters.algorithm.fit == "gradient":
        pixel_windows = sliding_window_view(image, (PIXEL_SIZE, PIXEL_SIZE))[rows + around, columns + around]
    patches = sliding_window_view(peaks, (3, 3))[rows + radius - 1, columns + radius - 1]
    offset = subpixel(patches, parameters, pixel_windows)
    return encode(columns + MARGIN, rows + MARGIN, values, offset, ~accepted)


def within_budget(records: Records, settings: Settings) -> Records:
    """Those of a frame's records that are reported: up to the last that ``max_corners`` allows to
    be accepted.
    """
    if not settings.max_corners:
        return records
    accepted = np.flatnonzero(decode(records).accepted)
    if len(accepted) < settings.max_corners:
        return records
    return records[: accepted[settings.max_corners - 1] + 1]


def next_adapted(
    image: Image,
    responses: IntArray,
    limits: Thresholds,
    parameters: Parameters,
    settings: Settings,
    previous: int | None = None,
) -> int | None:
    """The D that as many corners of a frame exceed as a target or a rank asks for; None if there is
    neither.

    Counted are the corners that the texture filter keeps, with or without ``report_rejected`` and
    ``max_corners``. For a rank the paper's filter is not asked: T2, a fraction of what comes out,
    would make a loop of it.

    Parameters
    ----------
    previous
        What came out for the frame before, for ``smoothing``.
    """
    if not settings.wanted_corners:
        return None
    everything = limits._replace(t1=0)
    all_peaks = parameters.algorithm.texture == "patches" and settings.by_rank
    records = frame_records(image, responses, everything, parameters, report_rejected=all_peaks)
    counts = histogram(decode(records).response.astype(np.int64), parameters)
    adapted = adapted_threshold(counts, settings.wanted_corners, parameters)
    return adapted if previous is None else smoothed(previous, adapted, settings.smoothing)


def frame_thresholds(
    image: Image, responses: IntArray, parameters: Parameters, settings: Settings, given: int | None
) -> tuple[int, Thresholds]:
    """Dref and thresholds of an image by itself, with the given Dref if there is one: see
    :func:`detect`.
    """
    maximum = largest_response(responses, parameters)
    reference = choose_reference(settings, maximum) if given is None else given
    limits = thresholds(settings, reference, parameters)
    adapted = next_adapted(image, responses, limits, parameters, settings)
    if given is None:
        reference = choose_reference(settings, maximum, adapted)
    return reference, thresholds(settings, reference, parameters, adapted)


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
        The detector and its thresholds; by default the profile ``paper`` and ``Settings.default``.
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
    responses = response_map(image, parameters)
    if reference is not None:
        check_integer("reference", reference, 0, parameters.response_max)
        reference = int(reference)
    reference, limits = frame_thresholds(image, responses, parameters, settings, reference)
    records = frame_records(image, responses, limits, parameters, settings.report_rejected)
    return Detection(decode(within_budget(records, settings)), reference, limits)


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

    Likewise a frame's corners decide about the next one's T1 or reference, where both have a target
    or a rank.
    """

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = chosen_parameters(parameters)
        self.reset()

    def reset(self) -> None:
        """Forget the previous frame and start counting from 0, as a hardware reset does."""
        self._previous_maximum: int | None = None
        self._adapted: int | None = None
        self._frame = 0

    def process(
        self, image: NDArray[np.unsignedinteger[Any]], settings: Settings | None = None
    ) -> FrameResult:
        """Next frame of the stream; raises what :func:`detect` raises."""
        settings = chosen_settings(settings, self.parameters)
        image = check_image(image, self.parameters)
        responses = response_map(image, self.parameters)
        maximum = largest_response(responses, self.parameters)
        reference = choose_reference(settings, self._previous_maximum, self._adapted)
        limits = thresholds(settings, reference, self.parameters, self._adapted)
        every = frame_records(image, responses, limits, self.parameters, settings.report_rejected)
        records = within_budget(every, settings)
        end = encode_frame_end(FrameEnd(len(records), self._frame, maximum))
        self._previous_maximum = maximum
        self._adapted = next_adapted(image, responses, limits, self.parameters, settings, self._adapted)
        self._frame += 1
        words = np.append(records, np.uint64(end))
        return FrameResult(words, decode(records), maximum, len(every), *limits, reference)
