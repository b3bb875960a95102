"""The whole algorithm in plain float64, for reading beside the paper.

Nothing is rounded: there is no integer square root, no rounding after the kernel, no quantised
threshold; surfaces are fitted by linear algebra, without mantissas. Only the decisions (maximum,
thresholds, clamp) are discrete, as in the paper itself. The model shares no arithmetic with the
bit-exact blocks, so that each can reveal the other's mistakes.

Every map has the size of the image and is indexed ``[y, x]``. It is NaN near the frame's edge,
where it is undefined.
"""

from __future__ import annotations

from numbers import Real
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden.algorithm import Algorithm, Derivative, Fit, Patches
from golden.corners import Corners, Flag
from golden.detector import check_image, chosen_parameters, chosen_settings
from golden.parameters import Parameters
from golden.responses import response_function
from golden.settings import Settings

LEVEL_GAIN = 81 / 64
"""Factor of the mean in the adaptive threshold, beside sigma2."""

Map = NDArray[np.float64]
"""(height, width) float64."""

KERNEL: Map = (
    np.array(
        [
            [8, 16, 16, 16, 8],
            [16, 32, 32, 32, 16],
            [16, 32, 32, 32, 16],
            [16, 32, 32, 32, 16],
            [8, 16, 16, 16, 8],
        ]
    )
    / 512
)
"""Eq. 1, with the misprinted 19/512 read as 16/512."""

SOBEL: Map = np.array([[1, 0, -1], [2, 0, -2], [1, 0, -1]]) / 4
"""Kernel of gx, with the paper's sign; that of gy is its transpose."""
BINOMIAL: Map = np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]]) / 16

GRID_Y, GRID_X = (axis.reshape(-1) - 1 for axis in np.mgrid[:3, :3])
"""y and x of the samples S0 ... S8 of Fig. 7, relative to the centre S4."""
SIX = (0, 3, 5, 7, 2, 6)
"""The samples the paper picks: S0, S3, S5, S7, S2 and S6."""


def _undefined(like: NDArray[Any]) -> Map:
    return np.full(like.shape, np.nan)


def gradients(image: NDArray[Any], derivative: Derivative = "central") -> tuple[Map, Map]:
    """Gx and Gy of Sec. 3.1 before their absolute value is taken."""
    pixels = image.astype(np.float64)
    gx, gy = _undefined(pixels), _undefined(pixels)
    if derivative == "sobel":
        windows = sliding_window_view(pixels, SOBEL.shape)
        gx[1:-1, 1:-1] = np.einsum("yxvu,vu->yx", windows, SOBEL)
        gy[1:-1, 1:-1] = np.einsum("yxvu,uv->yx", windows, SOBEL)
        return gx, gy
    gx[1:-1, 1:-1] = pixels[1:-1, :-2] - pixels[1:-1, 2:]
    gy[1:-1, 1:-1] = pixels[:-2, 1:-1] - pixels[2:, 1:-1]
    return gx, gy


def smooth(values: Map) -> Map:
    """Correlation with Eq. 1, written out in two dimensions."""
    result = _undefined(values)
    result[2:-2, 2:-2] = np.einsum("yxvu,vu->yx", sliding_window_view(values, KERNEL.shape), KERNEL)
    return result


def filtered_pixels(image: NDArray[Any], algorithm: Algorithm) -> Map:
    """The pixels that the gradients are taken of."""
    pixels = image.astype(np.float64)
    for _ in range(algorithm.pixel_passes):
        pixels = binomial(pixels)
    return pixels


def response_map(image: NDArray[Any], algorithm: Algorithm, pixel_bits: int = 8) -> Map:
    """D, such as (A + B) - sqrt((A - B)² + 4C²) (Eq. 2), with NaN where it is undefined."""
    gx, gy = gradients(filtered_pixels(image, algorithm), algorithm.derivative)
    if algorithm.gradient == "absolute":
        gx, gy = np.abs(gx), np.abs(gy)
    a, b, c = smooth(gx * gx), smooth(gy * gy), smooth(gx * gy)
    return response_function(algorithm.response).exact(a, b, c, pixel_bits)


