# amaranth: UnusedElaboratable=no
"""Savings and cost of fewer bits: in A, B and C after smoothing, in D, and in the mantissas.

Accuracy is that of the golden model's own functions with some of their results cut. Area is that of
the blocks that hold these numbers, built for so many bits and mapped to Cyclone IV as
``cornerstream synth`` does it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from amaranth.lib import wiring
from numpy.typing import NDArray

from evaluation.figures import Figures, Notify
from evaluation.inputs import scenes
from evaluation.inputs.scenes import Kind, Scene
from evaluation.inputs.sources import NamedImage, photographs
from evaluation.methods.bootstrap import Statistic, Values, estimate, median
from flow.cyclone4.area import Area
from flow.cyclone4.synthesis import map_component
from golden import Corners, Parameters, Settings, decode
from golden.convolution import KERNEL, SHIFT
from golden.derivatives import Derivatives
from golden.formats import OFFSET_BITS
from golden.frame import Frame, response_map
from golden.normal_equations import normal_equations, window_place
from golden.pixel_filter import pixel_filter
from golden.preprocessing import IntArray, gradients, products
from golden.response import response
from golden.subpixel import FITS, derivative_bits, peak, subpixel
from golden.thresholds import Thresholds, thresholds
from hdl.build import Build
from hdl.parts.circular_buffer import CircularBuffer
from hdl.response import Response
from hdl.subpixel import Subpixel
from hdl.window_stage import WindowStage

Responses = Callable[[NDArray[np.uint8]], IntArray]

KINDS: tuple[Kind, ...] = ("L", "saddle")
EVERY = 7
"""One of so many scenes of the wide set is used.

The number is coprime to the numbers of noises and polarities, which alternate.
"""
TENSOR_BITS = (16, 14, 12, 10)
RESPONSE_CUTS = (0, 1, 2, 4)
MANTISSAS = (8, 10, 11, 12, 13, 14)
WITHIN = 4.0
"""A corner at most so many pixels from a rendered one counts as that one."""
WIDTH = 1200
"""Pixels of the line buffers, as in the paper's Table 1."""


@dataclass(frozen=True, kw_only=True)
class _Narrow(Build):
    """A detector whose D has some bits less: for its blocks' area only."""

    cut: int = 0

    @property
    def response_max(self) -> int:
        return super().response_max >> self.cut


def word_lengths(parameters: Parameters, *, quick: bool = False, notify: Notify | None = None) -> Figures:
    """Sweeps of the widths that cost most, for one detector with 8-bit pixels.

    Parameters
    ----------
    parameters
        The detector; only what a sweep is about is cut.
    quick
        Fewer points, photographs and scenes.

    Returns
    -------
    dict
        For ``"tensor"`` (A, B, C), ``"response"`` (D) and ``"mantissa"`` a list of points. Each has
        ``bits``, whether they are the ``default``, ``area`` of the blocks named in ``blocks``
        (``le``, ``memory_bits``), and the accuracy that is left. The first two have ``same``: the
        number of corners of photographs found both with all bits and with these, divided by the
        number found with either, with the default thresholds; and per kind the ``median`` distance
        to rendered corners in px.
        Mantissas have ``error``: median, 95th and 99th percentile of the distance to the exact
        offset in px.

    Raises
    ------
    ToolNotFoundError, ToolError
        Synthesis is not possible.
    """
    images = photographs(quick=quick)
    rendered = {kind: _scenes(kind, quick) for kind in KINDS}
    few = 2 if quick else None
    result: Figures = {"blocks": {"tensor": "response", "response": _D_BLOCKS, "mantissa": "subpixel"}}
    sweeps: tuple[tuple[str, Iterator[Figures]], ...] = (
        ("tensor", _tensor(parameters, images, rendered, TENSOR_BITS[:few])),
        ("response", _response(parameters, images, rendered, RESPONSE_CUTS[:few])),
        ("mantissa", _mantissa(parameters, images, MANTISSAS[1:4:2] if quick else MANTISSAS)),
    )
    for name, points in sweeps:
        result[name] = []
        for point in points:
            result[name].append(point)
            if notify:
                notify(1)
    return result


