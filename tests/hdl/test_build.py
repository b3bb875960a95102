"""What hardware has beside its parameters: what is refused, and what each profile is built with."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from golden import Parameters
from golden.algorithm import PROFILES
from hdl.build import BUILDS, Build
from tests.support.detectors import MIXTURES

RANGES = {"sqrt_bits_per_stage": (1, 17), "queue_depth": (8, 1024), "refinement_units": (0, 4)}


@pytest.mark.parametrize("field", RANGES)
def test_whole_numbers(field: str) -> None:
    low, high = RANGES[field]
    for value in (low, high):
        assert getattr(Build(**{field: value}), field) == value
    for value in (low - 1, high + 1, float(low), "8", None, True):
        with pytest.raises(ValueError) as caught:
            Build(**{field: value})
        assert str(caught.value) == f"{field} is {value!r}; allowed: whole numbers from {low} to {high}"


@pytest.mark.parametrize("value", ["other", "", None, 1, "LEAN"])
def test_buffering(value: Any) -> None:
    with pytest.raises(ValueError) as caught:
        Build(buffering=value)
    assert str(caught.value) == f"buffering is {value!r}; allowed: banked, lean"


@pytest.mark.parametrize("field", ["video_out", "autostart"])
def test_switches(field: str) -> None:
    assert getattr(Build(**{field: True}), field) is True
    with pytest.raises(ValueError, match=f"^{field} is 1; allowed: True or False$"):
        Build(**{field: 1})


def test_units() -> None:
    """As many as photographs need, unless another number is asked for; one for gradient steps."""
    for lanes, units, bits in ((1, 1, 1), (2, 1, 1), (4, 1, 2), (8, 2, 2)):
        build = Build(pixels_per_clock=lanes)
        assert (build.units, build.refinement_bits) == (units, bits)
        assert Build(pixels_per_clock=lanes, refinement_units=3).units == 3
        assert Build.profile("precise", pixels_per_clock=lanes, refinement_units=1).units == 1
    message = "^refinement_units is 2; allowed with fit 'gradient': 0, 1$"
    with pytest.raises(ValueError, match=message):
        Build.profile("precise", refinement_units=2)


def test_profiles() -> None:
    assert set(BUILDS) == set(PROFILES)
    assert Build.profile("paper").buffering == "banked" and Build.profile("robust") == Build()
    other = Build.profile("paper", buffering="lean", fit="six", pixel_bits=4)
    assert (other.buffering, other.algorithm.fit, other.pixel_bits) == ("lean", "six", 4)
    assert other.changed(fit="nine", pixel_bits=8) == Build.profile("paper", buffering="lean")


def test_what_is_shared_with_the_golden_model_is_refused_alike() -> None:
    for fields in ({"fit": "ten"}, {"pixel_bits": 3}, {"suppression": 5}):
        messages = []
        for kind in (Parameters, Build):
            with pytest.raises(ValueError) as caught:
                kind.profile("robust", **fields)
            messages.append(str(caught.value))
        assert messages[0] == messages[1]


@pytest.mark.parametrize("lanes", [2, 4, 8])
@pytest.mark.parametrize("mixture", MIXTURES.values(), ids=MIXTURES.keys())
def test_the_narrowest_frame_leaves_three_beats_of_responses(mixture: Build, lanes: int) -> None:
    """Line buffers need as many."""
    build = replace(mixture, pixels_per_clock=lanes)
    lost = 2 * build.algorithm.response_margin // lanes
    assert -(-build.min_width // lanes) - lost >= 3


def test_a_small_window_behind_smoothed_pixels_takes_a_wider_frame() -> None:
    """Eight columns are lost, two beats of four, and three beats stay: of 17 pixels, not of 15."""
    build = Build.profile("robust", texture="none", response_filter="none", suppression=1, pixels_per_clock=4)
    assert build.algorithm.support == 11 and build.min_width == 17