def binomial(values: Map) -> Map:
    """The weighted mean over 3x3 of pixels or responses, written out in two dimensions."""
    result = _undefined(values)
    result[1:-1, 1:-1] = np.einsum("yxvu,vu->yx", sliding_window_view(values, BINOMIAL.shape), BINOMIAL)
    return result


def local_mean(responses: Map, x: int, y: int) -> float:
    """Mean of D over the 9x9 window around (x, y)."""
    return float(responses[y - 4 : y + 5, x - 4 : x + 5].mean())


def corner_map(responses: Map, t1: float, algorithm: Algorithm) -> NDArray[np.bool_]:
    """E (Eqs. 3-5): D > T1 and D above its neighbours, where the whole support is in the frame."""
    corners = np.zeros(responses.shape, dtype=bool)
    radius, margin = algorithm.suppression, algorithm.margin
    side = 2 * radius + 1
    samples = sliding_window_view(responses, (side, side))
    samples = samples.reshape(*samples.shape[:2], side**2)
    middle = side**2 // 2
    centre = samples[..., middle]
    earlier, later = samples[..., :middle].max(axis=-1), samples[..., middle + 1 :].max(axis=-1)
    beats_later = centre > later if algorithm.ties == "strict" else centre >= later
    corners[radius:-radius, radius:-radius] = (centre > earlier) & beats_later & (centre > t1)
    inside = np.zeros_like(corners)
    inside[margin:-margin, margin:-margin] = True
    return corners & inside


def texturization(responses: Map, x: int, y: int, patches: Patches) -> float:
    """tau of the corner at (x, y) (Eqs. 6-8): the difference of the three patches of Fig. 5.

    Patch k consists of four regions, k pixels away along each diagonal. Regions are compared pixel
    by pixel, and their difference is the mean over these pixels.
    """
    reach = 1 if patches == "regions" else 0

    def region(k: int, right: int, down: int) -> Map:
        column, row = x + k * right, y + k * down
        return responses[row - reach : row + reach + 1, column - reach : column + reach + 1]

    diagonals = ((-1, -1), (1, -1), (-1, 1), (1, 1))
    tau12 = sum(np.abs(region(1, *d) - region(2, *d)).mean() for d in diagonals)
    tau23 = sum(np.abs(region(2, *d) - region(3, *d)).mean() for d in diagonals)
    return float(tau12 + tau23)


def design_matrix(x: NDArray[Any], y: NDArray[Any]) -> Map:
    """Rows (x², y², xy, x, y, 1): Eq. 10 at each sample."""
    return np.stack([x * x, y * y, x * y, x, y, np.ones_like(x)], axis=-1).astype(np.float64)


def surface(samples: Map, fit: Fit) -> Map:
    """L0 ... L5 of Eq. 10 for 3x3 samples of D.

    ``"printed"`` follows Eqs. 11 and 12, which do not recover any surface.
    """
    flat = samples.reshape(9)
    six = list(SIX)
    x, y = GRID_X[six], GRID_Y[six]
    if fit in ("nine", "gradient"):
        return np.linalg.lstsq(design_matrix(GRID_X, GRID_Y), flat, rcond=None)[0].astype(np.float64)
    if fit == "six":
        return np.linalg.solve(design_matrix(x, y), flat[six]).astype(np.float64)
    return (np.vander(x) @ np.vander(y) / len(SIX)) @ flat[six]


def peak(coefficients: Map, printed: bool = False) -> tuple[float, float, Flag]:
    """(dx, dy) of Eq. 13 and its flags; each axis is clamped to half a pixel.

    It is (0, 0) where the surface has no maximum. ``printed`` leaves the misprint L2 for L3 and, as
    the paper, does not ask for a maximum.
    """
    l0, l1, l2, l3, l4, _ = coefficients
    denominator = l2**2 - 4 * l0 * l1
    usable = denominator != 0 if printed else l0 < 0 and l1 < 0 and denominator < 0
    if not usable:
        return 0.0, 0.0, Flag.NOT_MAXIMUM
    dx = (2 * l1 * (l2 if printed else l3) - l2 * l4) / denominator
    dy = (2 * l0 * l4 - l2 * l3) / denominator
    flag = Flag.CLAMPED if max(abs(dx), abs(dy)) >= 0.5 else Flag(0)
    return float(np.clip(dx, -0.5, 0.5)), float(np.clip(dy, -0.5, 0.5)), flag


