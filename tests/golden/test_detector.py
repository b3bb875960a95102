"""The blocks together: what detect takes, refuses and finds in drawings."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from golden import Parameters, Settings, check_image, detect, reference_detect
from golden.convolution import smooth
from golden.corner_detection import corner_detection
from golden.frame import response_map
from golden.preprocessing import gradients, products
from golden.response import response
from tests.support.profiles import ADAPTIVE

SMALL = Parameters.profile("paper", max_width=40, max_height=30)
ALL = Settings(sigma1=0.1, report_rejected=True)


def refusal(kind: type[Exception], image: Any, parameters: Parameters = SMALL, **arguments: Any) -> str:
    with pytest.raises(kind) as caught:
        detect(image, parameters, **arguments)
    message = str(caught.value)
    assert "\n" not in message
    return message


def test_image_must_be_an_array() -> None:
    assert refusal(TypeError, [[1, 2], [3, 4]]) == "image is a list; allowed: a plain NumPy array"


@pytest.mark.parametrize("dtype", [np.uint16, np.int8, np.int64, np.float32, np.float64, np.bool_])
def test_image_must_have_the_pixels_dtype(dtype: type) -> None:
    image = np.zeros((20, 20), dtype)
    assert refusal(TypeError, image) == f"image has dtype {image.dtype}; allowed: uint8 (8-bit pixels)"


def test_wide_pixels_come_in_16_bits() -> None:
    ten = Parameters.profile("paper", pixel_bits=10)
    assert "allowed: uint16 (10-bit pixels)" in refusal(TypeError, np.zeros((20, 20), np.uint8), ten)
    message = refusal(ValueError, np.full((20, 20), 1024, np.uint16), ten)
    assert message == "image has a pixel of 1024; allowed: 0 to 1023"
    assert len(detect(np.full((20, 20), 1023, np.uint16), ten)) == 0


def test_narrow_pixels_come_in_8_bits() -> None:
    four = Parameters.profile("paper", pixel_bits=4)
    message = refusal(ValueError, np.full((20, 20), 16, np.uint8), four)
    assert message == "image has a pixel of 16; allowed: 0 to 15"
    assert len(detect(np.full((20, 20), 15, np.uint8), four)) == 0


@pytest.mark.parametrize("shape", [(20,), (20, 20, 3), (1, 20, 20), ()])
def test_image_must_have_one_channel(shape: tuple[int, ...]) -> None:
    message = refusal(ValueError, np.zeros(shape, np.uint8))
    assert message == f"image has shape {shape}; allowed: (height, width), one channel"


@pytest.mark.parametrize("shape", [(14, 20), (20, 14), (0, 0), (31, 20), (20, 41)])
def test_image_must_fit(shape: tuple[int, int]) -> None:
    message = refusal(ValueError, np.zeros(shape, np.uint8))
    assert message == f"image is {shape[1]}x{shape[0]}; allowed: 15x15 to 40x30 (the built maximum)"


@pytest.mark.parametrize("shape", [(15, 15), (30, 40), (15, 40), (30, 15)])
def test_smallest_and_largest_images_pass(shape: tuple[int, int]) -> None:
    image = np.zeros(shape, np.uint8)
    assert check_image(image, SMALL) is image
    assert len(detect(image, SMALL)) == 0


@pytest.mark.parametrize("reference", [-1, 65027, 0.5, "9", True])
def test_reference_must_be_a_response(reference: Any) -> None:
    message = refusal(ValueError, np.zeros((20, 20), np.uint8), reference=reference)
    assert message == f"reference is {reference!r}; allowed: whole numbers from 0 to 65026"


@pytest.mark.parametrize("reference", [0, 65026, np.int64(9)])
def test_reference_may_be_any_response(reference: Any) -> None:
    assert len(detect(np.zeros((20, 20), np.uint8), reference=reference)) == 0


def test_settings_beyond_the_detectors_range_are_refused() -> None:
    message = refusal(
        ValueError,
        np.zeros((20, 20), np.uint8),
        Parameters.profile("paper", pixel_bits=4),
        settings=Settings(constant=227, floor=1),
    )
    assert message == "constant is 227; allowed: whole numbers from 1 to 226"


def corner_in_the_middle(shape: tuple[int, int] = (15, 15), y: int = 7, x: int = 7) -> np.ndarray:
    # four pixels around (y, x) in a saddle: the response is largest at (y, x), by symmetry
    image = np.full(shape, 128, np.uint8)
    image[y - 1, x - 1] = image[y + 1, x + 1] = 255
    image[y - 1, x + 1] = image[y + 1, x - 1] = 0
    return image


def test_one_corner_in_the_smallest_image() -> None:
    corners = detect(corner_in_the_middle(), settings=ALL)
    assert (corners.x.tolist(), corners.y.tolist()) == ([7.0], [7.0])


def test_corners_are_reported_only_where_their_whole_support_lies_in_the_frame() -> None:
    # without the response filter, which gives a pattern of four pixels two peaks
    parameters = Parameters.profile("robust", response_filter="none")
    height, width, margin = 19, 23, parameters.algorithm.margin
    found = set()
    for y in range(1, height - 1):
        for x in range(1, width - 1):
            corners = detect(corner_in_the_middle((height, width), y, x), parameters, ALL)
            found |= {(y, x)} & set(zip(corners.y.tolist(), corners.x.tolist(), strict=True))
    assert found == {(y, x) for y in range(margin, height - margin) for x in range(margin, width - margin)}


def square() -> np.ndarray:
    image = np.zeros((40, 40), np.uint8)
    image[12:28, 12:28] = 255
    return image


@pytest.mark.parametrize("gradient", ["absolute", "signed"])
def test_square_has_four_corners(gradient: str) -> None:
    corners = detect(square(), Parameters.profile("paper", gradient=gradient), ALL)
    # a square known to half a pixel: the peak of D lies inside the corner
    assert sorted(zip(corners.x.tolist(), corners.y.tolist(), strict=True)) == [
        (12.5, 12.5),
        (12.5, 26.5),
        (26.5, 12.5),
        (26.5, 26.5),
    ]
    assert len(set(corners.response.tolist())) == 1


def test_absolute_gradients_all_but_lose_edges_at_45_degrees() -> None:
    """I = 4 (y + |x|): gx = ±8, or 0 at x = 0, gy = -8; the kernel's middle column weighs 16/64."""
    y, x = np.mgrid[-10:11, -10:11]
    image = (60 + 4 * (y + np.abs(x))).astype(np.uint8)
    absolute = response_map(image, Parameters.profile("paper", gradient="absolute"))
    signed = response_map(image, Parameters.profile("paper", gradient="signed"))
    # A = 64 · 48/64, B = 64, and C = A, or 0 where its signs cancel
    assert (absolute[:, 7] == 48 + 64 - 97).all()  # isqrt(16² + 96²) = 97
    assert (signed[:, 7] == 48 + 64 - 16).all()
    for straight_edge in (absolute[:, :5], absolute[:, 10:], signed[:, :5], signed[:, 10:]):
        assert not straight_edge.any()


