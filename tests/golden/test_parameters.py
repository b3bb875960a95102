"""Every field refuses values that are not allowed, and says which are."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import FrozenInstanceError
from typing import Any, cast

import numpy as np
import pytest

from golden import StreamModel, check_image, detect
from golden.algorithm import DEFAULT_PROFILE, PROFILES, Algorithm, Gradient
from golden.formats import MAX_SIDE
from golden.options import options
from golden.parameters import Parameters
from golden.settings import Settings
from golden.video import VideoSettings
from tests.support.profiles import ADAPTIVE

RANGES = {
    "pixel_bits": (4, 10),
    "max_width": (15, 8192),
    "max_height": (15, 8192),
}
CHOICES = {
    "pixel_filter": ("none", "binomial", "twice"),
    "gradient": ("absolute", "signed"),
    "derivative": ("central", "sobel"),
    "response_filter": ("none", "binomial"),
    "ties": ("strict", "first"),
    "fit": ("nine", "six", "printed", "gradient"),
    "texture": ("patches", "mean", "none"),
    "patches": ("regions", "pixels"),
}


def refusal(cls: Callable[..., Any], **fields: Any) -> str:
    with pytest.raises(ValueError) as caught:
        cls(**fields)
    message = str(caught.value)
    assert "\n" not in message
    return message


@pytest.mark.parametrize("field", RANGES)
def test_whole_numbers_of_parameters(field: str) -> None:
    low, high = RANGES[field]
    for value in (low, high):
        assert Parameters.profile("paper", **{field: value}).as_dict()[field] == value
    for value in (low - 1, high + 1, float(low), "8", None, True):
        message = refusal(Parameters.profile, name="paper", **{field: value})
        assert message == f"{field} is {value!r}; allowed: whole numbers from {low} to {high}"


@pytest.mark.parametrize("field", CHOICES)
def test_choices_of_parameters(field: str) -> None:
    for value in CHOICES[field]:
        assert Parameters.profile("paper", **{field: value}).as_dict()[field] == value
    for value in ("other", "", None, 1, CHOICES[field][0].upper()):
        message = refusal(Parameters.profile, name="paper", **{field: value})
        assert message == f"{field} is {value!r}; allowed: {', '.join(CHOICES[field])}"


@pytest.mark.parametrize(("field", "limit"), [("sigma1", 1), ("sigma2", 16)])
def test_sigmas(field: str, limit: int) -> None:
    for value in (0, 0.0, limit / 2, math.nextafter(limit, 0), np.float64(0.25)):
        assert getattr(Settings(**{field: value}), field) == value
    for value in (-1e-9, limit, limit + 1.5, 10**400, math.nan, math.inf, -math.inf, "0.1", None, True, 1j):
        assert refusal(Settings, **{field: value}) == f"{field} is {value!r}; allowed: 0 <= {field} < {limit}"


@pytest.mark.parametrize("field", ["sigma1", "sigma2"])
@pytest.mark.parametrize("value", [1 / 131072, 1e-6, 5e-324])
def test_sigmas_that_would_be_nothing(field: str, value: float) -> None:
    message = refusal(Settings, **{field: value})
    assert message == f"{field} is {value!r}, less than half of 1/65536; allowed: 0, or 1/65536 and more"


@pytest.mark.parametrize("value", [2**-16, 0.1, 0.1249, 1.876, 5, 15.9])
def test_weights_that_the_local_mean_cannot_have(value: float) -> None:
    settings = Settings(sigma2=value)
    settings.check(Parameters.profile("paper"))
    for call in (
        lambda: settings.check(ADAPTIVE),
        lambda: detect(np.zeros((20, 20), np.uint8), ADAPTIVE, settings),
        lambda: StreamModel(ADAPTIVE).process(np.zeros((20, 20), np.uint8), settings),
        lambda: VideoSettings(20, 20, settings).check(ADAPTIVE),
    ):
        with pytest.raises(ValueError) as caught:
            call()
        allowed = "allowed with texture 'mean': 0, or 0.125 to 1.875, in eighths"
        assert str(caught.value) == f"sigma2 is {value!r}; {allowed}"


@pytest.mark.parametrize(
    ("value", "eighths", "plain"),
    [(0, 0, 0), (0.125, 1, 0.125), (0.3, 2, 19661 / 65536), (0.5, 4, 0.5), (1.874, 14, 122814 / 65536)],
)
def test_what_sigma2_is_rounded_to(value: float, eighths: int, plain: float) -> None:
    settings = Settings(sigma2=value)
    settings.check(ADAPTIVE)
    assert settings.sigma2_used(ADAPTIVE) == eighths / 8 and settings.mean_weight == eighths
    assert settings.sigma2_used(Parameters.profile("paper")) == plain


@pytest.mark.parametrize("field", ["constant", "floor"])
def test_whole_numbers_of_settings(field: str) -> None:
    for value in (1, 2093058):
        assert getattr(Settings(**{field: value}), field) == value
    for value in (0, 2093059, 1.0, None, False):
        message = refusal(Settings, **{field: value})
        assert message == f"{field} is {value!r}; allowed: whole numbers from 1 to 2093058"


def test_reference() -> None:
    for value in ("previous", "constant"):
        assert Settings(reference=value).reference == value
    assert refusal(Settings, reference="next") == "reference is 'next'; allowed: previous, constant"


@pytest.mark.parametrize("field", ["constant", "floor"])
def test_settings_are_checked_against_the_detector(field: str) -> None:
    other = {"constant": "floor", "floor": "constant"}[field]
    for pixel_bits, gradient, limit in (
        (4, "absolute", 226),
        (4, "signed", 450),
        (8, "absolute", 65026),
        (8, "signed", 130050),
        (10, "absolute", 1046530),
        (10, "signed", 2093058),
    ):
        parameters = Parameters.profile("paper", pixel_bits=pixel_bits, gradient=cast(Gradient, gradient))
        Settings(**{field: limit, other: 1}).check(parameters)
        if limit < 2093058:
            with pytest.raises(ValueError, match=f"^{field} is {limit + 1}; allowed: .* 1 to {limit}$"):
                Settings(**{field: limit + 1, other: 1}).check(parameters)


def test_default_settings_fit_every_detector() -> None:
    assert Settings.default(Parameters.profile("paper")) == Settings()
    for pixel_bits in range(4, 11):
        parameters = Parameters.profile("paper", pixel_bits=pixel_bits)
        Settings.default(parameters).check(parameters)
    four = Settings.default(Parameters.profile("paper", pixel_bits=4), sigma1=0.5, floor=3)
    assert four == Settings(sigma1=0.5, constant=32, floor=3)


@pytest.mark.parametrize(
    ("sigma", "fixed"),
    [(0, 0), (0.5, 32768), (0.1, 6554), (1.001 / 131072, 1), (3 / 131072, 2), (0.9999999, 65535)],
)
def test_sigma1_in_fixed_point(sigma: float, fixed: int) -> None:
    assert Settings(sigma1=sigma).sigma1_fixed == fixed


@pytest.mark.parametrize(
    ("sigma", "fixed"), [(0, 0), (0.2, 13107), (1, 65536), (15.5, 1015808), (15.9999999, 1048575)]
)
def test_sigma2_in_fixed_point(sigma: float, fixed: int) -> None:
    assert Settings(sigma2=sigma).sigma2_fixed == fixed


@pytest.mark.parametrize(
    (
        "pixel_bits",
        "pixel_max",
        "product_bits",
        "product_max",
        "root_bits",
        "radicand_bits",
        "absolute",
        "signed",
    ),
    [
        (4, 15, 8, 225, 9, 18, (8, 226), (9, 450)),
        (8, 255, 16, 65025, 17, 34, (16, 65026), (17, 130050)),
        (10, 1023, 20, 1046529, 21, 42, (20, 1046530), (21, 2093058)),
    ],
)
def test_number_formats_by_hand(
    pixel_bits: int,
    pixel_max: int,
    product_bits: int,
    product_max: int,
    root_bits: int,
    radicand_bits: int,
    absolute: tuple[int, int],
    signed: tuple[int, int],
) -> None:
    """``absolute`` and ``signed``: bits and full scale of the response of either gradient."""
    gradients: tuple[tuple[Gradient, tuple[int, int]], ...] = (("absolute", absolute), ("signed", signed))
    for gradient, response in gradients:
        parameters = Parameters.profile("paper", pixel_bits=pixel_bits, gradient=gradient)
        assert (parameters.pixel_max, parameters.product_bits) == (pixel_max, product_bits)
        assert (parameters.product_max, parameters.root_bits) == (product_max, root_bits)
        assert (parameters.response_bits, parameters.response_max) == response
        assert parameters.radicand_bits == radicand_bits


def test_texture_formats_by_hand() -> None:
    regions, pixels = (
        Parameters.profile("paper"),
        Parameters.profile("paper", patches="pixels", gradient="signed"),
    )
    assert (regions.pixels_per_region, regions.texture_max, regions.texture_bits) == (9, 72 * 65026, 23)
    assert (pixels.pixels_per_region, pixels.texture_max, pixels.texture_bits) == (1, 8 * 130050, 20)


def test_largest_side_fits_a_record() -> None:
    assert MAX_SIDE == 8192


def test_profiles() -> None:
    assert PROFILES["paper"] == Algorithm() == Parameters.profile("paper").algorithm
    assert Parameters() == Parameters.profile(DEFAULT_PROFILE) == Parameters.profile("robust")
    robust = Parameters.profile(
        "paper",
        pixel_filter="binomial",
        gradient="signed",
        response_filter="binomial",
        ties="first",
        divider="serial",
        texture="none",
    )
    assert Parameters.profile("robust") == robust
    assert Parameters.profile("robust", fit="six", max_width=640) == robust.changed(fit="six", max_width=640)
    with pytest.raises(ValueError, match=r"^profile is 'fast'; allowed: paper, robust, precise$"):
        Parameters.profile("fast")
    with pytest.raises(ValueError, match=r"^fit is 'ten'; allowed: nine, six, printed, gradient$"):
        Parameters.profile("paper", fit="ten")


def test_all_fields_by_name() -> None:
    found = Parameters.profile("paper", suppression=2, max_width=640).as_dict()
    assert list(found)[:3] == ["pixel_bits", "max_width", "max_height"]
    assert set(found) == {*options(Algorithm), *options(Parameters)}
    assert (found["suppression"], found["max_width"], found["gradient"]) == (2, 640, "absolute")


def test_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        Parameters.profile("paper").pixel_bits = 4
    with pytest.raises(FrozenInstanceError):
        Algorithm().fit = "six"
    with pytest.raises(FrozenInstanceError):
        Settings().sigma1 = 0.5


def test_numpys_integers_are_as_good_as_pythons() -> None:
    assert Parameters.profile("paper", max_width=np.int64(640)) == Parameters.profile("paper", max_width=640)
    assert type(Parameters.profile("paper", max_width=np.int64(640)).max_width) is int
    assert type(Settings(constant=np.uint16(5)).constant) is int


def test_only_plain_arrays_are_images() -> None:
    with pytest.raises(TypeError, match="image is a MaskedArray; allowed: a plain NumPy array"):
        check_image(np.ma.MaskedArray(np.zeros((20, 20), np.uint8)), Parameters.profile("paper"))