STEP_HALF_WINDOW, STEP_REACH, STEP_LIMIT = 4.0, 7, 4.0
"""Half the side of a step's window, pixels around a corner's pixel, largest offset."""
FARTHEST_WINDOW = 39 / 16
"""A window is centred no farther than this from a corner's pixel along each axis."""


def gradient_step(pixels: NDArray[Any], x: float, y: float) -> tuple[float, float] | None:
    """The point to which the gradients of 15x15 pixels are orthogonal in an 8x8 window.

    There is an equation g·(q - p) = 0 for each pixel p. They are solved by least squares, each
    weighing as much as the window covers of the square of its pixel. The window is centred at (x,
    y), counted from the middle pixel; so is the result. None if all gradients are parallel.
    """
    gx, gy = gradients(pixels)
    places = np.arange(-STEP_REACH, STEP_REACH + 1)

    def covered(middle: float) -> Map:
        middle = float(np.clip(middle, -FARTHEST_WINDOW, FARTHEST_WINDOW))
        lower = np.maximum(places - 0.5, middle - STEP_HALF_WINDOW)
        return np.clip(np.minimum(places + 0.5, middle + STEP_HALF_WINDOW) - lower, 0, None)

    weights = covered(y)[:, None] * covered(x)
    inside = weights > 0
    g = np.stack([gx[inside], gy[inside]], axis=-1) * np.sqrt(weights[inside])[:, None]
    v, u = (places[axis] for axis in np.nonzero(inside))
    (dx, dy), _, rank, _ = np.linalg.lstsq(g, g[:, 0] * u + g[:, 1] * v, rcond=None)
    return None if rank < 2 else (float(dx), float(dy))


def gradient_steps(pixels: NDArray[Any], start: tuple[float, float, Flag]) -> tuple[float, float, Flag]:
    """(dx, dy) and flags after two steps from the surface's peak.

    Where they disagree, the first one counts if it leads half a pixel away, else the peak does.
    """
    unmoved = start[0], start[1], start[2] or Flag.CLAMPED
    first = _step_within_limits(pixels, *start[:2])
    if first is None:
        return unmoved
    second = _step_within_limits(pixels, *first)
    way = max(abs(first[0] - start[0]), abs(first[1] - start[1]))
    if second and 2 * max(abs(second[0] - first[0]), abs(second[1] - first[1])) <= way + 1 / 8:
        return *second, Flag(0)
    return (*first, Flag.CLAMPED) if way >= 0.5 else unmoved


def _step_within_limits(pixels: NDArray[Any], x: float, y: float) -> tuple[float, float] | None:
    """The step, unless it leads too far from its window's middle pixel or from the corner's."""
    found = gradient_step(pixels, x, y)
    middles = np.rint(np.clip([x, y], -FARTHEST_WINDOW, FARTHEST_WINDOW))
    near = found is not None and np.abs([found, found - middles]).max() < STEP_LIMIT
    return found if near else None


def strongest_of_cells(
    corners: list[tuple[float, float, float, int]], cells: list[tuple[int, int]], most: int
) -> list[tuple[float, float, float, int]]:
    """Of the corners in each cell, so many with the largest response, cell by cell."""
    inside: dict[tuple[int, int], list[tuple[float, float, float, int]]] = {}
    for corner, cell in zip(corners, cells, strict=True):
        inside.setdefault(cell, []).append(corner)
    strongest_first = (sorted(inside[cell], key=lambda corner: -corner[2]) for cell in sorted(inside))
    return [corner for each in strongest_first for corner in each[:most]]