@pytest.mark.parametrize("parameters", [Parameters.profile("paper"), ADAPTIVE], ids=["patches", "mean"])
def test_rejected_corners_come_on_request_and_change_nothing_else(
    camera: np.ndarray, parameters: Parameters
) -> None:
    everything = detect(camera, parameters, Settings(report_rejected=True))
    accepted = detect(camera, parameters, Settings())
    assert 0 < len(accepted) < len(everything)
    assert accepted.accepted.all()
    for field in ("x", "y", "response", "flags"):
        assert (getattr(everything, field)[everything.accepted] == getattr(accepted, field)).all()


def test_corners_come_in_raster_order(camera: np.ndarray) -> None:
    corners = detect(camera, Parameters.profile("paper"), ALL)
    responses = response_map(camera, Parameters.profile("paper"))
    rows, columns = np.nonzero(
        corner_detection(responses[3:-3, 3:-3], int(corners.response.min()) - 1, "strict")
    )
    assert len(corners) == len(rows) > 100
    assert (corners.response == responses[rows + 4, columns + 4]).all()
    assert np.abs(corners.y - (rows + 7)).max() == np.abs(corners.x - (columns + 7)).max() == 0.5


@pytest.mark.parametrize("height", [15, 37, 38, 39, 69, 70, 71, 134, 198])
def test_strips_leave_no_seam(camera: np.ndarray, height: int) -> None:
    image = camera[200 : 200 + height, 180:240]
    a, b, c = (smooth(product) for product in products(*gradients(image), "signed"))
    parameters = Parameters.profile("paper", gradient="signed")
    assert (response_map(image, parameters) == response(a, b, c, parameters)).all()


@pytest.mark.parametrize("detector", [detect, reference_detect])
def test_input_may_be_any_view_and_stays_as_it_was(camera: np.ndarray, detector: Any) -> None:
    view = np.rot90(camera[100:200, 200:320])[:, ::-1]
    before = view.copy()
    corners, again = detector(view), detector(np.ascontiguousarray(view))
    assert len(corners) > 0 and (corners.x == again.x).all() and (corners.y == again.y).all()
    assert (view == before).all()