def steps(*, quick: bool = False) -> int:
    """How often :func:`word_lengths` notifies."""
    return 6 if quick else len(TENSOR_BITS) + len(RESPONSE_CUTS) + len(MANTISSAS)


def _scenes(kind: Kind, quick: bool) -> list[Scene]:
    return list(scenes.wide_set(kind, quick=quick))[:: 1 if quick else EVERY]


# -- A, B and C


def _built(parameters: Parameters, **changes: Any) -> Build:
    """The detector as it is built by default."""
    usual: dict[str, Any] = {"algorithm": parameters.algorithm, "pixel_bits": parameters.pixel_bits}
    return replace(Build(), **usual | changes)


def _tensor(
    parameters: Parameters,
    images: Sequence[NamedImage],
    rendered: dict[Kind, list[Scene]],
    widths: Sequence[int],
) -> Iterator[Figures]:
    full = parameters.product_bits
    for bits in widths:
        cut = full - bits

        def responses(image: NDArray[np.uint8], cut: int = cut) -> IntArray:
            algorithm = parameters.algorithm
            pixels = pixel_filter(image, algorithm.pixel_passes)
            parts = products(*gradients(pixels, algorithm.derivative), algorithm.gradient)
            a, b, c = (_smooth(part, cut) for part in parts)
            return response(a, b, c, parameters)

        # the same block for pixels of fewer bits
        block = Response(_built(parameters, pixel_bits=parameters.pixel_bits - cut // 2))
        yield {
            "bits": bits,
            "default": bits == full,
            "area": _area(block),
            **_detections(parameters, images, rendered, responses, cut),
        }


def _smooth(product: IntArray, cut: int) -> IntArray:
    """The same as ``golden.convolution.smooth``, with ``cut`` bits less."""
    windows = np.lib.stride_tricks.sliding_window_view(product, KERNEL.shape)
    total = np.einsum("yxvu,vu->yx", windows, KERNEL)
    half = 1 << (SHIFT + cut - 1)
    rounded: IntArray = (total + half - 1 + (total >= 0)) >> (SHIFT + cut)
    return rounded


# -- D


_D_BLOCKS = "response buffer, and what looks at its windows"


def _d_area(parameters: Build) -> Figures:
    """Area of the blocks that look at windows of D."""
    windows, size = WindowStage(parameters), parameters.algorithm.window_size
    buffer = CircularBuffer(parameters.response_bits, size, WIDTH, parameters.buffering, registers=1)
    centres = [] if windows.centre_rows is None else [windows.centre_rows]
    blocks = (buffer, *windows.texture_filters.values(), *centres, windows.corner_detection)
    return _plain(sum((map_component(block, "part")[0].area for block in blocks), start=Area()))


def _response(
    parameters: Parameters,
    images: Sequence[NamedImage],
    rendered: dict[Kind, list[Scene]],
    cuts: Sequence[int],
) -> Iterator[Figures]:
    fields = vars(parameters)
    for cut in cuts:

        def responses(image: NDArray[np.uint8], cut: int = cut) -> IntArray:
            return response_map(image, parameters) >> cut

        narrow = _Narrow(**{**fields, "max_width": WIDTH}, cut=cut)
        yield {
            "bits": parameters.response_bits - cut,
            "default": cut == 0,
            "area": _d_area(narrow),
            **_detections(parameters, images, rendered, responses, cut),
        }


def _ratio(values: Values) -> Values:
    """Ratio of the sums of both columns."""
    part, whole = np.moveaxis(values.sum(axis=-2), -1, 0)
    return np.where(whole > 0, part / np.maximum(whole, 1), np.nan)


def _detections(
    parameters: Parameters,
    images: Sequence[NamedImage],
    rendered: dict[Kind, list[Scene]],
    responses: Responses,
    cut: int,
) -> Figures:
    shared = []
    for image in images:
        exact = _pixels(image.pixels, response_map(image.pixels, parameters), parameters, 0)
        found = _pixels(image.pixels, responses(image.pixels), parameters, cut)
        shared.append(np.array([[len(exact & found), len(exact | found)]]))
    result: Figures = {"same": estimate(shared, _ratio)}
    for kind, some in rendered.items():
        distances = []
        for scene in some:
            corners = _corners(scene.image, responses(scene.image), parameters, cut)
            nearest = np.hypot(corners.x - scene.x, corners.y - scene.y).min(initial=np.inf)
            distances.append(np.array([nearest] if nearest < WITHIN else []))
        result[kind] = {
            "median": estimate(distances, median),
            "detected": sum(map(len, distances)),
            "of": len(some),
        }
    return result


def _frame(
    image: NDArray[np.uint8], responses: IntArray, parameters: Parameters, cut: int
) -> tuple[Frame, Thresholds]:
    """With the default thresholds, in units of what is left of D."""
    settings = Settings.default(parameters)
    frame = Frame(image, parameters, settings, responses)
    return frame, thresholds(settings, max(frame.maximum, settings.floor >> cut), parameters)


def _corners(image: NDArray[np.uint8], responses: IntArray, parameters: Parameters, cut: int) -> Corners:
    frame, limits = _frame(image, responses, parameters, cut)
    return decode(frame.records(limits))


def _pixels(
    image: NDArray[np.uint8], responses: IntArray, parameters: Parameters, cut: int
) -> set[tuple[int, int]]:
    """Pixels of the corners, before any subpixel step."""
    frame, limits = _frame(image, responses, parameters, cut)
    corners = frame.corners(limits)
    return set(zip(corners.x.tolist(), corners.y.tolist(), strict=True))


# -- mantissas


def _mantissa(
    parameters: Parameters, images: Sequence[NamedImage], widths: Sequence[int]
) -> Iterator[Figures]:
    step, fit = parameters.changed(fit="gradient"), FITS["gradient"]
    sums = [_first_sums(image.pixels, step) for image in images]
    exact = [_solution(*(part.astype(np.float64) for part in parts)) for parts in sums]
    for kept in widths:
        errors = []
        for parts, truth in zip(sums, exact, strict=True):
            offset = peak(parts, derivative_bits(step), kept, fit.limit)
            given = np.stack([offset.dx, offset.dy]) / (1 << OFFSET_BITS)
            inside = np.abs(truth).max(axis=0) < fit.limit / (1 << OFFSET_BITS)
            errors.append(np.hypot(*(given - truth))[inside])
        block = Subpixel(step, kept)
        yield {
            "bits": kept,
            "default": kept == fit.mantissa_bits,
            "area": _area(block),
            "clocks": block.interval,
            "error": {
                "median": estimate(errors, median),
                **{f"p{share}": estimate(errors, _percentile(share)) for share in (95, 99)},
            },
        }


def _first_sums(image: NDArray[np.uint8], parameters: Parameters) -> Derivatives[NDArray[np.int64]]:
    """Sums of the first step from every corner above the default T1, also from rejected ones."""
    frame = Frame(image, parameters, Settings.default(parameters))
    _, limits = frame.own_thresholds()
    samples, pixels = frame.surroundings(frame.candidates(limits))
    surface = subpixel(samples, parameters.changed(fit="nine"))
    return normal_equations(pixels, window_place(surface.dx), window_place(surface.dy))


def _solution(
    xx: NDArray[np.float64],
    yy: NDArray[np.float64],
    xy: NDArray[np.float64],
    x: NDArray[np.float64],
    y: NDArray[np.float64],
) -> NDArray[np.float64]:
    determinant = xx * yy - xy * xy
    with np.errstate(divide="ignore", invalid="ignore"):
        solved = np.stack([yy * x + xy * y, xx * y + xy * x]) / determinant
    return np.where(determinant > 0, solved, np.inf)


def _percentile(share: int) -> Statistic:
    return lambda values: np.asarray(np.percentile(values[..., 0], share, axis=-1))


# -- area


def _area(block: wiring.Component) -> Figures:
    return _plain(map_component(block, "part")[0].area)


def _plain(area: Area) -> Figures:
    return {"le": area.le_packed, "memory_bits": area.memory_bits}
