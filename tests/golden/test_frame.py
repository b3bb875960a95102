"""One frame by its steps: what they hand to each other, and the history they leave."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from golden import decode, detect
from golden.algorithm import PROFILES
from golden.frame import Frame, History, response_map
from golden.parameters import Parameters
from golden.settings import Settings
from golden.subpixel import FITS

SETTINGS = Settings(sigma1=0.02, report_rejected=True)
every_profile = pytest.mark.parametrize("profile", PROFILES)


@pytest.fixture
def image(camera: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A part of a photograph, with corners near every edge."""
    return camera[90:190, 180:300]


@every_profile
def test_records_are_of_the_candidates(image: NDArray[np.uint8], profile: str) -> None:
    frame = Frame(image, Parameters.profile(profile), SETTINGS)
    _, limits = frame.own_thresholds()
    candidates, corners = frame.candidates(limits), decode(frame.records(limits))
    assert len(corners) == len(candidates.x) > 20
    assert np.array_equal(corners.response, candidates.response)
    assert np.array_equal(corners.accepted, candidates.accepted)
    reach = FITS[frame.parameters.algorithm.fit].limit / 128
    assert np.abs(corners.x - candidates.x).max() <= reach
    assert np.abs(corners.y - candidates.y).max() <= reach
    assert corners == detect(image, frame.parameters, SETTINGS)


@every_profile
def test_candidates_are_maxima(image: NDArray[np.uint8], profile: str) -> None:
    frame = Frame(image, Parameters.profile(profile), SETTINGS)
    _, limits = frame.own_thresholds()
    candidates = frame.candidates(limits)
    margin = frame.parameters.algorithm.margin
    places = np.stack([candidates.y, candidates.x], axis=1) - margin
    assert np.argwhere(frame.maxima(limits.t1)).tolist() == places.tolist()
    assert frame.maxima(0).shape == (image.shape[0] - 2 * margin, image.shape[1] - 2 * margin)
    assert frame.maximum > limits.t1


@every_profile
def test_pixels_that_came_decide_the_first_records(image: NDArray[np.uint8], profile: str) -> None:
    """However the frame goes on, and not one corner sooner or later than its support is there."""
    frame = Frame(image, Parameters.profile(profile), SETTINGS)
    _, limits = frame.own_thresholds()
    x, y, *_ = frame.candidates(limits)
    records, width, margin = frame.records(limits), image.shape[1], frame.parameters.algorithm.margin
    for k, last in enumerate(((y + margin) * width + x + margin).tolist()):
        white = image.copy()
        white.ravel()[last + 1 :] = 255
        cut = Frame(white, frame.parameters, SETTINGS)
        assert np.array_equal(cut.records(limits, pixels=last + 1), records[: k + 1])
        assert np.array_equal(cut.records(limits, pixels=last), records[:k])


def test_responses_can_be_given(image: NDArray[np.uint8]) -> None:
    parameters = Parameters.profile("paper")
    doubled = Frame(image, parameters, SETTINGS, response_map(image, parameters) * 2)
    plain = Frame(image, parameters, SETTINGS)
    assert doubled.maximum == 2 * plain.maximum
    assert np.array_equal(
        doubled.candidates(doubled.own_thresholds()[1]).x, plain.candidates(plain.own_thresholds()[1]).x
    )


def test_history_without_target_or_rank_is_the_largest_response(image: NDArray[np.uint8]) -> None:
    frame = Frame(image, Parameters.profile("paper"), SETTINGS)
    reference, limits = frame.thresholds(History())
    assert reference == SETTINGS.constant
    assert frame.next_history(limits, History()) == History(frame.maximum, None)
    assert frame.thresholds(History(frame.maximum))[0] == frame.maximum
    assert frame.thresholds(History(frame.maximum), reference=77)[0] == 77


@every_profile
@pytest.mark.parametrize("smoothing", [0, 2])
def test_history_with_a_target(image: NDArray[np.uint8], profile: str, smoothing: int) -> None:
    parameters = Parameters.profile(profile, budget=True)
    settings = Settings(target_corners=10, smoothing=smoothing)
    frame = Frame(image, parameters, settings)
    _, limits = frame.thresholds(History())
    first = frame.next_history(limits, History())
    assert first.maximum == frame.maximum and first.adapted is not None
    before = first.adapted + 4000
    second = frame.next_history(limits, History(frame.maximum, before))
    assert second.adapted == first.adapted + (4000 - 4000 // 2**smoothing)
