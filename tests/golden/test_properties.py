"""Properties that follow from the formulas for every image."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden import Corners, Parameters, Settings, StreamModel, detect
from golden.convolution import smooth
from golden.frame import Frame, response_map
from golden.output_constructor import Flag
from golden.pixel_filter import pixel_filter
from golden.preprocessing import gradients, products
from golden.subpixel import FITS
from tests.support.offsets import bounds
from tests.support.strategies import detectors, images

Image = NDArray[np.unsignedinteger[Any]]
EVERYTHING = Settings(sigma1=0.0, sigma2=0.2, floor=1, report_rejected=True)
"""Every maximum is reported, with the texture filter's verdict."""
CONSTANT = Settings(sigma1=0.01, reference="constant", constant=2000, floor=1, report_rejected=True)

Turn = tuple[
    Callable[[Image], Image], Callable[[Corners, int, int], tuple[NDArray[np.float64], NDArray[np.float64]]]
]
TURNS: dict[str, Turn] = {
    "mirror x": (lambda image: image[:, ::-1], lambda c, height, width: (width - 1 - c.x, c.y)),
    "mirror y": (lambda image: image[::-1], lambda c, height, width: (c.x, height - 1 - c.y)),
    "transpose": (lambda image: image.T, lambda c, height, width: (c.y, c.x)),
    "quarter turn": (lambda image: np.rot90(image), lambda c, height, width: (c.y, width - 1 - c.x)),
    "half turn": (
        lambda image: np.rot90(image, 2),
        lambda c, height, width: (width - 1 - c.x, height - 1 - c.y),
    ),
}


def rows(
    corners: Corners, x: NDArray[np.float64] | None = None, y: NDArray[np.float64] | None = None
) -> list[tuple[float, ...]]:
    """Corners in an order that does not depend on the raster."""
    x = corners.x if x is None else x
    y = corners.y if y is None else y
    fields = (y, x, corners.response, corners.flags)
    return sorted(zip(*(field.tolist() for field in fields), strict=True))


class Found(NamedTuple):
    """The corners of an image at whole pixels, and each one's limit of the error of its offset."""

    corners: Corners
    pixels: Corners
    limits: NDArray[np.float64]


def find(image: Image, parameters: Parameters) -> Found:
    corners = detect(image, parameters, EVERYTHING)
    frame = Frame(image, parameters, EVERYTHING)
    rows, columns = np.nonzero(frame.maxima(0))
    y, x = rows + parameters.algorithm.margin, columns + parameters.algorithm.margin
    pixels = Corners(x + 0.0, y + 0.0, corners.response, corners.flags)
    assert len(pixels.x) == len(corners)
    around = parameters.algorithm.suppression - 1
    patches = sliding_window_view(frame.peaks, (3, 3))[rows + around, columns + around]
    return Found(corners, pixels, bounds(patches, parameters))


even_handed = detectors(ties="strict", fit="nine") | detectors(ties="strict", fit="gradient")
"""Detectors in which neither ties nor the six samples prefer a direction."""


# where a step can be trusted has no bound: see tests/golden/test_gradient_steps.py for its turns
@given(images(), detectors(ties="strict", fit="nine"), st.sampled_from(sorted(TURNS)))
def test_turning_the_image_turns_the_corners(image: Image, parameters: Parameters, turn: str) -> None:
    """The pixel, response and verdict of each corner are exact, its offset within its bound."""
    turn_image, turn_corners = TURNS[turn]
    one, other = find(image, parameters), find(turn_image(image), parameters)
    x, y = turn_corners(one.pixels, *image.shape)
    by_place, by_turned_place = np.lexsort((other.pixels.x, other.pixels.y)), np.lexsort((x, y))
    assert np.array_equal(other.pixels.x[by_place], x[by_turned_place])
    assert np.array_equal(other.pixels.y[by_place], y[by_turned_place])
    textured = [found.corners.flags & Flag.TEXTURED for found in (one, other)]
    assert np.array_equal(textured[1][by_place], textured[0][by_turned_place])
    assert np.array_equal(other.corners.response[by_place], one.corners.response[by_turned_place])
    x, y = turn_corners(one.corners, *image.shape)
    apart = other.limits[by_place] + one.limits[by_turned_place]
    assert (np.abs(other.corners.x[by_place] - x[by_turned_place]) <= apart).all()
    assert (np.abs(other.corners.y[by_place] - y[by_turned_place]) <= apart).all()


@given(images(), even_handed)
def test_exchanging_x_and_y_exchanges_them_in_the_records(image: Image, parameters: Parameters) -> None:
    corners = detect(image, parameters, EVERYTHING)
    turned = detect(image.T, parameters, EVERYTHING)
    assert rows(turned) == rows(corners, corners.y, corners.x)


