"""Images with the largest numbers of all kinds: none may exceed the width in Parameters."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from golden import Parameters, Settings, StreamModel
from golden.algorithm import Fit, Gradient, Patches
from golden.convolution import smooth
from golden.frame import response_map
from golden.preprocessing import gradients, products
from golden.response import response
from golden.subpixel import FITS, derivative_bits, mantissas
from golden.texture_filter import texturization

SIDE = 36
PIXEL_BITS = (4, 8, 10)
GRADIENTS: tuple[Gradient, ...] = ("absolute", "signed")


def extremes(pixel_bits: int) -> Iterator[tuple[str, NDArray[np.unsignedinteger[Any]]]]:
    """Checkerboards, stripes and diagonals of every small period, black and white; flat; noise."""
    top = (1 << pixel_bits) - 1
    dtype = np.uint8 if pixel_bits <= 8 else np.uint16
    y, x = np.mgrid[:SIDE, :SIDE]
    for period in range(1, 9):
        for other in range(1, 9):
            yield f"checkerboard {period}x{other}", ((x // period + y // other) % 2 * top).astype(dtype)
        yield f"stripes {period}", (x // period % 2 * top).astype(dtype)
        yield f"diagonals {period}", ((x + y) // period % 2 * top).astype(dtype)
        yield f"rings {period}", (np.maximum(abs(x - 17), abs(y - 17)) // period % 2 * top).astype(dtype)
        yield f"diamonds {period}", ((abs(x - 17) + abs(y - 17)) // period % 2 * top).astype(dtype)
    yield "black", np.zeros((SIDE, SIDE), dtype)
    yield "white", np.full((SIDE, SIDE), top, dtype)
    rng = np.random.default_rng(1)
    for k in range(5):
        yield f"noise {k}", rng.integers(0, top + 1, (SIDE, SIDE)).astype(dtype)
        yield f"black and white noise {k}", (rng.integers(0, 2, (SIDE, SIDE)) * top).astype(dtype)
        yield f"faint noise {k}", rng.integers(0, 3, (SIDE, SIDE)).astype(dtype)


def largest(pixel_bits: int, gradient: Gradient) -> dict[str, int]:
    """Largest magnitude of every intermediate over all extreme images."""
    seen: dict[str, int] = {}

    def note(name: str, values: NDArray[Any]) -> None:
        seen[name] = max(seen.get(name, 0), int(np.abs(values.astype(np.int64)).max()))

    for _, image in extremes(pixel_bits):
        gx, gy = gradients(image)
        note("gradient", gx)
        note("gradient", gy)
        raw = products(gx, gy, gradient)
        a, b, c = (smooth(product) for product in raw)
        for product, smoothed in zip(raw, (a, b, c), strict=True):
            note("product", product)
            note("smoothed", smoothed)
        radicand = (a.astype(np.int64) - b) ** 2 + 4 * c.astype(np.int64) ** 2
        note("radicand", radicand)
        responses = response_map(image, Parameters.profile("paper", pixel_bits=pixel_bits, gradient=gradient))
        assert responses.min() >= 0
        note("response", responses)
        windows = sliding_window_view(responses, (9, 9))
        patches: Patches
        for patches in ("regions", "pixels"):
            note(patches, texturization(windows, patches))
    return seen


@pytest.mark.parametrize("gradient", GRADIENTS)
@pytest.mark.parametrize("pixel_bits", PIXEL_BITS)
def test_every_intermediate_keeps_its_width(pixel_bits: int, gradient: Gradient) -> None:
    parameters = Parameters.profile("paper", pixel_bits=pixel_bits, gradient=gradient)
    seen = largest(pixel_bits, gradient)
    # these are reached: not one bit less would do
    assert seen["gradient"] == parameters.pixel_max
    assert seen["product"] == seen["smoothed"] == parameters.product_max
    assert seen["product"].bit_length() == parameters.product_bits
    assert seen["radicand"].bit_length() == parameters.radicand_bits
    assert seen["response"] <= parameters.response_max < 1 << parameters.response_bits
    for patches in ("regions", "pixels"):
        limit = Parameters.profile("paper", pixel_bits=pixel_bits, patches=patches)
        assert seen[patches] <= limit.texture_max < 1 << limit.texture_bits


@pytest.mark.parametrize("gradient", GRADIENTS)
def test_clamp_of_the_response_is_reached_and_by_one_unit_only(gradient: Gradient) -> None:
    # rounding must make small A and B smaller, and C larger: faint dots, far from each other
    rng = np.random.default_rng(1)
    dots = (rng.random((300, 300)) < 0.1) * rng.integers(1, 4, (300, 300))
    image = dots.astype(np.uint8)
    a, b, c = (smooth(product).astype(np.int64) for product in products(*gradients(image), gradient))
    unclamped = a + b - np.floor(np.sqrt((a - b) ** 2 + 4 * c**2))
    assert unclamped.min() == -1
    responses = response_map(image, Parameters.profile("paper", gradient=gradient))
    assert (responses == np.maximum(unclamped, 0)).all()


@pytest.mark.parametrize("pixel_bits", PIXEL_BITS)
def test_full_scale_of_absolute_gradients_is_half_of_all_products(pixel_bits: int) -> None:
    """Tensors of every pair of gradients, mixed at random; the half without C is most."""
    parameters = Parameters.profile("paper", pixel_bits=pixel_bits)
    top = parameters.pixel_max
    rng = np.random.default_rng(pixel_bits)
    kernel = np.outer([1, 2, 2, 2, 1], [1, 2, 2, 2, 1]).ravel()
    largest_response = 0
    for low in (0, top // 2, top - 2, top):
        # in each of the 25 places, one gradient is large and the other one small
        large = rng.integers(low, top, (20_000, 25), endpoint=True)
        small = rng.integers(0, top - low, (20_000, 25), endpoint=True)
        turned = rng.random((20_000, 25)) < 0.5
        gx, gy = np.where(turned, large, small), np.where(turned, small, large)
        a, b, c = (((kernel * product).sum(axis=1) + 32) >> 6 for product in products(gx, gy, "absolute"))
        largest_response = max(largest_response, int(response(a, b, c, parameters).max()))
    assert parameters.product_max - 1 <= largest_response <= parameters.response_max


@pytest.mark.parametrize("pixel_bits", PIXEL_BITS)
def test_full_scale_of_the_response_needs_its_top_bit(pixel_bits: int) -> None:
    # both gradients at full scale everywhere and their products' signs in balance: D comes close to
    # A + B
    parameters = Parameters.profile("paper", pixel_bits=pixel_bits, gradient="signed")
    largest_response = max(int(response_map(image, parameters).max()) for _, image in extremes(pixel_bits))
    assert largest_response.bit_length() == parameters.response_bits


@pytest.mark.parametrize("name", ["paper", "robust"])
@pytest.mark.parametrize("pixel_bits", PIXEL_BITS)
def test_records_of_extreme_images(pixel_bits: int, name: str) -> None:
    gradient: Gradient = "signed" if name == "robust" else "absolute"
    parameters = Parameters.profile("paper", pixel_bits=pixel_bits, gradient=gradient)
    model = StreamModel(parameters)
    settings = Settings(sigma1=0.0, floor=1, constant=1, report_rejected=True)
    for title, image in extremes(pixel_bits):
        result = model.process(image, settings)
        corners = result.corners
        assert len(corners) == len(result.records) - 1, title
        assert ((corners.x >= 6.5) & (corners.x <= SIDE - 7.5)).all(), title
        assert ((corners.y >= 6.5) & (corners.y <= SIDE - 7.5)).all(), title
        assert (corners.response > 0).all() and (corners.response <= result.maximum).all(), title


@pytest.mark.parametrize("fit", ["nine", "six"])
@pytest.mark.parametrize("pixel_bits", PIXEL_BITS)
def test_every_number_of_the_subpixel_refinement_keeps_its_width(pixel_bits: int, fit: Fit) -> None:
    """Sums of responses around any pixel, and of random responses at both ends of their range."""
    parameters = Parameters.profile("paper", pixel_bits=pixel_bits, gradient="signed", fit=fit)
    patches = [np.random.default_rng(1).integers(0, 2, (5000, 3, 3)) * parameters.response_max]
    for _, image in extremes(pixel_bits):
        patches.append(sliding_window_view(response_map(image, parameters), (3, 3)).reshape(-1, 3, 3))
    values = FITS[fit].derivatives(np.concatenate(patches))
    bits = derivative_bits(parameters)
    assert max(int(np.abs(value).max()) for value in values).bit_length() == bits
    xx, yy, xy, x, y = cut = mantissas(values, bits, 10)
    top = 1 << 10
    # a negative one may round down to a whole power of two
    assert -top <= min(int(value.min()) for value in cut)
    assert top // 2 <= max(int(value.max()) for value in cut) < top
    for total in (xx * yy - xy * xy, yy * x + xy * y, xx * y + xy * x):
        assert int(np.abs(total).max()) < 1 << (2 * 10 + 1)
