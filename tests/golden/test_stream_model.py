"""The model of a stream: one frame leaves its history to the next, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from golden import Corners, Parameters, Settings, StreamModel, check_image, decode, decode_frame_end, detect
from golden.frame import response_map
from tests.support.photographs import photograph

EVERYTHING = Settings(report_rejected=True)
PAPER = Parameters.profile("paper")


@pytest.fixture
def frames() -> list[NDArray[np.uint8]]:
    """Three different frames of different sizes."""
    return [
        photograph("camera")[100:260, 120:330],
        photograph("coins")[:100, :140],
        photograph("brick")[:64, :200],
    ]


def same(one: Corners, other: Corners) -> bool:
    fields = ("x", "y", "response", "flags")
    return all(np.array_equal(getattr(one, field), getattr(other, field)) for field in fields)


def test_first_frame_uses_the_constant_and_the_second_the_first_ones_maximum(
    frames: list[NDArray[np.uint8]],
) -> None:
    model = StreamModel(PAPER)
    settings = Settings(constant=3000, floor=10, report_rejected=True)
    previous = 3000
    for image in frames:
        result = model.process(image, settings)
        assert result.maximum == response_map(image, Parameters.profile("paper")).max()
        assert result.maximum != previous
        assert same(result.corners, detect(image, PAPER, settings=settings, reference=previous))
        assert not same(result.corners, detect(image, PAPER, settings=settings, reference=result.maximum))
        previous = result.maximum


def test_constant_reference_ignores_the_previous_frame(frames: list[NDArray[np.uint8]]) -> None:
    model = StreamModel(PAPER)
    settings = Settings(reference="constant", constant=3000, floor=10, report_rejected=True)
    for image in frames:
        assert same(
            model.process(image, settings).corners, detect(image, PAPER, settings=settings, reference=3000)
        )


def test_maximum_is_kept_through_a_frame_with_a_constant_reference(frames: list[NDArray[np.uint8]]) -> None:
    model = StreamModel(PAPER)
    maximum = model.process(frames[0], Settings(reference="constant")).maximum
    assert same(
        model.process(frames[1], EVERYTHING).corners,
        detect(frames[1], PAPER, settings=EVERYTHING, reference=maximum),
    )


def test_floor_keeps_noise_after_a_black_frame_from_being_corners() -> None:
    noise = np.random.default_rng(1).integers(0, 4, (60, 60)).astype(np.uint8)
    black = np.zeros((60, 60), np.uint8)
    model = StreamModel(PAPER)
    assert model.process(black).maximum == 0
    assert len(model.process(noise).corners) == 0
    assert model.process(black).maximum == 0
    assert len(model.process(noise, Settings(floor=1, sigma2=15)).corners) > 0


def test_end_of_every_frame_says_what_was_in_it(frames: list[NDArray[np.uint8]]) -> None:
    model = StreamModel(PAPER)
    for number, image in enumerate([*frames, np.zeros((15, 15), np.uint8)]):
        result = model.process(image)
        assert result.records.dtype == np.uint64
        end = decode_frame_end(int(result.records[-1]))
        assert end == (len(result.records) - 1, number, result.maximum, False)
        assert same(result.corners, decode(result.records)) and same(
            result.corners, decode(result.records[:-1])
        )
        assert len(result.corners) == end.records
    assert end == (0, 3, 0, False)


def test_reset_forgets_everything(frames: list[NDArray[np.uint8]]) -> None:
    model = StreamModel(PAPER)
    first = [model.process(image).records for image in frames]
    unreset = model.process(frames[0]).records
    assert not np.array_equal(unreset, first[0])
    model.reset()
    for image, records in zip(frames, first, strict=True):
        assert np.array_equal(model.process(image).records, records)


def test_refused_frame_leaves_no_trace(frames: list[NDArray[np.uint8]]) -> None:
    model, undisturbed = StreamModel(PAPER), StreamModel(PAPER)
    model.process(frames[0])
    undisturbed.process(frames[0])
    with pytest.raises(ValueError, match="image is 14x15; allowed: 15x15 to 1920x1080"):
        model.process(np.zeros((15, 14), np.uint8))
    with pytest.raises(ValueError, match="floor is 200000; allowed"):
        model.process(frames[1], Settings(floor=200000))
    assert np.array_equal(model.process(frames[1]).records, undisturbed.process(frames[1]).records)


def test_frame_never_changes_the_next_but_through_its_maximum(frames: list[NDArray[np.uint8]]) -> None:
    image = frames[0]
    one, other = StreamModel(PAPER), StreamModel(PAPER)
    maximum = one.process(image).maximum
    assert other.process(image[::-1, ::-1]).maximum == maximum  # another frame of the same maximum
    assert np.array_equal(one.process(frames[1]).records, other.process(frames[1]).records)


def test_default_settings_follow_the_pixel_width() -> None:
    image = photograph("camera")[:80, :80] >> 4
    model = StreamModel(Parameters.profile("paper", pixel_bits=4))
    first, second = model.process(image), model.process(image)
    assert same(first.corners, detect(image, model.parameters, reference=32))
    assert same(second.corners, detect(image, model.parameters))


@pytest.mark.parametrize("name", ["paper", "robust"])
def test_still_scene_settles_in_the_second_frame(photo: NDArray[np.uint8], name: str) -> None:
    parameters = Parameters.profile(name)
    image = check_image(photo, parameters)
    model = StreamModel(parameters)
    model.process(image, EVERYTHING)
    second, third = model.process(image, EVERYTHING), model.process(image, EVERYTHING)
    assert np.array_equal(second.records[:-1], third.records[:-1])
    assert same(second.corners, detect(image, parameters, EVERYTHING))