def reference_detect(
    image: NDArray[np.unsignedinteger[Any]],
    parameters: Parameters | None = None,
    settings: Settings | None = None,
    *,
    reference: float | None = None,
) -> Corners:
    """Corners of one image by the unrounded algorithm.

    The arguments and what it raises are those of :func:`golden.detect`. Positions are not
    quantised, and ``response`` is float64. A target is met exactly, unless sigma1 · floor or equal
    responses prevent it.
    """
    parameters = chosen_parameters(parameters)
    settings = chosen_settings(settings, parameters)
    image = check_image(image, parameters)
    algorithm = parameters.algorithm
    responses = response_map(image, algorithm, parameters.pixel_bits)
    peaks = binomial(responses) if algorithm.response_filter == "binomial" else responses
    given = reference is not None
    if reference is None:
        constant = settings.reference == "constant"
        inside = slice(algorithm.margin, -algorithm.margin)
        largest = float(peaks[inside, inside].max())
        reference = max(settings.constant if constant else largest, settings.floor)
    elif isinstance(reference, bool) or not isinstance(reference, Real):
        raise TypeError(f"reference is a {type(reference).__name__}; allowed: a number or None")
    elif not 0 <= reference <= parameters.response_max:
        raise ValueError(f"reference is {reference!r}; allowed: 0 to {parameters.response_max}")
    t1, t2 = settings.sigma1 * reference, settings.sigma2 * reference

    def judge(y: int, x: int, t1: float) -> tuple[float, bool]:
        """The response that is reported, and whether the texture filter accepts the corner."""
        value = float(peaks[y, x])
        if algorithm.texture == "patches":
            return value, texturization(responses, x, y, algorithm.patches) < t2
        if algorithm.texture == "mean":
            value -= settings.sigma2 * LEVEL_GAIN * local_mean(responses, x, y)
        return value, value > t1

    ranked = settings.by_rank and settings.reference == "previous" and not given
    if settings.target_corners or ranked:
        everything = corner_map(peaks, 0.0, algorithm)
        judged = [judge(y, x, 0.0) for y, x in np.argwhere(everything).tolist()]
        every = algorithm.texture == "patches" and ranked
        values = sorted(value for value, accepted in judged if accepted or every)
        beyond = max([0.0, *values[: -settings.wanted_corners]])
        if settings.target_corners:
            t1 = max(settings.sigma1 * settings.floor, beyond)
        else:
            reference = max(beyond, settings.floor)
            t1, t2 = settings.sigma1 * reference, settings.sigma2 * reference
    least = 0.0 if settings.target_corners else t1
    corners = corner_map(peaks, least, algorithm)

    found: list[tuple[float, float, float, int]] = []
    cells: list[tuple[int, int]] = []
    for y, x in np.argwhere(corners & (peaks > t1)).tolist():
        value, accepted = judge(y, x, t1)
        if not accepted and not settings.rejected_too:
            continue
        coefficients = surface(peaks[y - 1 : y + 2, x - 1 : x + 2], algorithm.fit)
        dx, dy, flag = peak(coefficients, printed=algorithm.fit == "printed")
        if algorithm.fit == "gradient":
            around = [slice(at - STEP_REACH, at + STEP_REACH + 1) for at in (y, x)]
            dx, dy, flag = gradient_steps(image[around[0], around[1]], (dx, dy, flag))
        found.append((x + dx, y + dy, max(value, 0), flag | (Flag(0) if accepted else Flag.TEXTURED)))
        cells.append((y // settings.cell_height, x // settings.cell_width))
    if settings.per_cell:
        found = strongest_of_cells(found, cells, settings.per_cell)
    ends = [end for end, (*_, flag) in enumerate(found, 1) if not flag & Flag.TEXTURED]
    if 0 < settings.max_corners <= len(ends):
        found = found[: ends[settings.max_corners - 1]]
    columns = np.array(found, dtype=np.float64).reshape(-1, 4).T
    return Corners(x=columns[0], y=columns[1], response=columns[2], flags=columns[3].astype(np.uint8))