@given(images(), detectors(), st.sampled_from(sorted(TURNS)))
def test_turning_the_image_turns_the_response(image: Image, parameters: Parameters, turn: str) -> None:
    # holds for ties and fits that prefer a direction too
    turn_map = TURNS[turn][0]
    responses = response_map(image, parameters)
    assert (response_map(turn_map(image), parameters) == turn_map(responses)).all()


@given(images(), detectors(), st.data())
def test_adding_a_constant_changes_nothing(image: Image, parameters: Parameters, data: st.DataObject) -> None:
    shift = data.draw(st.integers(-int(image.min()), 255 - int(image.max())))
    shifted = (image.astype(np.int64) + shift).astype(np.uint8)
    assert rows(detect(shifted, parameters, EVERYTHING)) == rows(detect(image, parameters, EVERYTHING))


@given(images(), detectors(), st.booleans())
def test_image_without_gradients_across_has_no_corner(
    image: Image, parameters: Parameters, down: bool
) -> None:
    stripes = np.broadcast_to(image[:, :1] if down else image[:1], image.shape)
    flat = np.full_like(image, image[0, 0])
    for without in (stripes, flat):
        assert not response_map(without, parameters).any()
        assert len(detect(without, parameters, EVERYTHING)) == 0


@given(images(max_side=60), detectors(), st.data())
def test_cropping_changes_nothing_further_than_the_margin_away(
    image: Image, parameters: Parameters, data: st.DataObject
) -> None:
    height, width = image.shape
    least, margin = parameters.algorithm.support, parameters.algorithm.margin
    top, left = data.draw(st.integers(0, height - least)), data.draw(st.integers(0, width - least))
    bottom, right = data.draw(st.integers(top + least, height)), data.draw(st.integers(left + least, width))
    whole = detect(image, parameters, CONSTANT)
    crop = detect(image[top:bottom, left:right], parameters, CONSTANT)

    crop_rows = rows(crop, crop.x + left, crop.y + top)
    whole_rows = rows(whole)
    # two peaks may lead to one place, and be equal in all else
    assert Counter(crop_rows) <= Counter(whole_rows)
    # a corner strictly inside this rectangle is centred `margin` or more from every new edge
    reach = margin - 1 + FITS[parameters.algorithm.fit].limit / 128
    expected = [
        row
        for row in whole_rows
        if top + reach < row[0] < bottom - 1 - reach and left + reach < row[1] < right - 1 - reach
    ]
    assert Counter(expected) <= Counter(crop_rows)


@given(images(), detectors())
def test_response_is_between_zero_and_the_trace(image: Image, parameters: Parameters) -> None:
    pixels = pixel_filter(image, parameters.algorithm.pixel_passes)
    a, b, _ = (
        smooth(product)
        for product in products(
            *gradients(pixels, parameters.algorithm.derivative), parameters.algorithm.gradient
        )
    )
    responses = response_map(image, parameters)
    assert (responses >= 0).all() and (responses <= a + b).all()
    assert responses.shape == tuple(side - 2 * parameters.algorithm.response_margin for side in image.shape)


@given(images(), detectors())
def test_how_large_a_frame_may_be_never_changes_a_record(image: Image, parameters: Parameters) -> None:
    one, two = StreamModel(parameters), StreamModel(replace(parameters, max_width=64))
    for _ in range(2):
        assert (one.process(image, EVERYTHING).records == two.process(image, EVERYTHING).records).all()


@given(images(), detectors(), st.sampled_from([0.0, 0.01, 0.1, 0.5]))
def test_sigmas_only_take_away(image: Image, parameters: Parameters, sigma1: float) -> None:
    everything = rows(detect(image, parameters, EVERYTHING))
    fewer = rows(
        detect(image, parameters, Settings(sigma1=sigma1, sigma2=0.2, floor=1, report_rejected=True))
    )
    assert set(fewer) <= set(everything)
    assert all(row[2] > sigma1 * row[2] for row in fewer)


@given(images(), detectors(ties="strict"))
def test_first_keeps_every_strict_corner(image: Image, parameters: Parameters) -> None:
    strict = rows(detect(image, parameters, EVERYTHING))
    first = rows(detect(image, parameters.changed(ties="first"), EVERYTHING))
    assert set(strict) <= set(first)


@given(images(pixel_bits=8), detectors())
def test_wider_pixels_of_the_same_values_give_the_same_corners(image: Image, parameters: Parameters) -> None:
    ten = detect(image.astype(np.uint16), replace(parameters, pixel_bits=10), EVERYTHING)
    assert rows(ten) == rows(detect(image, parameters, EVERYTHING))
